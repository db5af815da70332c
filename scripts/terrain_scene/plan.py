# SPDX-License-Identifier: BSD-3-Clause
"""The plan of a scene on terrain: a JSON file, read strictly."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .boulders import Boulder, read_boulders
from .changes import changed
from .features import Feature, key_of
from .map_inputs import MapInputs, settle_projection
from .outline import Outline, limits_of
from .projection import require_same
from .raster import Raster, TerrainError
from .reader import NAME, Reader, without_blanks

SOIL = {"law": "mohr_coulomb", "density": 1800, "young_modulus": 5e6, "poisson_ratio": 0.3, "friction_angle": 33}
CONCRETE = {"law": "neo_hookean", "density": 2500, "young_modulus": 3e10, "poisson_ratio": 0.2}
GRAVITY = 9.81
FRAMES = 20  # of a run, unless the plan says otherwise

# Keys of the objects of the file.
PLAN = ("slope", "projection", "gaps", "area", "cell_size", "clear_height", "friction", "slide", "barrier", "boulders",
        "gauges", "probes", "time")
SLIDE = ("polygon", "depth", "top", "material")
BARRIER = ("line", "height", "thickness", "material", "friction")
GAUGE = ("name", "line", "height")
GAUGES = ("lines", "name", "height")  # of a file
PROBES = ("points", "name")
FIELD = ("field",)
DEPTH_FIELD = ("field", "across_slope")
TIME = ("end", "dt", "interval")


@dataclass
class Slide:
    """Mass: inside the outlines (None: anywhere), as deep as a number for each of them or a raster says, or up to the
    raster `top`. across: the depths are measured across the slope, else upright.
    """

    outlines: list[Outline] | None
    depth: list[float] | Raster | None
    top: Raster | None
    material: dict
    across: bool = False


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
class Probe:
    name: str
    place: np.ndarray


@dataclass
class Plan:
    """Coordinates are those of the world, as in the rasters [m].

    projection: of them all, None: no file names one; open_gaps: where the slope has no data there is no ground, else
    such a place is an error.
    """

    slope: Raster
    projection: str | None
    open_gaps: bool
    cell_size: float
    low: np.ndarray
    high: np.ndarray
    clear_height: float  # of the grid above slope and mass
    friction: float
    slide: Slide
    barrier: Barrier | None
    end: float
    dt: float
    interval: float  # of the frames [s]
    gauges: list[Gauge]
    probes: list[Probe]
    boulders: list[Boulder]
    notes: list[str] = field(default_factory=list)  # defaults that were taken


def read_slide(reader: Reader, maps: MapInputs, slope: Raster) -> Slide:
    outlines, features = maps.outlines(reader, "polygon") if "polygon" in reader.values else (None, [])
    if ("depth" in reader.values) == ("top" in reader.values):
        raise TerrainError(f"{reader.where}: allowed: exactly one of depth (a number, an attribute of the polygons, or "
                           "a raster) and top (a raster)")
    material = material_of(reader, SOIL, maps.notes)
    if "top" in reader.values:
        return Slide(outlines, None, raster_like(slope, reader, "top", maps.folder), material)
    depth = reader.values["depth"]
    if isinstance(depth, str):
        return Slide(outlines, raster_like(slope, reader, "depth", maps.folder), None, material)
    if isinstance(depth, dict):
        child = reader.child("depth", DEPTH_FIELD)
        name = child.text("field", "the name of an attribute of the polygons")
        across = child.values.get("across_slope", False)
        if not isinstance(across, bool):
            raise child.fail("across_slope", "true, false")
        if not features:
            raise TerrainError(f"{reader.where}/depth/field: needs polygons of a file")
        depths = [number_of(feature, name, f"{reader.where}/depth/field") for feature in features]
        return Slide(outlines, depths, None, material, across)
    number = reader.number("depth")
    if outlines is None:
        raise TerrainError(f"{reader.where}: a depth that is a number needs a polygon")
    return Slide(outlines, [number] * len(outlines), None, material)


def number_of(feature: Feature, name: str, where: str) -> float:
    try:
        return feature.number(name)
    except TerrainError as error:
        raise TerrainError(f"{where}: {error}") from error


def raster_like(slope: Raster, reader: Reader, key: str, folder: Path) -> Raster:
    """A raster in the projection of the slope."""
    raster = reader.raster(key, folder)
    require_same(raster, slope.projection, f"the slope, {slope.path},")
    return raster


def material_of(reader: Reader, default: dict, notes: list[str]) -> dict:
    if "material" in reader.values:
        given = reader.child("material", None)
        material = given.values
        if "law" not in material:
            notes.append(f"{given.where}: has no law, taken: {json.dumps(default)} but for what is given")
            material = default | material
        Reader(material, given.where, None).number("density")  # the programs check the rest
        return material
    notes.append(f"{reader.where}/material: not given, taken: {json.dumps(default)}")
    return default


def say_thin(where: str, thickness: float, cell_size: float, notes: list[str]) -> None:
    if thickness < 2 * (1 - 1e-6) * cell_size:
        notes.append(f"{where}/thickness: found {thickness:g} m, {thickness / cell_size:.3g} cells: below two cells "
                     "the soil on each side has nodes of its own, which takes up to twice the time")


def read_barrier(reader: Reader, maps: MapInputs, friction: float) -> Barrier:
    return Barrier(maps.line(reader, "line"), reader.number("height"), reader.number("thickness"),
                   material_of(reader, CONCRETE, maps.notes),
                   reader.number("friction", True) if "friction" in reader.values else friction)


def require_two(line: np.ndarray, where: str) -> np.ndarray:
    if len(line) != 2:
        raise TerrainError(f"{where}: found {len(line)} rows, allowed: 2, the ends of a straight line")
    return line


def read_gauges(reader: Reader, maps: MapInputs) -> list[Gauge]:
    """A list, or an object with a file of lines."""
    if not isinstance(reader.values.get("gauges"), dict):
        return [Gauge(each.name(), require_two(maps.line(each, "line"), f"{each.where}/line"),
                      each.number("height")) for each in reader.children("gauges", GAUGE)]
    child = reader.child("gauges", GAUGES)
    child.text("lines", "the name of a file of lines")
    found = maps.features(child, "lines", "line")
    gauges = []
    for line, feature in maps.lines(child, "lines", found):
        height = child.values.get("height")
        if isinstance(height, dict):
            field_name = child.child("height", FIELD).text("field", "the name of an attribute of the lines")
            number = number_of(feature, field_name, f"{child.where}/height/field")
        else:
            number = child.number("height")
        gauges.append(Gauge(name_in(child, feature), require_two(line, f"{child.where}/lines: {feature.where}"),
                            number))
    return gauges


def name_in(reader: Reader, feature: Feature) -> str:
    """The attribute that the key `name` names, by default `name`. Names of the programs have no spaces."""
    name = reader.text("name", "the name of an attribute") if "name" in reader.values else "name"
    try:
        text = feature.text(key_of(feature.values, name, feature.where))
        found = without_blanks(text)
        if found is None:
            raise TerrainError(f"{feature.where}: {name}: found {text!r}, allowed: {NAME}")
        return found
    except TerrainError as error:
        raise TerrainError(f"{reader.where}/name: {error}") from error


def read_probes(reader: Reader, maps: MapInputs) -> list[Probe]:
    """Points of a file."""
    if "probes" not in reader.values:
        return []
    child = reader.child("probes", PROBES)
    child.text("points", "the name of a file of points")
    return [Probe(name_in(child, feature), feature.parts[0][0])
            for feature in maps.features(child, "points", "point").features]


def read_gaps(reader: Reader) -> bool:
    found = reader.values.get("gaps", "refuse")
    if found not in ("refuse", "open"):
        raise reader.fail("gaps", "refuse, open")
    return found == "open"


def read_area(reader: Reader, maps: MapInputs) -> np.ndarray:
    """Two corners, or around the polygons of a file."""
    if isinstance(reader.values.get("area"), str):
        return np.array(limits_of(maps.outlines(reader, "area")[0]))
    corners = reader.rows("area", 2)
    if len(corners) != 2 or not (corners[0] < corners[1]).all():
        raise TerrainError(f"{reader.where}/area: found {corners.tolist()}, allowed: two corners, the lower one first")
    return corners


def read_json(path: Path) -> object:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TerrainError(f"{path}: {error}") from error


def read_plan(path: Path, changes: dict | None = None) -> Plan:
    """changes: by key, of its values. @raises TerrainError"""
    return plan_of(changed(read_json(path), changes or {}), path)


def plan_of(values: object, path: Path) -> Plan:
    """path: of the plan, to which files are relative. @raises TerrainError"""
    reader = Reader(values, str(path), PLAN)
    slope = reader.raster("slope", path.parent)
    maps = MapInputs(path.parent, settle_projection(reader, slope))
    corners = read_area(reader, maps)
    friction = reader.number("friction", at_least_zero=True)
    barrier = read_barrier(reader.child("barrier", BARRIER), maps, friction) if "barrier" in reader.values else None
    time = reader.child("time", TIME)
    interval = time.number("interval") if "interval" in time.values else time.number("end") / FRAMES
    slide = read_slide(reader.child("slide", SLIDE), maps, slope)
    gauges, probes = read_gauges(reader, maps), read_probes(reader, maps)
    cell_size = reader.number("cell_size")
    if barrier:
        say_thin(f"{reader.where}/barrier", barrier.thickness, cell_size, maps.notes)
    plan = Plan(slope, maps.projection, read_gaps(reader), cell_size, corners[0], corners[1],
                reader.number("clear_height"), friction, slide, barrier, time.number("end"), time.number("dt"),
                interval, gauges, probes, read_boulders(reader), maps.notes)
    require_all_in_area(plan, str(path))
    return plan


def require_all_in_area(plan: Plan, path: str) -> None:
    """Barrier, gauges, probes, and each of several polygons: one that is left out would not be missed.

    @raises TerrainError
    """
    if plan.barrier is not None:
        require_in_area(plan, plan.barrier.line, f"{path}/barrier/line")
    for k, gauge in enumerate(plan.gauges):
        require_in_area(plan, gauge.line, f"{path}/gauges/{k}/line")
    for probe in plan.probes:
        require_in_area(plan, probe.place[None], f"{path}/probes: {probe.name}")
    for k, boulder in enumerate(plan.boulders):
        require_in_area(plan, boulder.place[None], f"{path}/boulders/{k}/place")
    names = [each.name for each in (*plan.gauges, *plan.probes)]
    doubled = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if doubled is not None:
        raise TerrainError(f"{path}: found the name {doubled} of gauges and probes twice, allowed: one each")
    outlines = plan.slide.outlines or []
    for k, outline in enumerate(outlines if len(outlines) > 1 else []):
        require_in_area(plan, outline.rings[0], f"{path}/slide/polygon: polygon {k + 1}")


def require_in_area(plan: Plan, rows: np.ndarray, where: str) -> None:
    """rows: places on the map, n x 2. @raises TerrainError"""
    high = plan.low + plan.cell_size * np.ceil((plan.high - plan.low) / plan.cell_size - 1e-9)
    outside = ((rows < plan.low) | (rows > high)).any(axis=1)
    if not outside.any():
        return
    x, y = rows[outside][0]
    degrees = (np.abs(rows) <= 360).all() and not (np.abs(plan.low) <= 360).all()
    swapped = ((rows[:, ::-1] >= plan.low) & (rows[:, ::-1] <= high)).all()
    raise TerrainError(f"{where}: found ({x:.9g}, {y:.9g}) outside the area, allowed: from ({plan.low[0]:.9g}, "
                       f"{plan.low[1]:.9g}) to ({high[0]:.9g}, {high[1]:.9g}), in metres, as the rasters"
                       + ("; the numbers look like degrees" if degrees else "")
                       + ("; with x and y exchanged they lie inside" if swapped else ""))
