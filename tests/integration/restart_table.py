# SPDX-License-Identifier: BSD-3-Clause
"""Scenes that are stopped and gone on with, one for each method that carries something from step to step.
test_restart_table.py plays them."""

import copy
from collections.abc import Callable
from dataclasses import dataclass

from launch import FEM, MPM, meeting

Scene = dict[str, dict]  # name of a file without .json -> its content


@dataclass(frozen=True)
class Case:
    """A scene, and where its run is stopped. `shows`: a column of steps.csv or probes.csv that must come to this
    value at least, once before the last stop, or the case does not test what its name says."""

    name: str
    scene: Callable[[], Scene]
    stops: tuple[float, ...]  # [s] multiples of the largest dt: no step that was tried went beyond
    shows: tuple[str, float] = ("dt", 0)


def alone(settings: dict, end: float, dt: float = 1e-3, **time: float) -> dict:
    return settings | {"time": {"end": end, "dt": dt, "dt_min": dt / 1024} | time, "output": {"interval": 0.004}}


def gate(**changes: object) -> dict:
    """A rigid wall that the soil meets, by facets."""
    surface = {"polyline": [[0.245, 0.1], [0.245, 0]], "spacing": 0.01}
    return {"name": "gate", "surface": surface, "friction": 0.3} | changes


def held_gate() -> dict:
    """The wall of gate(), by boundary points."""
    return gate(method="boundary_points", penalty=1e7)


def soil(**changes: object) -> dict:
    """Plastic soil that runs against a rigid wall, with walls of both kinds and a probe."""
    settings = copy.deepcopy(MPM)
    del settings["interfaces"]
    return settings | {"rigid_walls": [gate()], "probes": [{"name": "P", "point": [0.2, 0.05]}]} | changes


def box(low: list, high: list, cells: list, kind: str = "quad4") -> dict:
    return {"box": {"low": low, "high": high, "cells": cells, "type": kind}}


def soil_3d() -> dict:
    """The soil of soil(), three cells thick in z and without the rigid wall."""
    settings = soil(dimension=3, grid=box([0, 0, 0], [0.32, 0.12, 0.06], [16, 6, 3], "hex8"), gravity=[0, -9.81, 0])
    settings["walls"] += [{"group": "back", "condition": "slip"}, {"group": "front", "condition": "slip"}]
    settings["bodies"][0] |= {"mesh": box([0.16, 0, 0], [0.24, 0.06, 0.06], [4, 3, 3], "hex8"), "points_per_cell": 8,
                              "velocity": [0.5, 0, 0]}
    settings["probes"] = [{"name": "P", "point": [0.2, 0.05, 0.03]}]
    del settings["rigid_walls"]
    return settings


def two_bodies() -> dict:
    """Clay falls onto the sand."""
    settings = soil()
    clay = settings["bodies"][0] | {"name": "clay", "velocity": [-0.5, 0]}
    clay["mesh"] = box([0.16, 0.06], [0.24, 0.1], [4, 2])
    clay["material"] = {"law": "tresca", "density": 2000, "young_modulus": 1e6, "poisson_ratio": 0.4, "cohesion": 2e3,
                        "tension_cutoff": 0}
    settings["bodies"].append(clay)
    return settings


def phases() -> dict:
    """Soil at rest under K0 is loaded quasi-statically, then shaken by its walls."""
    shaken = [[0, 0, 0], [0.005, 0, 0], [0.01, 0.002, 0], [0.02, -0.002, 0]]
    walls = [{"group": "bottom", "condition": "slip"}, {"group": "left", "condition": "slip"},
             {"group": "right", "condition": "slip"}]
    settings = soil(grid=box([0, 0], [0.1, 0.1], [5, 5]), walls=walls, analysis="quasi_static", phases=[
        {"until": 0.005, "dt": 5e-4, "gravity_ramp": {"duration": 0.005, "from": 1, "to": 1.5}},
        {"analysis": "dynamic", "walls": walls[:1] + [wall | {"motion": {"table": shaken}} for wall in walls[1:]]}])
    body = settings["bodies"][0]
    del body["velocity"], settings["rigid_walls"]
    body["mesh"] = box([0, 0], [0.1, 0.06], [5, 3])
    body["initial_stress"] = {"k0": 0.6, "surface": 0.06}
    return settings


