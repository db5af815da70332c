# SPDX-License-Identifier: BSD-3-Clause
"""Write the folder of a scene from the plan of a section."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from terrain_scene.gmsh import write_cells
from terrain_scene.plan import GRAVITY
from terrain_scene.raster import TerrainError
from terrain_scene.scene import WALL_SCHEME, coupling_settings, time_settings, write_json

from .checks import warnings_of
from .columns import Mass, lay_soil, simplified
from .lines import Line
from .plan import Plan
from .stress import initial_stress, level_heights, table_below_ground
from .wall import WallMesh, build_wall

FAR = 1000.0  # [m]: beyond it the scene gets an origin of its own, for files in single precision
RESTING = 12  # resting_factor of the wall, as rigid walls have: its earth pressure is then 3 % too small at most


@dataclass
class Made:
    """All that a scene is made from; plan, masses, base and wall less the origin [m]."""

    plan: Plan
    origin: np.ndarray
    masses: list[Mass]
    base: Line
    wall: WallMesh | None
    low: np.ndarray  # corner of the grid
    cells: tuple[int, int]
    stress: list[dict]  # geostatic, of level layers, as settings of their bodies; empty: they start free of stress


def moved(plan: Plan, way: np.ndarray) -> Plan:
    """The plan with all of its places moved."""
    return replace(
        plan, ground=plan.ground.moved(way), table=None if plan.table is None else plan.table + way[1],
        layers=[replace(layer, bottom=layer.bottom.moved(way)) for layer in plan.layers],
        slide=None if plan.slide is None else replace(plan.slide, top=plan.slide.top.moved(way)),
        wall=None if plan.wall is None else replace(plan.wall, at=plan.wall.at + way[0]),
        gauges=[replace(gauge, at=gauge.at + way[0]) for gauge in plan.gauges])


def origin_of(plan: Plan) -> np.ndarray:
    """Zero unless places are far from it; then the lower left corner, on whole cells."""
    ends = np.array([plan.ends()[0], plan.ground.z.min()])
    far = max(abs(plan.ends()[0]), abs(plan.ends()[1]), np.abs(plan.ground.z).max()) > FAR
    return np.floor(ends / plan.cell_size) * plan.cell_size if far else np.zeros(2)


def require_start(plan: Plan, geostatic: bool) -> None:
    """@raises TerrainError  water without geostatic stress"""
    reason = ("time/settle" if plan.settle else "a slide, which starts free of stress" if plan.slide is not None
              else "layers whose tops are not level")
    if plan.table is not None and not geostatic:
        raise TerrainError(f"water/table: found a water table and {reason}, allowed: layers with level tops alone. "
                           "Pore water that cannot drain starts from geostatic stress; else it would carry the weight "
                           "of the soil, which would have no strength")
    if plan.layers and not geostatic and not plan.settle:
        plan.notes.append(f"warning: the layers start free of stress, beside {reason}: their weight acts at once, and "
                          "they oscillate; with time/settle it grows gradually, advised: several periods 4 H / wave "
                          "speed")


def make(given: Plan) -> Made:
    """@raises TerrainError"""
    origin = origin_of(given)
    plan = moved(given, -origin)
    table_below_ground(plan, float(origin[1]))
    masses, base = lay_soil(plan)
    wall = None if plan.wall is None else build_wall(plan, base)
    heights = level_heights(plan) if plan.layers and plan.slide is None and not plan.settle else None
    require_start(plan, heights is not None)
    stress = [] if heights is None else [initial_stress(plan, layer, heights) for layer in plan.layers]
    h = plan.cell_size
    tops = [mass.nodes[:, 1].max() for mass in masses] + [plan.ground.z.max()] + ([] if wall is None
                                                                                  else [wall.crest[1]])
    low = np.array([plan.ends()[0], h * (np.floor(base.z.min() / h) - 1)])
    size = np.array([plan.ends()[1], max(tops) + plan.clear_height]) - low
    count = np.ceil(size / h - 1e-9).astype(int)
    return Made(plan, origin, masses, base, wall, low, (int(count[0]), int(count[1])), stress)


def bodies(made: Made) -> list[dict]:
    """The layers from the ground down, then the slide."""
    slide = made.plan.slide
    materials = [layer.material for layer in made.plan.layers] + ([] if slide is None else [slide.material])
    settings = [{"name": mass.name, "mesh": {"file": f"{mass.name}.msh"}, "points_per_cell": 4, "material": material}
                for mass, material in zip(made.masses, materials)]
    for body, stress in zip(settings, made.stress):
        body |= stress
    if slide is not None and slide.velocity is not None:
        settings[-1]["velocity"] = slide.velocity
    return settings


def rigid_walls(made: Made) -> list[dict]:
    """The base, and smooth walls at the ends where layers reach them."""
    plan, base = made.plan, simplified(made.base)
    top = made.low[1] + made.cells[1] * plan.cell_size
    corners = [[float(x), float(z)] for x, z in zip(base.x[::-1], base.z[::-1])]
    surface = {"polyline": corners, "spacing": plan.cell_size / 2}
    walls = [{"name": "base", "surface": surface, "friction": plan.friction}]
    for name, k in (("left", 0), ("right", -1)):
        x, z = corners[-1 if k == 0 else 0]
        if plan.ground.z[k] - z > 1e-9 * plan.cell_size:
            line = [[x, z], [x, float(top)]]
            walls.append({"name": name,
                          "surface": {"polyline": line if k == 0 else line[::-1], "spacing": plan.cell_size / 2},
                          "mode": "slip"})
    return walls


def soil_settings(made: Made) -> dict:
    plan, h = made.plan, made.plan.cell_size
    high = made.low + h * np.array(made.cells)
    settings = {
        "dimension": 2,
        "origin": [float(v) for v in made.origin],
        "grid": {"box": {"low": [float(v) for v in made.low], "high": [float(v) for v in high],
                         "cells": list(made.cells),
                         "type": "quad4"}},
        "gravity": [0, -GRAVITY],
        "outside": "remove",
        "time_integration": {"scheme": "explicit"},
        "bodies": bodies(made),
        "rigid_walls": rigid_walls(made),
    }
    if plan.gauges:
        settings["gauges"] = [{"name": gauge.name, "corners": [[gauge.at, z], [gauge.at, z + gauge.height]]}
                              for gauge in plan.gauges for z in [float(plan.ground.at(gauge.at))]]
    if made.wall is not None:
        settings["interfaces"] = [{"name": "wall", "friction": plan.wall.friction,
                                   "surface": {"mesh": {"file": "wall.msh"}, "groups": wet_groups(made)}}]
    else:
        settings |= {"time": time_settings(plan), "output": {"interval": plan.interval}}
    if plan.settle:
        settings["gravity_ramp"] = {"duration": plan.settle, "shape": "smooth"}
        for interface in settings.get("interfaces", []):
            interface["resting_factor"] = RESTING
    return settings


def wet_groups(made: Made) -> list[str]:
    """Groups of the wall's facets that soil can reach: the underside too where soil lies below it."""
    left, right = made.plan.wall.reach()
    below = made.base.at(np.linspace(left, right, 33)).min()
    return ["faces", "foot"] if below < made.wall.middle[1] - 1e-9 * made.plan.cell_size else ["faces"]


