# SPDX-License-Identifier: BSD-3-Clause
"""What the laws of soils that soften and flow cost in Newton iterations, and whether their runs come to an end."""

import json

from plotting.results import ResultsError
from studies.outcome import MAX_GAIN, MAX_MOMENTUM, outcome
from studies.runner import Runner, folder_of

H = 0.01  # [m]: coarse, so that a run takes seconds
DT, END = 1e-3, 0.3  # [s]
MOST = 1.3  # iterations a step over those of Mohr-Coulomb
HOOKE = {"density": 2650, "young_modulus": 840e3, "poisson_ratio": 0.3}
SAND = {"law": "mohr_coulomb", **HOOKE, "friction_angle": 19.8, "dilation_angle": 0, "cohesion": 0}
DENSE = {**SAND, "friction_angle": 35, "dilation_angle": 8}
CLAY = {"law": "tresca", **HOOKE, "poisson_ratio": 0.45, "cohesion": 500}
MUD = {"law": "herschel_bulkley", **HOOKE, "poisson_ratio": 0.45, "yield_stress": 200, "consistency": 15}
GRAINS = {"law": "mu_i", **HOOKE, "static_friction": 0.36, "limit_friction": 0.64, "inertial_number": 0.279,
          "grain_size": 5e-4, "grain_density": 2650}
CLAY_WITH_MEMORY = {"law": "cam_clay", "density": 2650, "compression_index": 0.05, "swelling_index": 0.01,
                    "critical_state_ratio": 0.98, "poisson_ratio": 0.3, "reference_pressure": 1000}
# Densities and moduli of them all are those of the sand, so that steps and waves are alike.
LAWS = {
    "Mohr-Coulomb": SAND,
    "Mohr-Coulomb that softens": {**DENSE, "softening": {"slip": 0.01, "residual_friction_angle": 20}},
    "Tresca": CLAY,
    "Tresca that softens": {**CLAY, "softening": {"slip": 0.01, "residual_cohesion": 200}},
    "Bingham": MUD,
    "Herschel-Bulkley, flow index 0.5": {**MUD, "flow_index": 0.5},
    "mu(I)": GRAINS,
    "Newtonian fluid": {"law": "newtonian", "density": 2650, "sound_speed": 20, "viscosity": 5},
    "Cam-Clay": CLAY_WITH_MEMORY,
}
HEIGHT = 0.1  # [m] of the column


def box(low: tuple, high: tuple, cells: tuple) -> dict:
    return {"box": {"low": low, "high": high, "cells": cells, "type": "quad4"}}


def column(material: dict) -> dict:
    """A body of 0.2 x 0.1 m, 800 points. Cam-Clay, which has no strength without pressure, starts with the stress of
    level ground, which is not in balance once the column is free at its side."""
    body = {"name": "soil", "mesh": box((0, 0), (0.2, HEIGHT), (20, 10)), "points_per_cell": 4, "material": material}
    if material["law"] == "cam_clay":
        body["initial_stress"] = {"k0": 0.5, "surface": HEIGHT, "max_displacement": HEIGHT}
    return body


def column_settings(material: dict, dt: float = DT, end: float = END) -> list[str]:
    """A column that collapses."""
    body = column(material)
    values = {"grid": box((0, 0), (1.2, 0.15), (120, 15)), "locking": {"method": "fbar"}, "bodies": [body],
              "time": {"end": end, "dt": dt, "dt_min": dt / 256}, "output": {"interval": end}}
    return [f"mpm.json:/{key}={json.dumps(value)}" for key, value in values.items()]


def obstacle_settings(material: dict) -> list[str]:
    """The scene with cells of twice the size, until the soil has hit the wall."""
    body = column(material)
    values = {"mpm.json:/grid": box((0, 0), (0.4, 0.15), (40, 15)), "mpm.json:/bodies": [body],
              "mpm.json:/locking": {"method": "fbar"}, "coupler.json:/time/end": END,
              "coupler.json:/output/interval": END}
    return [f"{key}={json.dumps(value)}" for key, value in values.items()]


def newton_of(summary: dict) -> dict:
    return (summary["participants"]["soil"] if "participants" in summary else summary["solver"])["newton"]


