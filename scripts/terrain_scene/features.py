# SPDX-License-Identifier: BSD-3-Clause
"""Polygons, lines and points of maps: shapefile, GeoPackage, GeoJSON, KML and what else GDAL reads."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .outline import Outline
from .projection import name_of, turned
from .raster import TerrainError, load_gdal

LAYER = "|layername="  # behind the name of a file with several layers, as QGIS writes it
KINDS = {"polygon": ("POLYGON", "MULTIPOLYGON"), "line": ("LINESTRING", "MULTILINESTRING"),
         "point": ("POINT", "MULTIPOINT")}


@dataclass
class Feature:
    """where: names it in messages; parts: of a polygon its outlines, of a line its corners n x 2, of a point 1 x 2
    [m]."""

    where: str
    parts: list
    values: dict[str, object]  # attributes by name

    def number(self, name: str) -> float:
        """An attribute > 0. @raises TerrainError"""
        key = key_of(self.values, name, self.where)
        try:
            value = float(self.values[key])
        except (TypeError, ValueError):
            value = np.nan
        if not 0 < value < np.inf:
            raise TerrainError(f"{self.where}: {key}: found {self.values[key]!r}, allowed: a number > 0")
        return value

    def text(self, name: str) -> str:
        value = self.values[key_of(self.values, name, self.where)]
        if value is None or not str(value).strip():
            raise TerrainError(f"{self.where}: {name}: found {value!r}, allowed: a name")
        return str(value).strip()


def key_of(values: dict, name: str, where: str) -> str:
    """The attribute of that name, capital or small letters. @raises TerrainError"""
    found = [key for key in values if key.lower() == name.lower()]
    if len(found) == 1 or name in found:
        return name if name in found else found[0]
    raise TerrainError(f"{where}: no attribute {name}, allowed: {', '.join(values) or 'none: there are no attributes'}")


@dataclass
class Features:
    """Features of one layer of a file, in the projection that was asked for.

    projection: of the file, None: it names none; notes: what was done to the coordinates.
    """

    path: Path
    projection: str | None
    features: list[Feature]
    notes: list[str] = field(default_factory=list)

    def place(self) -> np.ndarray:
        """One place of its first feature."""
        part = self.features[0].parts[0]
        return (part.rings[0] if isinstance(part, Outline) else part)[0]


def open_layer(source: str, folder: Path) -> tuple[Path, object, object]:
    """Path, GDAL's dataset (its layers live as long) and layer. @raises TerrainError"""
    name, _, layer_name = source.partition(LAYER)
    path = folder / name
    if not path.exists():
        raise TerrainError(f"{path}: no such file")
    gdal, ogr, _ = load_gdal(str(path))
    try:
        data = gdal.OpenEx(str(path), gdal.OF_VECTOR | gdal.OF_READONLY)
    except RuntimeError as error:
        raise TerrainError(f"{path}: {error}") from error
    layers = [data.GetLayer(k) for k in range(data.GetLayerCount())]
    if layer_name:
        chosen = [layer for layer in layers if layer.GetName() == layer_name]
    else:
        chosen = [layer for layer in layers if layer.GetGeomType() != ogr.wkbNone]
    if len(chosen) != 1:
        raise TerrainError(f"{path}: found the layers {', '.join(each.GetName() for each in layers) or 'none'}, "
                           f"allowed: one, or its name behind that of the file: {path.name}{LAYER}NAME")
    return path, data, chosen[0]


def valid(geometry: object, where: str) -> None:
    """@raises TerrainError  rings that cross or touch along a line, holes outside, with the place"""
    gdal, _, _ = load_gdal(where)
    said: list[str] = []
    gdal.PushErrorHandler(lambda level, number, text: said.append(text))
    try:
        right = geometry.IsValid()
    finally:
        gdal.PopErrorHandler()
    if not right:
        raise TerrainError(f"{where}: found a polygon that is none: {'; '.join(said) or 'unknown reason'}, allowed: "
                           "rings that do not cross, holes inside")


def corners_of(line: object, closed: bool) -> np.ndarray:
    """n x 2 of an OGR line or ring, without corners that repeat the one before; a ring without its first at the end."""
    corners = np.array(line.GetPoints(), dtype=float)[:, :2]
    keep = np.concatenate([[True], (np.diff(corners, axis=0) != 0).any(axis=1)])
    corners = corners[keep]
    return corners[:-1] if closed and len(corners) > 1 and (corners[0] == corners[-1]).all() else corners


