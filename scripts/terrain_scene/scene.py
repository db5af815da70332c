# SPDX-License-Identifier: BSD-3-Clause
"""Write the folder of a scene from a plan."""

import json
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .barrier import Wall, build_wall
from .boulders import boulder_settings
from .depths import Mass, below_top, near_outlines, of_raster
from .gauges import gauge_settings
from .gmsh import write_cells
from .outline import limits_of
from .plan import GRAVITY, Plan, Probe
from .raster import Raster, TerrainError
from .slope import BULGE, THINNEST, Columns, Slope, lay_columns, write_ply

MANY_CELLS = 2_000_000
LEAST_FILLED = 0.9  # of the volume of the plan; less is warned of
MOST_IN_PLAN = 1_000_000  # cells of the grid: a hundred times those of large scenes
# Waves cross a wall many times in a step of the soil; any other scheme lets them ring.
WALL_SCHEME = {"scheme": "generalized_alpha", "rho_inf": 0}


@dataclass
class Made:
    """All that a scene is made from, in local coordinates: those of the world less the origin."""

    plan: Plan
    origin: np.ndarray
    slope: Slope
    facets: Slope  # the slope as the soil feels it
    columns: Columns
    wall: Wall | None
    gauges: list[dict]  # settings
    probes: list[dict]
    boulders: list[dict]
    cells: tuple[int, int, int]  # of the grid, from (0, 0, 0)


def sample_slope(plan: Plan) -> tuple[np.ndarray, Slope]:
    """Origin and heights; the area is widened to whole cells."""
    h = plan.cell_size
    sides = np.ceil((plan.high - plan.low) / h - 1e-9)
    if not np.prod(sides) <= MOST_IN_PLAN:
        raise TerrainError(f"cell_size: found {h:g} m, which makes {sides[0]:.0f} x {sides[1]:.0f} cells in the area, "
                           f"allowed: {MOST_IN_PLAN}")
    count = sides.astype(int)
    x, y = np.meshgrid(plan.low[0] + h * np.arange(count[0] + 1), plan.low[1] + h * np.arange(count[1] + 1))
    z = plan.slope.at(x, y) if plan.open_gaps else plan.slope.needed_at(x, y)
    if np.isnan(z).all():
        raise TerrainError(f"area: found no data from {place_text(plan.low)} to {place_text(plan.high)}; "
                           f"{plan.slope.reach()}")
    # A cell of the grid below the lowest place, since a point must not leave it there.
    bottom = h * (np.floor(np.nanmin(z) / h) - 1)
    return np.array([*plan.low, bottom]), Slope(h, z - bottom)


def mass_of(plan: Plan, origin: np.ndarray, slope: Slope) -> Mass:
    """The mass in local coordinates."""
    slide = plan.slide
    outlines = None if slide.outlines is None else [outline.moved(-origin[:2]) for outline in slide.outlines]
    if slide.top is not None:
        return Mass(of_raster(below_top(near_outlines(slide.top, slide.outlines), plan.slope), origin), [], outlines)
    if isinstance(slide.depth, Raster):
        return Mass(of_raster(near_outlines(slide.depth, slide.outlines), origin), [], outlines)
    return Mass(None, slide.depth, outlines, slope.stretch if slide.across else None)


def place_text(place: np.ndarray) -> str:
    return f"({place[0]:.9g}, {place[1]:.9g})"


