# SPDX-License-Identifier: BSD-3-Clause
"""Whether runs in which soil breaks a wall come to an end and make no energy, over what breaks it and how."""

import json
from dataclasses import dataclass, fields

import numpy as np
from scipy.stats import qmc

from plotting.results import ResultsError
from studies.outcome import MAX_GAIN, MAX_MOMENTUM, column, largest_rise, total_energy, verdict
from studies.runner import Attempt, Runner, folder_of

SCENE = "granular_obstacle"
END, GRAVITY = 0.08, 9.81  # [s, m/s^2]
FACE, HEIGHT = 0.25, 0.05  # [m] x of the wall, its height
RUNS, SEED = 36, 11
HEAD = ["layers", "runs", "to the end", "without reason", "cells failed", "runs with soil behind", "cut steps",
        "coupling iterations, at most", "energy gained [%]", "energy not found [%]", "momentum error"]


@dataclass(frozen=True)
class Wall:
    """layers: cells over its thickness of 5 mm each; yield_stress [Pa]; dt [s]; speed of the soil [m/s]."""

    layers: int
    fade_steps: int
    yield_stress: float
    strain: float
    dt: float
    speed: float


def walls() -> list[Wall]:
    """Latin hypercube: yield stress 1 to 100 kPa, strain at failure 0.03 to 0.3, dt 0.1 to 1 ms, 0.5 to 4 m/s."""
    shares = qmc.LatinHypercube(4, seed=SEED).random(RUNS)
    return [Wall(1 + k % 3, (1, 3, 10)[k // 3 % 3], round(1e3 * 100**a, 1), round(0.03 * 10**b, 4),
                 float(f"{1e-4 * 10**c:.2e}"), round(0.5 * 8**d, 3)) for k, (a, b, c, d) in enumerate(shares)]


def settings_of(wall: Wall) -> list[str]:
    """Sand runs at a wall of metal that has no weight; all of its cells may fail."""
    mesh = {"box": {"low": [FACE, 0], "high": [FACE + 0.005 * wall.layers, HEIGHT], "cells": [wall.layers, 10],
                    "type": "quad4"}}
    wet = {"groups": ["left", "top", "right"], "behind": ["all"]}
    fem = {"mesh": mesh, "gravity": [0, 0], "initial_equilibrium": False, "mass": "lumped",
           "material": {"law": "von_mises", "density": 1100, "young_modulus": 1e7, "poisson_ratio": 0.3,
                        "yield_stress": wall.yield_stress, "hardening_modulus": 1e5,
                        "failure_plastic_strain": wall.strain, "fade_steps": wall.fade_steps},
           "interfaces": [{"name": "wall"} | wet]}
    soil = {"mesh": {"box": {"low": [0.14, 0], "high": [0.24, 0.06], "cells": [20, 12], "type": "quad4"}},
            "velocity": [wall.speed, 0]}
    grid = {"box": {"low": [0, 0], "high": [0.4, 0.4], "cells": [80, 80], "type": "quad4"}}  # sand splashes up
    mpm = {"grid": grid, "interfaces": [{"name": "wall", "surface": {"mesh": mesh} | wet, "friction": 0.36}],
           "walls": [{"group": side, "condition": "slip"} for side in ("left", "bottom", "right")]}
    pairs = [(f"fem.json:/{key}", value) for key, value in fem.items()]
    pairs += [(f"mpm.json:/{key}", value) for key, value in mpm.items()]
    pairs += [(f"mpm.json:/bodies/0/{key}", value) for key, value in soil.items()]
    pairs += [("coupler.json:/time", {"end": END, "dt": wall.dt, "dt_min": wall.dt / 1024}),
              ("coupler.json:/output/interval", END)]
    return [f"{place}={json.dumps(value)}" for place, value in pairs]


@dataclass
class Outcome:
    """Numbers of a run that left nothing are 0; energies over that of the throw and the fall."""

    ended: str
    named: bool
    failed: int = 0  #: cells
    behind: int = 0  #: material points behind the wall at the end
    cuts: int = 0
    iterations: int = 0
    gained: float = 0  #: largest rise of the energy of soil and wall
    unfound: float = 0  #: energy of the wall less the work on it, at most
    momentum: float = 0  #: error of the soil's momentum over what throw and weight gave

    @property
    def faults(self) -> list[str]:
        found = [] if self.ended == "end" else [self.ended]
        found += [f"energy + {100 * self.gained:.2g} %"] * (self.gained > MAX_GAIN)
        return found + [f"momentum error {self.momentum:.1g}"] * (self.momentum > MAX_MOMENTUM)


def outcome(attempt: Attempt, wall: Wall) -> Outcome:
    if attempt.results is None:
        return Outcome("no end" if attempt.code is None else f"exit code {attempt.code}, nothing written", named=False)
    results, summary = attempt.results, attempt.results.summary
    try:
        ended, named = verdict(summary), attempt.code in (0, 3)
    except ResultsError as error:
        ended, named = str(error), False
    table = results.table("probes.csv")
    mass, duration = column(results, "mass")[0], column(results, "time")[-1]
    energy = 0.5 * mass * wall.speed**2 + np.max(np.abs(column(results, "gravity_work")))
    spent = sum(table[f"structure.{name}"] for name in ("kinetic_energy", "elastic_energy", "plastic_work",
                                                        "failed_energy"))
    error = np.hypot(column(results, "momentum_error_x"), column(results, "momentum_error_y"))
    soil = results.frames_of_soil()
    last = soil.frame(len(soil) - 1).points
    return Outcome(
        ended, named, int(table["structure.failed_cells"][-1]),
        int(np.sum(last[:, 0] > FACE + 0.005 * wall.layers)), summary["cuts"], summary["coupling_iterations"]["max"],
        largest_rise(total_energy(results)) / energy,
        float(np.max(np.abs(spent - table["structure.external_work"]))) / energy,
        float(np.max(error)) / (mass * (wall.speed + GRAVITY * duration)))


def described(wall: Wall) -> str:
    return ", ".join(f"{field.name} {getattr(wall, field.name):g}" for field in fields(wall))


def breaking_sweep(runner: Runner) -> None:
    """Sand that breaks a wall, over yield stress, failure strain, fading, layers, step and speed: each run ends."""
    cases = walls()
    attempts = runner.attempts([(folder_of(f"wall_{k}"), SCENE, settings_of(case)) for k, case in enumerate(cases)])
    outcomes = [outcome(attempt, case) for attempt, case in zip(attempts, cases)]
    rows = []
    for layers in sorted({case.layers for case in cases}):
        listed = [one for one, case in zip(outcomes, cases) if case.layers == layers]
        rows.append([layers, len(listed), sum(one.ended == "end" for one in listed),
                     sum(not one.named for one in listed), sum(one.failed for one in listed),
                     sum(one.behind > 0 for one in listed), sum(one.cuts for one in listed),
                     max(one.iterations for one in listed), 100 * max(one.gained for one in listed),
                     100 * max(one.unfound for one in listed), max(one.momentum for one in listed)])
    runner.report(HEAD, rows)
    runner.remark(f"{sum(one.ended == 'end' for one in outcomes)} of {len(outcomes)} runs came to their end")
    faulty = [[k, described(case), "; ".join(one.faults)]
              for k, (one, case) in enumerate(zip(outcomes, cases)) if one.faults]
    if faulty:
        runner.report(["run", "wall", "what"], faulty, "runs that stopped early or exceeded a limit")


STUDIES = {breaking_sweep.__name__: breaking_sweep}
