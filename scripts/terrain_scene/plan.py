# SPDX-License-Identifier: BSD-3-Clause
"""What a scene on terrain is made from: a JSON file, read strictly."""

import json
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from .raster import Raster, TerrainError, read_raster

SOIL = {"law": "mohr_coulomb", "density": 1800, "young_modulus": 5e6, "poisson_ratio": 0.3, "friction_angle": 33}
CONCRETE = {"law": "neo_hookean", "density": 2500, "young_modulus": 3e10, "poisson_ratio": 0.2}
GRAVITY = 9.81

# Keys of the objects of the file.
PLAN = ("slope", "area", "cell_size", "clear_height", "friction", "slide", "barrier", "gauges", "time")
SLIDE = ("polygon", "depth", "top", "material")
BARRIER = ("line", "height", "thickness", "material", "friction")
GAUGE = ("name", "line", "height")
TIME = ("end", "dt")


@dataclass
class Slide:
    """Mass: inside the polygon (None: anywhere), as deep as a number or a raster says, or up to the raster `top`."""

    polygon: np.ndarray | None
    depth: float | Raster | None
    top: Raster | None
    material: dict


@dataclass
class Barrier:
    line: np.ndarray
    height: float
    thickness: float
    material: dict
    friction: float


@dataclass
class Gauge:
    name: str
    line: np.ndarray  # its two ends
    height: float  # above the highest ground under the line


@dataclass
class Plan:
    """Coordinates are those of the world, as in the rasters [m]."""

    slope: Raster
    cell_size: float
    low: np.ndarray
    high: np.ndarray
    clear_height: float  # of the grid above slope and mass
    friction: float
    slide: Slide
    barrier: Barrier | None
    end: float
    dt: float
    gauges: list[Gauge]
    notes: list[str] = field(default_factory=list)  # defaults that were taken


class Reader:
    """An object of the file: each key is asked for by name, other ones are refused.

    @raises TerrainError  it is no object or has a key that is not one of `keys` (None: any)
    """

    def __init__(self, values: object, where: str, keys: tuple[str, ...] | None):
        if not isinstance(values, dict):
            raise TerrainError(f"{where}: found {values!r}, allowed: an object")
        for key in values:
            if keys is not None and key not in keys:
                near = get_close_matches(key.lower(), keys, 1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise TerrainError(f"{where}/{key}: unknown, allowed: {', '.join(keys)}{hint}")
        self.values, self.where = dict(values), where

    def fail(self, key: str, allowed: str) -> TerrainError:
        found = repr(self.values[key]) if key in self.values else "nothing"
        return TerrainError(f"{self.where}/{key}: found {found}, allowed: {allowed}")

    def number(self, key: str, at_least_zero: bool = False) -> float:
        value = self.values.get(key)
        real = isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value)
        if not real or not (value > 0 or (at_least_zero and value == 0)):
            raise self.fail(key, "a number >= 0" if at_least_zero else "a number > 0")
        return float(value)

    def rows(self, key: str, at_least: int) -> np.ndarray:
        try:
            rows = np.array(self.values.get(key), dtype=float)
        except (TypeError, ValueError) as error:
            raise self.fail(key, f"at least {at_least} rows [x, y]") from error
        if rows.ndim != 2 or rows.shape[1] != 2 or len(rows) < at_least or not np.isfinite(rows).all():
            raise self.fail(key, f"at least {at_least} rows [x, y]")
        return rows

    def text(self, key: str, allowed: str) -> str:
        value = self.values.get(key)
        if not isinstance(value, str) or not value:
            raise self.fail(key, allowed)
        return value

    def raster(self, key: str, folder: Path) -> Raster:
        name = self.text(key, "the name of a raster")
        try:
            return read_raster(folder / name)
        except TerrainError as error:
            raise TerrainError(f"{self.where}/{key}: {error}") from error

    def children(self, key: str, keys: tuple[str, ...]) -> "list[Reader]":
        """Of a list of objects; none where the key is missing."""
        values = self.values.get(key, [])
        if not isinstance(values, list):
            raise self.fail(key, "a list of objects")
        return [Reader(value, f"{self.where}/{key}/{k}", keys) for k, value in enumerate(values)]

    def child(self, key: str, keys: tuple[str, ...] | None) -> "Reader":
        return Reader(self.values.get(key), f"{self.where}/{key}", keys)


