# SPDX-License-Identifier: BSD-3-Clause
"""Projections of maps, as GDAL knows them. A projection is kept as text (WKT, or what a .prj file says)."""

import numpy as np

from .raster import Raster, TerrainError, load_gdal

SAME = 1e-3  # [m]: places that differ by less are the same, whatever their projections are called


def reference(text: str, where: str):
    """The osr.SpatialReference of a text: WKT, the lines of a .prj file, or a name such as EPSG:31287.

    Its coordinates are in the order of maps: east, north. @raises TerrainError
    """
    _, _, osr = load_gdal(where)
    found = osr.SpatialReference()
    try:
        if "\n" in text.strip() and "[" not in text:
            found.ImportFromESRI(text.splitlines())
        else:
            found.SetFromUserInput(text)
    except RuntimeError as error:
        raise TerrainError(f"{where}: found the projection \"{text[:80]}\", which GDAL does not know: "
                           f"{error}") from error
    found.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return found


def name_of(text: str) -> str:
    return reference(text, "a projection").GetName() or "without a name"


def text_of_prj(text: str) -> str:
    """Text of a .prj file, in ESRI's words; what a .prj file said stays as it was."""
    if "AUTHORITY[" not in text and "CRS[" not in text:
        return text
    return reference(text, "a projection").ExportToWkt(["FORMAT=WKT1_ESRI"])


def require_metres(text: str, place: np.ndarray, where: str) -> None:
    """place: of the map, two coordinates.

    @raises TerrainError  a projection in degrees or feet, from the centre of the earth, or whose metres are there not
    those on the ground, as of web maps, where they are 1 / cos(latitude) too long
    """
    found = reference(text, where)
    fault = ""
    if found.IsGeocentric():
        fault = "from the centre of the earth"
    elif found.IsGeographic():
        fault = "in degrees"
    elif abs(found.GetLinearUnits() - 1) > 1e-12:
        fault = f"in {found.GetLinearUnitsName()}"
    else:
        longest = max(scales_of(found, place, where), key=lambda scale: abs(np.log(scale)), default=1)
        if abs(np.log(longest)) > MOST_OFF:
            fault = f"whose metre is {1 / longest:.3g} m on the ground"
    if fault:
        raise TerrainError(f"{where}: found the projection {found.GetName()} {fault}, allowed: one in metres on the "
                           "ground; gdalwarp (package gdal-bin) -t_srs EPSG:NUMBER turns a raster into another one")


MOST_OFF = 0.01  # relative error of lengths that a map may have; those of national and UTM grids have less


def scales_of(found, place: np.ndarray, where: str) -> list[float]:
    """Metres of the map over metres on the ellipsoid, along the axes of the map; empty: there is no ellipsoid.

    @raises TerrainError  the place is nowhere on the globe
    """
    _, _, osr = load_gdal(where)
    globe = found.CloneGeogCS()
    if not found.IsProjected() or globe is None:
        return []
    globe.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    step = 100.0
    places = place + step * np.array([(0, 0), (1, 0), (0, 1)])
    try:
        there = np.radians(np.array(osr.CoordinateTransformation(found, globe).TransformPoints(places))[:, :2])
    except RuntimeError:
        there = np.full((3, 2), np.nan)
    if not np.isfinite(there).all():
        raise TerrainError(f"{where}: found ({place[0]:.9g}, {place[1]:.9g}), allowed: places of the projection "
                           f"{found.GetName()}, which has none there")
    radius, flattening = globe.GetSemiMajor(), 1 / (globe.GetInvFlattening() or np.inf)
    eccentricity = flattening * (2 - flattening)  # squared
    latitude = there[0, 1]
    across = radius / np.sqrt(1 - eccentricity * np.sin(latitude) ** 2)  # radius of curvature, east
    along = across * (1 - eccentricity) / (1 - eccentricity * np.sin(latitude) ** 2)  # north
    offsets = there[1:] - there[0]
    offsets[:, 0] = (offsets[:, 0] + np.pi) % (2 * np.pi) - np.pi  # from one side of the date line to the other
    return list(step / np.hypot(across * np.cos(latitude) * offsets[:, 0], along * offsets[:, 1]))


def turned(places: np.ndarray, source: str, target: str, where: str) -> np.ndarray:
    """Places of one projection in another, n x 2; the same array where they are the same to a millimetre.

    @raises TerrainError  no way leads from one to the other, or not from these places
    """
    _, _, osr = load_gdal(where)
    old, new = reference(source, where), reference(target, where)
    if old.IsSame(new) or not len(places):
        return places
    if old.IsGeographic() and (np.abs(places) > (360, 90)).any():
        x, y = places[(np.abs(places) > (360, 90)).any(axis=1)][0]
        raise TerrainError(f"{where}: found ({x:.9g}, {y:.9g}), but its projection is {old.GetName()}, in degrees, "
                           "allowed: degrees (a GeoJSON file without \"crs\" is in degrees east and north)")
    options = osr.CoordinateTransformationOptions()
    options.SetBallparkAllowed(False)  # off by a hundred metres without a word
    try:
        there = np.array(osr.CoordinateTransformation(old, new, options).TransformPoints(places.tolist()))[:, :2]
    except RuntimeError as error:
        raise TerrainError(f"{where}: {old.GetName()} cannot be turned into {new.GetName()}: {error}") from error
    if not np.isfinite(there).all():
        x, y = places[~np.isfinite(there).all(axis=1)][0]
        raise TerrainError(f"{where}: ({x:.9g}, {y:.9g}) of {old.GetName()} has no place in {new.GetName()}")
    return places if np.abs(there - places).max() < SAME else there


def require_same(raster: Raster, needed: str | None, whose: str) -> None:
    """One raster cannot be laid on another's cells where their projections differ. @raises TerrainError"""
    found = raster.projection
    if found is None or needed is None or found.split() == needed.split():
        return
    low_x, low_y, high_x, high_y = raster.limits()
    corners = np.array([(low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)])
    if turned(corners, found, needed, str(raster.path)) is not corners:
        raise TerrainError(f"{raster.path}: found the projection {name_of(found)}, {whose} has {name_of(needed)}, "
                           "allowed: the same; gdalwarp (package gdal-bin) -t_srs turns a raster into another one")