def laws(runner: Runner) -> None:
    """Newton iterations of laws that soften and flow, over those of Mohr-Coulomb: a column, soil that hits a wall."""
    scenes = {"column": ("column_collapse", column_settings), "obstacle": ("granular_obstacle", obstacle_settings)}
    runs = [(folder_of(f"{where}_{name}"), scene, settings(material))
            for where, (scene, settings) in scenes.items() for name, material in LAWS.items()]
    attempts = dict(zip([(where, name) for where in scenes for name in LAWS], runner.attempts(runs)))
    rows = []
    for name in LAWS:
        row = [name]
        for where in scenes:
            attempt, base = attempts[where, name], attempts[where, next(iter(LAWS))]
            if attempt.code != 0 or base.code != 0:
                raise ResultsError(f"{where}, {name}: the run did not come to its end")
            found, reference = (newton_of(one.results.summary) for one in (attempt, base))
            row += [found["mean"], found["max"], found["mean"] / reference["mean"], found["iterations"]]
        rows.append(row)
    runner.report(["law", *(f"{where}: {what}" for where in scenes
                            for what in ("iterations a solution", "at most", "over Mohr-Coulomb", "in all"))], rows)
    runner.remark(f"limit over Mohr-Coulomb: {MOST:g}")


SOFT = {
    "sand, brittle": {**DENSE, "softening": {"slip": 1e-3, "residual_friction_angle": 20}},
    "sand, ductile": {**DENSE, "softening": {"slip": 0.03, "residual_friction_angle": 20}},
    "sand, Rowe": {**DENSE, "softening": {"slip": 0.01, "residual_friction_angle": 25, "dilation": "rowe"}},
    "cemented sand": {**DENSE, "cohesion": 1000, "softening": {"slip": 0.01, "residual_cohesion": 0,
                                                               "residual_friction_angle": 25}},
    "sand, hardens first": {**DENSE, "softening": {"table": [[0.003, 0, 38, 10], [0.02, 0, 30, 0]]}},
    "clay": {**CLAY, "softening": {"slip": 0.01, "residual_cohesion": 100}},
    "quick clay": {**CLAY, "cohesion": 1000, "softening": {"slip": 2e-3, "residual_cohesion": 400,
                                                           "remoulded_cohesion": 10, "remoulding_slip": 0.05}},
    "clay at a rate": {**CLAY, "softening": {"slip": 0.01, "residual_cohesion": 100, "relaxation_time": 0.02}},
    "Bingham": MUD,
    "thinning mud": {**MUD, "yield_stress": 20, "flow_index": 0.3},
    "thickening mud": {**MUD, "yield_stress": 20, "consistency": 2, "flow_index": 2},
    "grains": {**GRAINS, "grain_size": 5e-3},
}
WAYS: dict[str, tuple[float, list[str]]] = {
    "dt 1 ms": (1, []),
    "dt 5 ms": (5, []),
    "dt 20 ms": (20, []),
    "explicit": (1, ['mpm.json:/time_integration={"scheme": "explicit"}']),
    "linear, 9 points": (1, ['mpm.json:/basis="linear"', "mpm.json:/bodies/0/points_per_cell=9"]),
}


def law_stability(runner: Runner) -> None:
    """Columns of soil that softens or flows at a rate, over step sizes and schemes: each run ends and says why."""
    cases = [(name, way) for name in SOFT for way in WAYS]
    runs = [(folder_of(f"{name}_{way}"), "column_collapse",
             [*column_settings(SOFT[name], WAYS[way][0] * DT), *WAYS[way][1]]) for name, way in cases]
    outcomes = dict(zip(cases, (outcome(attempt, None) for attempt in runner.attempts(runs))))
    rows = []
    for name in SOFT:
        found = [outcomes[name, way] for way in WAYS]
        rows.append([name, len(found), sum(one.ended == "end" for one in found), sum(not one.named for one in found),
                     sum(one.cuts for one in found), 100 * max(one.gained for one in found),
                     max(one.momentum for one in found)])
    runner.report(["soil", "runs", "to the end", "without reason", "cut steps", "energy gained [%]",
                   "momentum error"], rows)
    runner.remark(f"{sum(one.ended == 'end' for one in outcomes.values())} of {len(cases)} runs came to their end; "
                  f"limits: energy {100 * MAX_GAIN:g} %, momentum {MAX_MOMENTUM:g}")
    faulty = [[name, way, "; ".join(one.faults)] for (name, way), one in outcomes.items() if one.faults]
    if faulty:
        runner.report(["soil", "way", "what"], faulty, "runs that stopped early or exceeded a limit")


STUDIES = {"laws": laws, "law_stability": law_stability}