def make(plan: Plan) -> Made:
    """@raises TerrainError"""
    origin, slope = sample_slope(plan)
    mass = mass_of(plan, origin, slope)
    columns = lay_columns(slope, mass)
    if not len(columns.cells):
        raster = plan.slide.top or (plan.slide.depth if isinstance(plan.slide.depth, Raster) else None)
        ends = None if plan.slide.outlines is None else limits_of(plan.slide.outlines)
        deepest = float(columns.depth.max(initial=0))
        raise TerrainError(f"slide: found no mass of at least {THINNEST * plan.cell_size:g} m, a quarter of a cell, in "
                           f"the area from {place_text(plan.low)} to {place_text(plan.high)}"
                           + (f"; {raster.path}: {raster.reach()}" if raster else "")
                           + ("" if ends is None
                              else f"; the polygon from {place_text(ends[0])} to {place_text(ends[1])}")
                           + (f"; it is {deepest:.3g} m deep at most, allowed: a cell_size up to "
                              f"{deepest / THINNEST:.3g} m" if deepest > 0 else ""))
    rim = np.zeros_like(columns.depth, dtype=bool)
    rim[[0, -1], :] = rim[:, [0, -1]] = True
    if (columns.depth[rim] >= THINNEST * plan.cell_size).any():
        raise TerrainError("slide: found mass at the rim of the area, allowed: an area that holds the mass with a cell "
                           "around")
    facets = slope.facets(columns.depth)
    pieces = round(slope.spacing / facets.spacing)
    high = slope.bulge(pieces, columns.depth) > BULGE
    if high.any():
        lift = np.where(high, slope.rise(pieces), 0)
        columns = lay_columns(slope, mass, lift)
        plan.notes.append(f"slide: {high.sum()} columns start up to {lift.max():.2g} m above the warped cells of the "
                          "slope, on its facets")
    wall = None
    if plan.barrier is not None:
        wall = build_wall(slope, plan.barrier.line - origin[:2], plan.barrier.height, plan.barrier.thickness)
    boulders = [boulder_settings(boulder, slope, columns, origin) for boulder in plan.boulders]
    highest = [settings["centre"][2] + boulder.radius for settings, boulder in zip(boulders, plan.boulders)]
    top = max(columns.nodes[:, 2].max(), 0 if wall is None else wall.nodes[:, 2].max(), *highest, 0) + plan.clear_height
    rows, count = slope.z.shape[0] - 1, slope.z.shape[1] - 1
    gauges = [gauge_settings(gauge, slope, origin) for gauge in plan.gauges]
    probes = [probe_settings(probe, slope, columns, origin) for probe in plan.probes]
    return Made(plan, origin, slope, facets, columns, wall, gauges, probes, boulders,
                (count, rows, int(np.ceil(top / plan.cell_size))))


def probe_settings(probe: Probe, slope: Slope, columns: Columns, origin: np.ndarray) -> dict:
    """A probe in the middle of the soil at its place. @raises TerrainError  there is no soil"""
    x, y = probe.place - origin[:2]
    rows, count = columns.depth.shape
    depth = columns.depth[min(int(y / slope.spacing), rows - 1), min(int(x / slope.spacing), count - 1)]
    if not depth >= THINNEST * slope.spacing:
        raise TerrainError(f"probe {probe.name}: found no mass at {place_text(probe.place)}, allowed: places on the "
                           "slide")
    return {"name": probe.name, "point": [float(x), float(y), float(slope.at(x, y) + depth / 2)]}


def soil_settings(made: Made) -> dict:
    plan, h = made.plan, made.plan.cell_size
    settings = {
        "dimension": 3,
        "origin": [float(v) for v in made.origin],
        "grid": {"box": {"low": [0, 0, 0], "high": [n * h for n in made.cells], "cells": list(made.cells),
                         "type": "hex8"}},
        "gravity": [0, 0, -GRAVITY],
        "outside": "remove",
        "time_integration": {"scheme": "explicit"},
        "bodies": [{"name": "slide", "mesh": {"file": "slide.msh"}, "points_per_cell": 8,
                    "material": plan.slide.material}],
        "rigid_walls": [{"name": "terrain", "surface": {"triangles": "terrain.ply", "normals": "up"},
                         "friction": plan.friction}],
    }
    if made.gauges:
        settings["gauges"] = made.gauges
    if made.probes:
        settings["probes"] = made.probes
    if made.boulders:
        settings["boulders"] = made.boulders
    if made.wall is not None:
        settings["interfaces"] = [{"name": "barrier", "friction": plan.barrier.friction,
                                   "surface": {"mesh": {"file": "barrier.msh"}, "groups": ["faces"]}}]
    else:
        settings |= {"time": time_settings(plan), "output": {"interval": plan.interval}}
    return settings


def time_settings(plan: Plan) -> dict:
    return {"end": plan.end, "dt": plan.dt, "dt_min": plan.dt / 1024}


def structure_settings(made: Made) -> dict:
    return {
        "dimension": 3,
        "mesh": {"file": "barrier.msh"},
        "material": made.plan.barrier.material,
        "gravity": [0, 0, -GRAVITY],
        "initial_equilibrium": True,
        "time_integration": WALL_SCHEME,
        "supports": [{"group": "foot", "report_reaction": True}],
        "interfaces": [{"name": "barrier", "groups": ["faces"]}],
        "probes": [{"name": "crest", "point": [float(v) for v in made.wall.crest]}],
    }