def splash() -> dict:
    """Soil that flies out of the grid."""
    settings = soil(outside="remove", walls=MPM["walls"][:1], gravity=[0, 0])
    del settings["rigid_walls"]
    settings["bodies"][0] |= {"velocity": [20, 0]}
    settings["probes"] = [{"name": "P", "point": [0.16, 0.03]}]
    return settings


def moving_walls() -> dict:
    motion = {"velocity": [-1.0, 0], "rotation": {"centre": [0.245, 0], "rate": 2.0}}
    settings = soil(rigid_walls=[gate(motion=motion)])
    settings["walls"][0]["motion"] = {"table": [[0, 0, 0], [0.01, 0, 1e-3], [0.02, 0, 0]]}
    return settings


def structure(**changes: object) -> dict:
    """A cantilever that is pushed and let go; modified Newton keeps its matrix over the steps."""
    settings = copy.deepcopy(FEM)
    del settings["interfaces"]
    load = {"point": [0.25, 0.05], "force": [3, 0], "table": [[0, 0], [0.01, 1], [0.011, 0]]}
    return settings | {"loads": [load]} | changes


def pulled() -> dict:
    """The top goes to and fro as a table says."""
    prescribed = {"group": "top", "component": "x", "table": [[0, 0], [0.01, 0.01], [0.02, 0]]}
    return structure(prescribed=[prescribed], loads=[], newton={"reuse_matrix": True}, linear_solver={"method": "cg"})


def structure_3d() -> dict:
    settings = structure(dimension=3, gravity=[0, -9.81, 0])
    settings["mesh"] = box([0.25, 0, 0], [0.27, 0.05, 0.02], [2, 5, 2], "hex8")
    settings["loads"][0] |= {"point": [0.25, 0.05, 0], "force": [1, 0, 0.5]}
    settings["probes"] = [{"name": "A", "point": [0.25, 0.05, 0]}]
    return settings


def only_soil(settings: Callable[[], dict], end: float, dt: float = 1e-3, **time: float) -> Callable[[], Scene]:
    return lambda: {"mpm": alone(settings(), end, dt, **time)}


def only_structure(settings: Callable[[], dict]) -> Callable[[], Scene]:
    return lambda: {"fem": alone(settings(), 0.02)}


def scheme(name: str, **parameters: float) -> dict:
    return {"time_integration": {"scheme": name} | parameters}


def coupled(coupling: dict | None = None, **files: dict) -> Callable[[], Scene]:
    """The meeting of launch.py with other settings."""

    def scene() -> Scene:
        made = meeting()
        made["coupler"]["coupling"] |= coupling or {}
        for name, changes in files.items():
            made[name] |= changes
        return made

    return scene


def coupled_explicit() -> Scene:
    made = meeting()
    interface = made["mpm"]["interfaces"][0]
    made["mpm"]["bodies"][0]["velocity"] = [1.5, 0]
    made["mpm"] |= scheme("explicit", courant=0.1) | {
        "interfaces": [{"name": interface["name"], "surface": interface["surface"], "friction": 0.3}]}
    return made


def coupled_3d() -> Scene:
    made = meeting()
    wall = box([0.25, 0, 0], [0.27, 0.05, 0.06], [2, 5, 3], "hex8")
    made["mpm"] = soil_3d() | {"interfaces": [{
        "name": "wall", "surface": {"mesh": wall, "groups": ["left", "top", "right"]}, "friction": 0.3}]}
    made["mpm"]["bodies"][0]["velocity"] = [1, 0, 0]
    made["fem"] |= {"dimension": 3, "gravity": [0, -9.81, 0], "mesh": wall,
                    "probes": [{"name": "A", "point": [0.25, 0.05, 0]}]}
    made["coupler"]["time"] |= {"end": 0.02, "dt": 1e-3}
    return made


