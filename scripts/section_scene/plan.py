# SPDX-License-Identifier: BSD-3-Clause
"""The plan of a section: a JSON file, read strictly by the reader of plans on terrain."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from terrain_scene.changes import changed
from terrain_scene.plan import CONCRETE, FRAMES, SOIL, TIME, material_of, read_json, say_thin
from terrain_scene.raster import TerrainError
from terrain_scene.reader import Reader

from .lines import Line, line_of, read_ground, read_line

# Keys of the objects of the file.
PLAN = ("ground", "layers", "water", "slide", "wall", "friction", "cell_size", "clear_height", "gauges", "time")
LAYER = ("name", "bottom", "material", "k0", "porosity")
WATER = ("table",)
SLIDE = ("from", "to", "depth", "surface", "material", "velocity")
WALL = ("at", "height", "thickness", "depth", "footing", "material", "friction")
FOOTING = ("width", "thickness", "before")
GAUGE = ("name", "at", "height")
SETTLE = (*TIME, "settle")


@dataclass
class Layer:
    name: str
    bottom: Line
    material: dict
    k0: str | float
    porosity: float | None  # needed where the water table lies in it


@dataclass
class Slide:
    """A mass on the ground between two places, up to the line `top`."""

    top: Line
    material: dict
    velocity: list[float] | None


@dataclass
class Footing:
    width: float
    thickness: float
    before: float  # how far it reaches to the left of the wall's left face


@dataclass
class Wall:
    """Upright, its left face at `at`, its crest `height` above the lowest ground under it, its underside `depth`
    below."""

    at: float
    height: float
    thickness: float
    depth: float
    footing: Footing | None
    material: dict
    friction: float

    def reach(self) -> tuple[float, float]:
        """Left and right end of its underside [m]."""
        if self.footing is None:
            return self.at, self.at + self.thickness
        left = self.at - self.footing.before
        return left, left + self.footing.width


@dataclass
class Gauge:
    name: str
    at: float
    height: float  # above the ground


@dataclass
class Plan:
    """Lengths in metres; x along the section, z upwards. layers: from the ground down."""

    ground: Line
    layers: list[Layer]
    table: float | None  # height of the water
    slide: Slide | None
    wall: Wall | None
    friction: float  # of the base
    cell_size: float
    clear_height: float
    gauges: list[Gauge]
    end: float
    dt: float
    interval: float
    settle: float  # time in which gravity comes [s]; 0: at once
    notes: list[str] = field(default_factory=list)  # defaults that were taken

    def ends(self) -> tuple[float, float]:
        return float(self.ground.x[0]), float(self.ground.x[-1])


def read_layers(reader: Reader, ground: Line, notes: list[str]) -> list[Layer]:
    layers: list[Layer] = []
    for each in reader.children("layers", LAYER):
        name = each.name()
        if name in ("slide", "wall", *(layer.name for layer in layers)):
            raise TerrainError(f"{each.where}/name: found {name}, which another mass or the wall has, allowed: a name "
                               "of its own")
        k0 = each.values.get("k0",
                             "jaky" if "material" not in each.values or "friction_angle" in each.values["material"]
                             else "elastic")
        if k0 not in ("jaky", "elastic"):
            k0 = each.number("k0", True)
        porosity = each.number("porosity") if "porosity" in each.values else None
        layers.append(Layer(name, read_line(each, "bottom", ground), material_of(each, SOIL, notes), k0, porosity))
    return layers


def read_velocity(reader: Reader) -> list[float] | None:
    value = reader.values.get("velocity")
    if value is None:
        return None
    real = isinstance(value, list) and len(value) == 2 and all(isinstance(v, (int, float)) for v in value)
    if not real or any(isinstance(v, bool) for v in value) or not np.isfinite(value).all():
        raise reader.fail("velocity", "[along x, upwards] in m/s")
    return [float(v) for v in value]


def read_slide(reader: Reader, ground: Line, notes: list[str]) -> Slide:
    """The slide, with its top as rows [x, z] or as a depth between two places."""
    if ("surface" in reader.values) == ("depth" in reader.values):
        raise TerrainError(f"{reader.where}: allowed: exactly one of surface (rows [x, z]) and depth (with from and "
                           "to)")
    if "surface" in reader.values:
        for key in ("from", "to"):
            if key in reader.values:
                raise reader.fail(key, "nothing beside surface, whose ends are those of the mass")
        top = line_of(reader.rows("surface", 2), f"{reader.where}/surface")
    else:
        left, right = (reader.real(key, "a place x [m]") for key in ("from", "to"))
        if not left < right:
            raise reader.fail("to", f"more than from, {left:.9g}")
        inner = ground.x[(ground.x > left) & (ground.x < right)]
        x = np.array([left, *inner, right])
        top = Line(x, ground.at(x) + reader.number("depth"))
    if top.x[0] < ground.x[0] or top.x[-1] > ground.x[-1]:
        raise TerrainError(f"{reader.where}: found a mass from x = {top.x[0]:.9g} to {top.x[-1]:.9g}, allowed: inside "
                           f"the ground, from {ground.x[0]:.9g} to {ground.x[-1]:.9g}")
    return Slide(top, material_of(reader, SOIL, notes), read_velocity(reader))


def read_footing(reader: Reader, thickness: float) -> Footing:
    footing = Footing(reader.number("width"), reader.number("thickness"), reader.number("before", True))
    if footing.before + thickness > footing.width:
        raise reader.fail("width",
                          f"at least before and the wall's thickness, {footing.before + thickness:.9g}: the wall "
                          "stands "
                                   "on its footing")
    return footing


def read_wall(reader: Reader, ground: Line, plan: tuple[float, float, bool], notes: list[str]) -> Wall:
    """plan: friction and cell size of the plan, and whether there are layers."""
    friction, cell_size, layers = plan
    thickness = reader.number("thickness")
    footing = read_footing(reader.child("footing", FOOTING), thickness) if "footing" in reader.values else None
    if "depth" in reader.values:
        depth = reader.number("depth")
    elif layers:
        raise reader.fail("depth", "how deep the underside lies below the ground [m]")
    else:
        depth = cell_size if footing is None else footing.thickness
    if footing is not None and depth < footing.thickness:
        raise reader.fail("depth",
                          f"at least the thickness of the footing, {footing.thickness:.9g}: it lies in the ground")
    wall = Wall(reader.real("at", "the place x of its left face [m]"), reader.number("height"), thickness, depth,
                footing,
                material_of(reader, CONCRETE, notes),
                reader.number("friction", True) if "friction" in reader.values else friction)
    left, right = wall.reach()
    if not ground.x[0] < left or not right < ground.x[-1]:
        raise TerrainError(f"{reader.where}: found a wall from x = {left:.9g} to {right:.9g}, allowed: inside the "
                           f"ground, from {ground.x[0]:.9g} to {ground.x[-1]:.9g}")
    say_thin(reader.where, thickness, cell_size, notes)
    return wall


def read_gauges(reader: Reader, ground: Line) -> list[Gauge]:
    gauges = [Gauge(each.name(), each.real("at", "a place x [m]"), each.number("height"))
              for each in reader.children("gauges", GAUGE)]
    for k, gauge in enumerate(gauges):
        if gauge.name in [other.name for other in gauges[:k]]:
            raise TerrainError(f"{reader.where}/gauges/{k}/name: found {gauge.name} twice, allowed: one each")
        if not ground.x[0] <= gauge.at <= ground.x[-1]:
            raise TerrainError(f"{reader.where}/gauges/{k}/at: found {gauge.at:.9g}, allowed: from {ground.x[0]:.9g} "
                               f"to {ground.x[-1]:.9g}")
    return gauges


def read_plan(path: Path, changes: dict | None = None) -> Plan:
    """changes: by key, of its values. @raises TerrainError"""
    reader = Reader(changed(read_json(path), changes or {}), str(path), PLAN)
    notes: list[str] = []
    ground = read_ground(reader, path.parent)
    layers = read_layers(reader, ground, notes)
    slide = read_slide(reader.child("slide", SLIDE), ground, notes) if "slide" in reader.values else None
    if not layers and slide is None:
        raise TerrainError(f"{path}: found no soil, allowed: layers, slide, or both")
    friction, cell_size = reader.number("friction", at_least_zero=True), reader.number("cell_size")
    wall = None
    if "wall" in reader.values:
        wall = read_wall(reader.child("wall", WALL), ground, (friction, cell_size, bool(layers)), notes)
    table = None
    if "water" in reader.values:
        table = reader.child("water", WATER).real("table", "the height of a level water table [m]")
    time = reader.child("time", SETTLE)
    interval = time.number("interval") if "interval" in time.values else time.number("end") / FRAMES
    settle = time.number("settle") if "settle" in time.values else 0.0
    return Plan(ground, layers, table, slide, wall, friction, cell_size, reader.number("clear_height"),
                read_gauges(reader, ground), time.number("end"), time.number("dt"), interval, settle, notes)
