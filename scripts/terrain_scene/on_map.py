# SPDX-License-Identifier: BSD-3-Clause
"""Results of a scene on the map that it was made from."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from plotting.peaks import Peaks, find_peaks
from plotting.results import Results, ResultsError

from .features import lines_of, read_features
from .grids import on_cells_of, write_ascii, write_geotiff
from .map_inputs import has_gdal
from .map_picture import Drawn, draw_map, part_of, write_section
from .raster import Raster, TerrainError, read_raster

FIELDS = {"depth": ("depth", "m"), "max_depth": ("largest depth", "m"), "max_speed": ("largest speed", "m/s"),
          "max_dynamic_pressure": ("largest dynamic pressure", "Pa"), "arrival": ("time of arrival", "s")}

FAR = 3  # cells between two frames: largest values have gaps


@dataclass
class Place:
    """Place of a scene on the map: the raster of its slope, its origin and area on the map, what is drawn there."""

    folder: Path
    slope: Raster
    origin: np.ndarray
    low: np.ndarray
    high: np.ndarray
    drawn: Drawn


def read_place(scene: Path, sections: list[str]) -> Place:
    """map.json of a scene. sections: files of lines below the present folder. @raises TerrainError"""
    path = scene / "map.json"
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        low, high = (np.array(corner, dtype=float) for corner in values["area"])
        origin = np.array(values["origin"], dtype=float)
        slope = read_raster(scene / values["slope"])
    except OSError as error:
        raise TerrainError(f"{error.filename or path}: {error.strerror}, allowed: the folder of a scene that "
                           "scripts/terrain wrote") from error
    except (ValueError, KeyError, TypeError) as error:
        raise TerrainError(f"{path}: {error!r}, allowed: the file that scripts/terrain writes into the folder of a "
                           "scene") from error
    slope.projection = slope.projection or values.get("projection")
    barrier = values.get("barrier")
    gauges = {each["name"]: np.array(each["line"]) for each in values.get("gauges", [])}
    drawn = Drawn(None if barrier is None else np.array(barrier), gauges, {},
                  [np.array(ring) for rings in values.get("slide", []) for ring in rings])
    for source in sections:
        found = read_features(source, Path(), "line", slope.projection)
        for line, feature in lines_of(found):
            drawn.sections[section_name(feature.values, drawn.sections)] = line
    return Place(scene, slope, origin, low, high, drawn)


def section_name(values: dict, taken: dict) -> str:
    """Attribute `name` of a section as the name of a file, else the section's number."""
    text = next((str(value) for key, value in values.items() if key.lower() == "name" and value), "")
    name = "".join(letter if letter.isalnum() else "_" for letter in text)
    return name if name and name not in taken else str(len(taken) + 1)


def require_of_scene(results: Results, place: Place) -> None:
    """@raises ResultsError  no settings of soil, a run in 2D, or of another place"""
    if not results.settings("mpm.json"):
        raise ResultsError(f"{results.folder}: found no resolved_config.json of the soil, allowed: results of "
                           f"{place.folder}")
    if results.dim != 3 or not np.allclose(results.origin, place.origin, rtol=0, atol=1e-6):
        raise ResultsError(f"{results.folder}: found the origin {results.origin.tolist()} of a run in {results.dim}D, "
                           f"{place.folder}/map.json has {place.origin.tolist()}, allowed: results of that scene")


def rasters_of(peaks: Peaks, place: Place) -> dict[str, Raster]:
    corner = peaks.plan.low + place.origin[:2]
    return {name: on_cells_of(place.slope, corner, values.T) for name, values in peaks.fields().items()}


def write_maps(results: Results, place: Place, time: float | None, out: Path) -> list[str]:
    """Write all files; returns messages on them. @raises ResultsError, TerrainError"""
    require_of_scene(results, place)
    slope = place.slope
    corner = np.array([slope.x, slope.y]) - slope.spacing / 2 - place.origin[:2]
    peaks = find_peaks(results, corner, slope.spacing, time)
    rasters = rasters_of(peaks, place)
    lines = [] if has_gdal() else ["no GeoTIFF: python3-gdal, which writes it, is not installed"]
    shown = part_of(slope, place.low, place.high)
    for name, raster in rasters.items():
        title, unit = FIELDS[name]
        paths = write_ascii(raster, out / f"{name}.asc")
        if has_gdal():
            paths.append(write_geotiff(raster, out / f"{name}.tif", unit))
        label = f"{title} at {peaks.time:.3g} s [{unit}]" if name == "depth" else f"{title} [{unit}]"
        lines += [*map(str, paths), str(draw_map(shown, raster, label, place.drawn, out / f"{name}.png"))]
    for name, line in place.drawn.sections.items():
        lines += map(str, write_section(name, line, slope, rasters, out))
    volume = float(np.nansum(peaks.depth)) * slope.spacing**2
    most = {name: float(np.nanmax(values)) for name, values in peaks.fields().items() if (~np.isnan(values)).any()}
    series = results.frames_of_soil()
    apart = float(np.diff(series.times).max()) if len(series) > 1 else 0.0
    way = most.get("max_speed", 0) * apart / slope.spacing
    if way > FAR:
        lines.append(f"warning: the largest values are those of the frames, every {apart:.3g} s: the fastest soil "
                     f"moves by up to {way:.3g} cells between two of them; a smaller output/interval gives closer "
                     "values")
    return [*lines, f"{peaks.time:.6g} s: {volume:.6g} m³ of soil at rest on {np.isfinite(peaks.depth).sum()} cells of "
            f"{slope.spacing:g} m; largest: {most.get('max_depth', 0):.4g} m, {most.get('max_speed', 0):.4g} m/s, "
            f"{most.get('max_dynamic_pressure', 0):.4g} Pa"]