def stone(name: str, axes: list, centre: list, velocity: list, **changes: object) -> dict:
    return {"name": name, "shape": {"ellipsoid": axes}, "density": 2650, "centre": centre, "velocity": velocity,
            "friction": 0.5} | changes


def ellipses() -> dict:
    """One rolls, one slides into the wall and back against the first; the soil is elsewhere."""
    floor = gate(name="floor", surface={"polyline": [[0.8, 0.01], [0.1, 0.01]], "spacing": 0.02})
    wall = gate(surface={"polyline": [[0.6, 0.2], [0.6, 0.01]], "spacing": 0.02})
    settings = soil(grid=box([0, 0], [0.8, 0.24], [40, 12]), rigid_walls=[floor, wall])
    settings["bodies"][0] |= {"mesh": box([0, 0], [0.04, 0.04], [2, 2]), "velocity": [0, 0]}
    settings["probes"] = [{"name": "P", "point": [0.02, 0.02]}]
    return settings | {"boulders": [
        stone("rolls", [0.05, 0.035], [0.45, 0.045001], [1, 0], spin=[-28]),
        stone("slides", [0.04, 0.03], [0.55, 0.0489], [2, 0], orientation=[1.2])]}


def ellipsoids() -> dict:
    """Two on a floor in space, one rolls against the other."""
    settings = soil_3d()
    settings["grid"] = box([0, 0, 0], [0.96, 0.32, 0.24], [24, 8, 6], "hex8")
    settings["bodies"][0] |= {"mesh": box([0, 0, 0], [0.08, 0.08, 0.24], [2, 2, 6], "hex8"), "velocity": [0, 0, 0]}
    settings["probes"] = [{"name": "P", "point": [0.04, 0.04, 0.1]}]
    ground = {"mesh": box([0.1, -0.1, 0], [0.96, 0.02, 0.24], [8, 1, 4], "hex8"), "groups": ["back"]}
    return settings | {"rigid_walls": [gate(name="floor", surface=ground)], "boulders": [
        stone("rolls", [0.08, 0.065, 0.07], [0.4, 0.085001, 0.12], [2, 0, 0.1], spin=[0, 0, -30]),
        stone("lies", [0.1, 0.065, 0.07], [0.5841, 0.085001, 0.12], [0, 0, 0])]}


def ellipse_meets_wall() -> Scene:
    """A tilted ellipse against the wall of finite elements, soil far from both."""
    made = meeting()
    settings = made["mpm"]
    settings["bodies"][0] |= {"mesh": box([0, 0], [0.04, 0.04], [2, 2]), "velocity": [0, 0]}
    del settings["interfaces"][0]["method"], settings["interfaces"][0]["penalty"]
    settings["boulders"] = [stone("stone", [0.045, 0.032], [0.2056, 0.045], [0.5, 0], orientation=[0.5],
                                  stiffness=1e8)]
    return made


def accelerated(method: str, scheme: str = "serial_implicit") -> dict:
    return {"scheme": scheme, "acceleration": {"method": method}}


def spline_soil() -> dict:
    return soil(basis="bspline", transfer={"pic_share": 0.1}, rigid_walls=[],
                **scheme("generalized_alpha", rho_inf=0.7))


def triangles() -> dict:
    return soil(grid=box([0, 0], [0.4, 0.16], [20, 8], "tri3"), locking={"method": "fbar"},
                newton={"reuse_matrix": True})