def structure_settings(made: Made) -> dict:
    return {
        "dimension": 2,
        "mesh": {"file": "wall.msh"},
        "material": made.plan.wall.material,
        "gravity": [0, -GRAVITY],
        "initial_equilibrium": True,
        "time_integration": WALL_SCHEME,
        "supports": [{"group": "foot", "report_reaction": True, "report_moment": True}],
        "interfaces": [{"name": "wall", "groups": wet_groups(made)}],
        "probes": [{"name": "crest", "point": [float(v) for v in made.wall.crest]}],
    }


def weight_of(made: Made) -> float:
    """Weight of all soil [N/m]."""
    return GRAVITY * sum(mass.area * body["material"]["density"] for mass, body in zip(made.masses, bodies(made)))


def write_scene(made: Made, folder: Path) -> list[str]:
    """Write the files; returns messages on them."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    if made.origin.any():
        lines.append(f"origin of the local coordinates: ({made.origin[0]:.10g}, {made.origin[1]:.10g}) m")
    for mass in made.masses:
        write_cells(mass.nodes, mass.cells, folder / f"{mass.name}.msh")
        lines.append(f"{mass.name}: {mass.area:.8g} m^2, {len(mass.cells)} cells, {4 * len(mass.cells)} points")
    write_json(folder / "mpm.json", soil_settings(made))
    lines.append(f"grid: {made.cells[0]} x {made.cells[1]} = {made.cells[0] * made.cells[1]} cells of "
                 f"{made.plan.cell_size:g} m")
    if made.stress:
        lines.append("the layers start with the stress of level ground (initial_stress)")
    if made.wall is not None:
        write_cells(made.wall.nodes, made.wall.cells, folder / "wall.msh", made.wall.groups)
        write_json(folder / "fem.json", structure_settings(made))
        interface = {"name": "wall", "moment_about": [float(v) for v in made.wall.middle]}
        write_json(folder / "coupler.json", coupling_settings(made.plan, weight_of(made), interface))
        lines.append(f"wall: {len(made.wall.cells)} cells, {len(made.wall.nodes)} nodes; its underside is held")
    else:
        for name in ("wall.msh", "fem.json", "coupler.json"):  # of a scene that is replaced
            (folder / name).unlink(missing_ok=True)
    return lines + warnings_of(made.plan, made.masses) + made.plan.notes