def coupling_settings(plan: Plan, weight: float, interface: dict) -> dict:
    """Settings of the coupler, also of a section. weight: of all soil [N, 2D N/m]; interface: its name and what is its
    own"""
    return {
        "time": time_settings(plan),
        "output": {"interval": plan.interval},
        "participants": {"soil": {"sends": "force"}, "structure": {"sends": "displacement"}},
        "interfaces": [{"name": interface["name"], "soil": "soil", "structure": "structure"} | interface],
        "coupling": {
            "convergence": {"displacement": {"relative": 1e-5, "floor": 1e-9 * plan.cell_size},
                            "force": {"relative": 1e-4, "floor": float(f"{1e-7 * weight:.1g}")}},
            "mapping": {"tolerance": 1e-6 * plan.cell_size},
        },
    }


def write_json(path: Path, values: dict) -> None:
    """Lists of numbers and of names on one line each."""
    text = re.sub(r"\[\s+((?:[-\d.e+]+,?\s*|\"[^\"]*\",?\s*)+)\]",
                  lambda found: "[" + " ".join(found.group(1).split()) + "]", json.dumps(values, indent=2))
    path.write_text(text + "\n", encoding="utf-8")


def map_settings(made: Made, folder: Path) -> dict:
    """Place of the scene on the map, for scripts/map: coordinates of the world, the raster of the slope relative to the
    folder."""
    plan = made.plan
    settings = {"slope": os.path.relpath(plan.slope.path.resolve(), folder.resolve()), "projection": plan.projection,
                "origin": [float(v) for v in made.origin],
                "area": [plan.low.tolist(), (plan.low + made.slope.size()).tolist()],
                "gauges": [{"name": gauge.name, "line": gauge.line.tolist()} for gauge in plan.gauges]}
    if plan.slide.outlines is not None:
        settings["slide"] = [[ring.tolist() for ring in outline.rings] for outline in plan.slide.outlines]
    if plan.barrier is not None:
        settings["barrier"] = plan.barrier.line.tolist()
    return settings


def write_scene(made: Made, folder: Path) -> list[str]:
    """Write the files; returns messages on them."""
    folder.mkdir(parents=True, exist_ok=True)
    facets = made.facets
    num_facets = write_ply(facets, folder / "terrain.ply")
    write_cells(made.columns.nodes, made.columns.cells, folder / "slide.msh")
    write_json(folder / "mpm.json", soil_settings(made))
    write_json(folder / "map.json", map_settings(made, folder))
    columns, cells = made.columns, int(np.prod(made.cells))
    lines = [f"origin of the local coordinates: ({', '.join(f'{v:.10g}' for v in made.origin)}) m",
             f"terrain: {num_facets} facets of {facets.spacing:.3g} m",
             f"slide: {columns.asked:.6g} m^3 in the plan, {columns.filled:.6g} m^3 "
             f"({100 * (columns.filled / columns.asked - 1):+.2f} %) in {8 * len(columns.cells)} points; left out: "
             "columns thinner than a quarter of a cell",
             f"grid: {' x '.join(map(str, made.cells))} = {cells} cells of {made.plan.cell_size:g} m"]
    unknown = np.isnan(made.slope.z)
    if unknown.any():
        lines.append(f"slope: {unknown.mean():.1%} of its nodes have no data: there is no ground, soil that comes "
                     "there falls off the map and is taken out")
    if columns.filled < LEAST_FILLED * columns.asked:
        lines.append(f"warning: the scene has {columns.filled / columns.asked:.0%} of the mass of the plan: cell_size "
                     "below a quarter of the depth keeps more of it")
    deepest = float(made.columns.depth.max()) / made.plan.cell_size
    if deepest < 1:
        lines.append(f"warning: the mass is {deepest:.2g} cells deep at most: its own friction acts from two cells on; "
                     "a thinner mass moves as a block, by the friction of the slope")
    advised = np.sqrt(0.5) * made.plan.cell_size
    if facets.longest_edge() > advised:
        lines.append(f"warning: facets up to {facets.longest_edge():.3g} m long, advised: {advised:.3g} m; the slope "
                     "is very steep")
    if cells > MANY_CELLS:
        lines.append(f"warning: more than {MANY_CELLS} cells; a smaller area or larger cells take less memory")
    if made.wall is not None:
        write_cells(made.wall.nodes, made.wall.cells, folder / "barrier.msh", made.wall.groups)
        write_json(folder / "fem.json", structure_settings(made))
        weight = made.plan.slide.material.get("density", 1800) * GRAVITY * made.columns.filled
        write_json(folder / "coupler.json", coupling_settings(made.plan, weight, {"name": "barrier"}))
        lines.append(f"barrier: {len(made.wall.cells)} cells, {len(made.wall.nodes)} nodes")
    else:
        for name in ("barrier.msh", "fem.json", "coupler.json"):  # of a scene that is replaced
            (folder / name).unlink(missing_ok=True)
    return lines + made.plan.notes