TOUCHED = ("closed_points", 1)  # of the gate, or of the interface
CUT = ("cuts", 1)
CASES = [
    Case("linear functions, FLIP", only_soil(soil, 0.03), (0.005, 0.025), TOUCHED),
    Case("boundary points", only_soil(lambda: soil(rigid_walls=[held_gate()]), 0.03), (0.005, 0.025), TOUCHED),
    Case("gimp, TPIC, F-bar",
         only_soil(lambda: soil(basis="gimp", transfer={"method": "tpic"}, locking={"method": "fbar"}), 0.03),
         (0.006, 0.02), TOUCHED),
    Case("bspline, FLIP with a share of PIC, generalized alpha", only_soil(spline_soil, 0.03), (0.006, 0.02),
         ("points_changed_cell", 1)),
    Case("gimp, F-bar, explicit steps",
         only_soil(lambda: soil(basis="gimp", locking={"method": "fbar"}, **scheme("explicit", courant=0.1)), 0.03),
         (0.005, 0.025), TOUCHED),
    Case("triangles with patches, reused matrices", only_soil(triangles, 0.02), (0.008,)),
    Case("two bodies of different laws", only_soil(two_bodies, 0.02), (0.01,)),
    Case("soil in 3D", only_soil(soil_3d, 0.01), (0.004,)),
    Case("phases from K0: in the first, at its end, in the second", only_soil(phases, 0.015), (0.002, 0.005, 0.012)),
    Case("the same with linear functions and ghost stiffness",
         only_soil(lambda: phases() | {"basis": "linear"}, 0.01), (0.002,)),
    Case("step control of the soil, with cuts",
         only_soil(lambda: soil(step_control={}, newton={"max_iterations": 4}), 0.06, 4e-3, dt_max=8e-3),
         (0.008, 0.032, 0.048), CUT),
    Case("points that leave the grid", only_soil(splash, 0.011), (0.003, 0.01), ("removed_points", 1)),
    Case("moving walls of both kinds", only_soil(moving_walls, 0.02), (0.005, 0.015), TOUCHED),
    Case("ellipses that roll, slide and touch each other, a floor and a wall",
         only_soil(ellipses, 0.03), (0.005, 0.011, 0.025), ("boulder_contact_energy", 1e-6)),
    Case("ellipsoids on a floor, explicit steps",
         only_soil(lambda: ellipsoids() | scheme("explicit"), 0.01), (0.004,), ("boulder_contact_energy", 1e-6)),
    Case("structure, Newmark", only_structure(structure), (0.005, 0.012)),
    Case("structure, Bossak", only_structure(lambda: structure(**scheme("bossak", alpha=-0.2), mass="lumped")),
         (0.005, 0.012)),
    Case("structure, generalized alpha", only_structure(lambda: structure(**scheme("generalized_alpha", rho_inf=0.5))),
         (0.005, 0.012)),
    Case("structure, prescribed motion, reused matrices", only_structure(pulled), (0.005, 0.012)),
    Case("structure, static", only_structure(lambda: structure(analysis="static")), (0.005,)),
    Case("structure in 3D", only_structure(structure_3d), (0.005,)),
    Case("parallel_implicit, iqn_ils", coupled(
        accelerated("iqn_ils", "parallel_implicit") | {"max_iterations": 10}), (0.005, 0.0105), CUT),
    Case("parallel_implicit, mvqn", coupled(accelerated("mvqn", "parallel_implicit")), (0.005, 0.011), TOUCHED),
    Case("few columns of few steps",
         coupled({"acceleration": {"method": "mvqn", "max_columns": 6, "history": 2}}), (0.0105,), TOUCHED),
    Case("explicit, predictor 2", coupled({"scheme": "explicit", "predictor": 2}), (0.011,), TOUCHED),
    Case("coupled, gimp and TPIC, radial basis functions",
         coupled({"mapping": {"method": "radial_basis", "kernel": "thin_plate", "tolerance": 1e-3}},
                 mpm={"basis": "gimp", "transfer": {"method": "tpic"}}), (0.01,), TOUCHED),
    Case("coupled, step control on both sides, with cuts",
         coupled({"step_control": {"few": 3, "many": 5}, "max_iterations": 5}, mpm={"step_control": {}}),
         (0.006, 0.011), CUT),
    Case("coupled, Bossak and lumped mass",
         coupled(mpm=scheme("bossak", alpha=-0.3), fem=scheme("bossak", alpha=-0.3) | {"mass": "lumped"}), (0.011,),
         TOUCHED),
    Case("coupled, explicit steps of the soil", coupled_explicit, (0.011,), TOUCHED),
    Case("ellipse against a structure", ellipse_meets_wall, (0.006, 0.0105), ("boulder_contact_energy", 1e-9)),
    Case("coupled in 3D", coupled_3d, (0.008, 0.014), TOUCHED),
]