def read_slide(reader: Reader, folder: Path, notes: list[str]) -> Slide:
    polygon = reader.rows("polygon", 3) if "polygon" in reader.values else None
    if ("depth" in reader.values) == ("top" in reader.values):
        raise TerrainError(f"{reader.where}: allowed: exactly one of depth (a number, or a raster) and top (a raster)")
    depth = top = None
    if "top" in reader.values:
        top = reader.raster("top", folder)
    elif isinstance(reader.values["depth"], str):
        depth = reader.raster("depth", folder)
    else:
        depth = reader.number("depth")
        if polygon is None:
            raise TerrainError(f"{reader.where}: a depth that is a number needs a polygon")
    return Slide(polygon, depth, top, material_of(reader, SOIL, notes))


def material_of(reader: Reader, default: dict, notes: list[str]) -> dict:
    if "material" in reader.values:
        reader.child("material", None).number("density")  # the programs check the rest
        return reader.values["material"]
    notes.append(f"{reader.where}/material: not given, taken: {json.dumps(default)}")
    return default


def say_thin(where: str, thickness: float, cell_size: float, notes: list[str]) -> None:
    if thickness < 2 * (1 - 1e-6) * cell_size:
        notes.append(f"{where}/thickness: found {thickness:g} m, {thickness / cell_size:.3g} cells: soil that comes over "
                     "or round the barrier acts on soil before it; advised: at least two cells")


def read_barrier(reader: Reader, friction: float, notes: list[str]) -> Barrier:
    return Barrier(reader.rows("line", 2), reader.number("height"), reader.number("thickness"),
                   material_of(reader, CONCRETE, notes),
                   reader.number("friction", True) if "friction" in reader.values else friction)


def read_gauge(reader: Reader) -> Gauge:
    line = reader.rows("line", 2)
    if len(line) != 2:
        raise TerrainError(f"{reader.where}/line: found {len(line)} rows, allowed: 2, the ends of a straight line")
    return Gauge(reader.text("name", "a name"), line, reader.number("height"))


def read_plan(path: Path) -> Plan:
    """Files are relative to the plan. @raises TerrainError"""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TerrainError(f"{path}: {error}") from error
    reader = Reader(values, str(path), PLAN)
    slope = reader.raster("slope", path.parent)
    notes: list[str] = []
    corners = reader.rows("area", 2)
    if len(corners) != 2 or not (corners[0] < corners[1]).all():
        raise TerrainError(f"{path}/area: found {corners.tolist()}, allowed: two corners, the lower one first")
    friction = reader.number("friction", at_least_zero=True)
    barrier = read_barrier(reader.child("barrier", BARRIER), friction, notes) if "barrier" in reader.values else None
    time = reader.child("time", TIME)
    cell_size = reader.number("cell_size")
    if barrier:
        say_thin(f"{reader.where}/barrier", barrier.thickness, cell_size, notes)
    plan = Plan(slope, cell_size, corners[0], corners[1], reader.number("clear_height"), friction,
                read_slide(reader.child("slide", SLIDE), path.parent, notes), barrier, time.number("end"), time.number("dt"),
                [read_gauge(each) for each in reader.children("gauges", GAUGE)], notes)
    if barrier is not None:
        require_in_area(plan, barrier.line, f"{path}/barrier/line")
    for k, gauge in enumerate(plan.gauges):
        require_in_area(plan, gauge.line, f"{path}/gauges/{k}/line")
    return plan


def require_in_area(plan: Plan, rows: np.ndarray, where: str) -> None:
    """rows: places on the map, n x 2. @raises TerrainError"""
    high = plan.low + plan.cell_size * np.ceil((plan.high - plan.low) / plan.cell_size - 1e-9)
    outside = ((rows < plan.low) | (rows > high)).any(axis=1)
    if not outside.any():
        return
    x, y = rows[outside][0]
    degrees = (np.abs(rows) <= 360).all() and not (np.abs(plan.low) <= 360).all()
    raise TerrainError(f"{where}: found ({x:.9g}, {y:.9g}) outside the area, allowed: from ({plan.low[0]:.9g}, "
                       f"{plan.low[1]:.9g}) to ({high[0]:.9g}, {high[1]:.9g}), in metres, as the rasters"
                       + ("; the numbers look like degrees" if degrees else ""))
