# SPDX-License-Identifier: BSD-3-Clause
"""A plan from a folder laid out as that of AvaFrame: Inputs/ with the slope, REL/, RELTH/, DAM/ (docs.avaframe.org)."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .changes import changed
from .features import key_of
from .map_inputs import MapInputs, settle_projection
from .outline import limits_of
from .plan import FRAMES, read_area
from .raster import Raster, TerrainError, read_raster
from .reach import reach_of
from .reader import Reader

RASTERS, SHAPES = (".asc", ".tif", ".tiff"), (".shp", ".gpkg", ".geojson")
DEPTH = "thickness"  # attribute of the polygons in REL
LEFT_OUT = {"ENT": "entrainment", "RES": "resistance", "SECREL": "secondary releases", "ENTTH": "entrainment"}
# no folder has them
ASKED = {"friction": "of the slope, such as 0.6", "barrier/height": "[m]", "barrier/thickness": "[m]"}
DEEP = 4  # depths in a cell of the grid: a column is left out below a quarter of a cell
BETWEEN_FRAMES = 20  # cells of the slope's raster that the fastest block comes on from one frame to the next
AROUND = 4  # cells of the grid around what blocks come by


def files_in(folder: Path, endings: tuple[str, ...]) -> list[Path]:
    return sorted(path for path in folder.glob("*") if path.suffix.lower() in endings) if folder.is_dir() else []


def only(paths: list[Path], what: str, key: str, folder: Path) -> Path:
    """@raises TerrainError  none or several"""
    if len(paths) != 1:
        names = ", ".join(os.path.relpath(path) for path in paths) or "none"  # as --set takes them
        raise TerrainError(f"{folder}: found as {what}: {names}, allowed: one, or the choice: --set {key}=FILE")
    return paths[0]


def plan_of_layout(folder: Path, scene: Path, changes: dict) -> tuple[dict, list[str]]:
    """Values of a plan that lies in the folder of the scene, and what was taken without being asked for.

    changes: of the plan, by key; they come first, the rest follows from them. @raises TerrainError
    """
    base = folder / "Inputs" if (folder / "Inputs").is_dir() else folder
    changes = from_here(changes, scene)
    given = Reader(changes, "--set", None)
    for key in ("slide", "time"):
        if key in changes:
            given.child(key, None)
    slope_file = chosen(changes, "slope", scene) or only(files_in(base, RASTERS), "slope", "slope", base)
    values = {"slope": named(slope_file, scene)} | {key: changes[key] for key in ("projection", "gaps")
                                                    if key in changes}
    notes = [f"{each}: {what}: not computed, left out" for name, what in LEFT_OUT.items()
             for each in files_in(base / name, RASTERS + SHAPES)]
    slope = read_raster(slope_file)
    reader = Reader(values, str(folder), None)
    maps = MapInputs(scene, settle_projection(reader, slope))
    values["slide"], start, depth = slide_of(base, scene, changes.get("slide", {}), slope, maps)
    barrier = barrier_of(base, scene, changes, notes)
    require_asked(folder, changes, barrier is not None)
    values |= {"friction": given.number("friction", at_least_zero=True),
               "cell_size": given.number("cell_size") if "cell_size" in changes else cell_for(slope, depth)}
    line = np.empty((0, 2))
    if barrier is not None:
        values["barrier"] = barrier
        line = maps.line(Reader(barrier, f"{folder}/barrier", None), "line")
    if "area" in changes:
        values["area"] = read_area(Reader(changes, "--set", None), maps).tolist()
    notes += size_of(values, changes.get("time", {}), slope, (start, depth), line)
    return changed(values, changes), notes


FILES = (("slope",), ("area",), ("slide", "polygon"), ("slide", "depth"), ("slide", "top"), ("barrier", "line"),
         ("gauges", "lines"), ("probes", "points"))


def from_here(changes: dict, scene: Path) -> dict:
    """Names of files on the command line, which lie below the present folder, as the plan in the scene's folder names
    them."""
    found = json.loads(json.dumps(changes))
    for *above, last in FILES:
        inner = found.get(above[0]) if above else found
        if isinstance(inner, dict) and isinstance(inner.get(last), str):
            inner[last] = named(Path(inner[last]), scene)
    return found


def chosen(changes: dict, key: str, scene: Path) -> Path | None:
    return scene / changes[key] if isinstance(changes.get(key), str) else None


def rows_or_file(changes: dict, key: str, scene: Path, of_folder: Callable[[], Path]) -> list | str:
    """What the plan has under a key: rows or a file of the command line, else the file of the folder."""
    if isinstance(changes.get(key), list):
        return changes[key]
    return named(chosen(changes, key, scene) or of_folder(), scene)


def named(path: Path, scene: Path) -> str:
    """The path as the plan in the folder of the scene names it."""
    return os.path.relpath(path.resolve(), scene.resolve())


def cell_for(slope: Raster, depth: float) -> float:
    return float(f"{min(slope.spacing, DEEP * depth):.2g}")


def slide_of(base: Path, scene: Path, changes: dict, slope: Raster, maps: MapInputs) -> tuple[dict, np.ndarray, float]:
    """Keys of the slide, cells of the slope from which it starts n x 2, and its smallest depth, which has to be
    resolved [m]."""
    polygons = rows_or_file(changes, "polygon", scene,
                            lambda: only(files_in(base / "REL", SHAPES), "release", "slide/polygon", base))
    values = {"polygon": polygons} | {key: changes[key] for key in ("material",) if key in changes}
    rasters = files_in(base / "RELTH", RASTERS)
    reader = Reader(values, str(base), None)
    outlines, features = maps.outlines(reader, "polygon")
    if not features and (isinstance(changes.get("depth"), dict) or "depth" not in changes and not rasters):
        raise TerrainError(f"{base}: found a polygon of numbers, which have no depth, allowed: with --set "
                           "slide/depth=NUMBER or =RASTER")
    if "depth" in changes or not rasters:
        values["depth"] = changes.get("depth") or {"field": key_of(features[0].values, DEPTH, features[0].where),
                                                   "across_slope": True}
    else:
        values["depth"] = named(only(rasters, "depth of the release", "slide/depth", base), scene)
    if isinstance(values["depth"], dict):
        depths = [feature.number(values["depth"]["field"]) for feature in features]
    elif isinstance(values["depth"], str):
        raster = read_raster(scene / values["depth"])
        depths = [float(np.nanmean(np.where(raster.values > 0, raster.values, np.nan)))]
    else:
        depths = [Reader(values, f"{base}/slide", None).number("depth")]
    low, high = limits_of(outlines)
    centres = [start + slope.spacing * np.arange(count) for start,
               count in zip((slope.x, slope.y), slope.values.shape[::-1])]
    near = [ticks[(ticks >= a) & (ticks <= b)] for ticks, a, b in zip(centres, low, high)]
    places = np.stack(np.meshgrid(*near), axis=-1).reshape(-1, 2)
    inside = np.any([outline.contains(places) for outline in outlines], axis=0)
    if not inside.any():
        raise TerrainError(f"{base}/slide/polygon: found no cell of the slope inside, from ({low[0]:.9g}, "
                           f"{low[1]:.9g}) to ({high[0]:.9g}, {high[1]:.9g}); {slope.reach()}")
    return values, places[inside], min(depths)


def require_asked(folder: Path, changes: dict, barrier: bool) -> None:
    """@raises TerrainError  what no such folder says, and the command line does not either"""
    given = {"friction"} & set(changes) | {f"barrier/{key}" for key in changes.get("barrier") or {}}
    missing = [key for key in ASKED if key not in given and (barrier or not key.startswith("barrier"))]
    if missing:
        raise TerrainError(f"{folder}: says nothing of " + ", ".join(f"{key} {ASKED[key]}" for key in missing)
                           + ", allowed: "
                           + " ".join(f"--set {key}=NUMBER" for key in missing)
                           + ("; without the barrier: --set barrier=null" if barrier else ""))


def barrier_of(base: Path, scene: Path, changes: dict, notes: list[str]) -> dict | None:
    """Keys of the barrier: along the line in DAM; None: there is none, or none is wanted."""
    lines = files_in(base / "DAM", SHAPES)
    asked = changes.get("barrier", {})
    if asked is None:
        del changes["barrier"]
        return None
    if not lines and not asked:
        return None
    if not isinstance(asked, dict):
        raise TerrainError(f"--set barrier={asked}: allowed: null, or its keys one by one")
    line = rows_or_file(asked, "line", scene, lambda: only(lines, "barrier", "barrier/line", base))
    if isinstance(line, str):
        notes.append(f"barrier: an upright wall along {os.path.relpath(scene / line)}; heights of the line and slope "
                     "of its faces are not used")
    return {**asked, "line": line}


def size_of(values: dict, time: dict, slope: Raster, mass: tuple[np.ndarray, float], line: np.ndarray) -> list[str]:
    """Area, height and time of the run into `values`, from blocks that slide from the mass, as far as they are not
    given; returns what to say of it.

    time: what is given of it; mass: places that it starts from and its depth; line: of the barrier, empty: none.

    @raises TerrainError  the slope has no data there
    """
    start, depth = mass
    h = values["cell_size"]
    reach = reach_of(slope, start, depth, values["friction"])
    if not reach.fastest > 0:
        raise TerrainError(f"{slope.path}: found no data under the release, from ({start[0, 0]:.9g}, "
                           f"{start[0, 1]:.9g}) on")
    values["clear_height"] = float(f"{4 * max(depth, h):.2g}")
    every = np.concatenate([reach.places, line])
    if "area" not in values:
        low_x, low_y, high_x, high_y = slope.limits()
        low = np.maximum(np.floor(every.min(axis=0) / h - AROUND) * h, [low_x, low_y])
        sides = np.floor((np.minimum(np.ceil(every.max(axis=0) / h + AROUND) * h, [high_x, high_y]) - low) / h + 1e-9)
        values["area"] = [low.tolist(), (low + sides * h).tolist()]
    end = float(f"{reach.time:.2g}")
    interval = min(end / FRAMES, BETWEEN_FRAMES * slope.spacing / reach.fastest)
    values["time"] = {"end": end, "dt": float(f"{h / reach.fastest:.2g}"), "interval": float(f"{interval:.2g}")} | time
    x, y = (ticks(start_of, end_of, h) for start_of, end_of in zip(*values["area"]))
    if np.isnan(slope.at(*np.meshgrid(x, y))).any():
        values.setdefault("gaps", "open")
    return [f"nine of ten blocks with this friction are at rest after {reach.time:.3g} s, {reach.fastest:.3g} m/s at "
            "most; area, time and clear_height follow from them as far as they are not given. Check that the soil has "
            "come to rest at the end"
            + (f"; {reach.left} of {len(start)} blocks leave the data of the slope" if reach.left else "")]


def ticks(low: float, high: float, h: float) -> np.ndarray:
    return low + h * np.arange(int(np.ceil((high - low) / h - 1e-9)) + 1)