def parts_of(geometry: object, kind: str, where: str) -> list:
    """Outlines, corners of lines, or places. @raises TerrainError  another kind, none, a polygon that is none"""
    if geometry is None or geometry.IsEmpty():
        raise TerrainError(f"{where}: found no geometry, allowed: a {kind}")
    if geometry.HasCurveGeometry():
        geometry = geometry.GetLinearGeometry()
    name = geometry.GetGeometryName()
    if name not in KINDS[kind]:
        raise TerrainError(f"{where}: found a {name.lower()}, allowed: a {kind}")
    # The array of GDAL's points is checked here, since the geometry library answers for finite numbers only.
    several = name.startswith("MULTI")
    single = [geometry.GetGeometryRef(k) for k in range(geometry.GetGeometryCount())] if several else [geometry]
    if kind == "polygon":
        rings = [[corners_of(part.GetGeometryRef(k), True) for k in range(part.GetGeometryCount())] for part in single]
        require_numbers([ring for part in rings for ring in part], where)
        valid(geometry, where)
        if not geometry.GetArea() > 0:
            raise TerrainError(f"{where}: found a polygon without area, allowed: at least three corners apart")
        return [Outline(tuple(part)) for part in rings]
    parts = [corners_of(part, False) for part in single]
    require_numbers(parts, where)
    if kind == "line" and any(len(part) < 2 for part in parts):
        raise TerrainError(f"{where}: found a line without length at ({parts[0][0, 0]:.9g}, {parts[0][0, 1]:.9g}), "
                           "allowed: two corners that differ")
    return parts


def require_numbers(parts: list[np.ndarray], where: str) -> None:
    for part in parts:
        if not np.isfinite(part).all():
            raise TerrainError(f"{where}: found a corner ({part[~np.isfinite(part).all(axis=1)][0]}), allowed: numbers")


def turn_feature(feature: Feature, source: str, target: str) -> bool:
    """Transform into another projection in place; returns whether anything moved."""
    moved = False

    def turn(places: np.ndarray) -> np.ndarray:
        nonlocal moved
        there = turned(places, source, target, feature.where)
        moved = moved or there is not places
        return there

    feature.parts = [Outline(tuple(turn(ring) for ring in part.rings)) if isinstance(part, Outline) else turn(part)
                     for part in feature.parts]
    return moved


def read_features(source: str, folder: Path, kind: str, projection: str | None) -> Features:
    """All features of a layer.

    source: name of the file, with `|layername=` where it has several layers; kind: polygon, line or point; projection:
    that of the slope, into which the coordinates are turned; None: unknown, they stay.

    @raises TerrainError  file, layer or feature, and place, of what cannot be used
    """
    path, _data, layer = open_layer(source, folder)
    system = layer.GetSpatialRef()
    found = Features(path, None if system is None else system.ExportToWkt(), [])
    for feature in layer:
        where = f"{path}: feature {feature.GetFID()}"
        found.features.append(Feature(where, parts_of(feature.geometry(), kind, where), feature.items()))
    if not found.features:
        raise TerrainError(f"{path}: found no feature, allowed: at least one {kind}")
    if found.projection is None:
        found.notes.append(f"{path}: names no projection: its coordinates are taken as those of the slope")
    elif projection is None and system.IsGeographic():
        raise TerrainError(f"{path}: found {system.GetName()}, in degrees, and a slope that names no projection, "
                           "allowed: a .prj file beside the slope, or \"projection\" in the plan, such as "
                           "\"EPSG:31287\"")
    elif projection is None:
        found.notes.append(f"{path}: the slope names no projection: taken as that of this file, {system.GetName()}")
    elif any([turn_feature(feature, found.projection, projection) for feature in found.features]):
        found.notes.append(f"{path}: turned from {system.GetName()} into {name_of(projection)}")
    return found


def outlines_of(found: Features) -> tuple[list[Outline], list[Feature]]:
    """All polygons and the feature of each. @raises TerrainError  two of them overlap: their soil would be there
    twice"""
    pairs = [(outline, feature) for feature in found.features for outline in feature.parts]
    _, ogr, _ = load_gdal(str(found.path))
    shapes = [polygon_of(outline, ogr) for outline, _ in pairs]
    for k, one in enumerate(shapes):
        for n in range(k):
            common = one.Intersection(shapes[n]) if one.Intersects(shapes[n]) else None
            if common is not None and common.GetArea() > 1e-9 * min(one.GetArea(), shapes[n].GetArea()):
                place = common.PointOnSurface()
                raise TerrainError(f"{pairs[k][1].where}: overlaps {pairs[n][1].where.rsplit(': ', 1)[1]} by "
                                   f"{common.GetArea():.6g} m^2 at ({place.GetX():.9g}, {place.GetY():.9g}), allowed: "
                                   "polygons beside each other")
    return [outline for outline, _ in pairs], [feature for _, feature in pairs]


def polygon_of(outline: Outline, ogr: object) -> object:
    shape = ogr.Geometry(ogr.wkbPolygon)
    for ring in outline.rings:
        line = ogr.Geometry(ogr.wkbLinearRing)
        for x, y in [*ring, ring[0]]:
            line.AddPoint_2D(float(x), float(y))
        shape.AddGeometry(line)
    return shape


def lines_of(found: Features) -> list[tuple[np.ndarray, Feature]]:
    """Each with its feature. @raises TerrainError  a feature of several lines"""
    for feature in found.features:
        if len(feature.parts) > 1:
            raise TerrainError(f"{feature.where}: found {len(feature.parts)} lines that do not join, allowed: one a "
                               "feature")
    return [(feature.parts[0], feature) for feature in found.features]
