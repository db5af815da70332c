# SPDX-License-Identifier: BSD-3-Clause
"""Whether runs with a boulder come to an end and make no energy: light and heavy, small and large, slow and fast."""

import json
from dataclasses import dataclass, fields

import numpy as np
from scipy.stats import qmc

from plotting.results import Results, ResultsError
from studies.outcome import MAX_GAIN, MAX_MOMENTUM, largest_rise, verdict
from studies.runner import Attempt, Runner, folder_of

SCENE = "column_collapse"  # all that it has is set anew
H, DEPTH, FACE = 0.2, 1.6, 9.8  # [m] of a cell, of the soil, x of the barrier
SOIL_DENSITY, GRAVITY = 1800, 9.81
END, DT = 0.4, 1e-3  # [s]
RUNS, SEED = 40, 7
HEAD = ["boulders", "runs", "to the end", "without reason", "cut steps", "energy gained [%]", "work not found [%]",
        "momentum error"]


@dataclass(frozen=True)
class Boulder:
    """ratio: density over that of the soil; size: diameter in cells, at least the least allowed."""

    ratio: float
    size: float
    speed: float  #: [m/s]
    restitution: float
    is_box: bool
    implicit: bool

    @property
    def radius(self) -> float:
        return 0.5 * self.size * H


def boulders() -> list[Boulder]:
    """Latin hypercube: mass ratio 0.5 to 3, 3 to 20 cells, 0.3 to 30 m/s, restitution 0 to 1."""
    shares = qmc.LatinHypercube(4, seed=SEED).random(RUNS)
    least = [3.01 * (2 / np.sqrt(np.pi) if k % 4 == 3 else 1) for k in range(RUNS)]  # cells; a box is thinner
    return [Boulder(round(0.5 * 6**ratio, 3), round(least[k] * (20 / least[k]) ** size, 3),
                    round(0.3 * 100**speed, 3), round(e, 3), is_box=k % 4 == 3, implicit=k % 4 == 2)
            for k, (ratio, size, speed, e) in enumerate(shares)]


def settings_of(boulder: Boulder) -> list[str]:
    """Level soil in a pit; the boulder flies at the barrier, comes back and falls on the soil."""
    radius = boulder.radius
    side = radius * np.sqrt(np.pi)  # a box of the area of the disc
    shape = {"box": [side, side]} if boulder.is_box else {"radius": radius}
    reach = side / np.sqrt(2) if boulder.is_box else radius
    mpm = {
        "grid": {"box": {"low": [0, 0], "high": [10, 8], "cells": [50, 40], "type": "quad4"}},
        "walls": [{"group": "bottom", "condition": "fixed"}],
        "locking": {"method": "fbar"},
        "time_integration": {"scheme": "newmark" if boulder.implicit else "explicit"},
        "bodies": [{"name": "soil", "points_per_cell": 4,
                    "mesh": {"box": {"low": [0.2, 0], "high": [FACE, DEPTH], "cells": [48, 8], "type": "quad4"}},
                    "material": {"law": "mohr_coulomb", "density": SOIL_DENSITY, "young_modulus": 10e6,
                                 "poisson_ratio": 0.3, "friction_angle": 35}}],
        "rigid_walls": [{"name": name, "surface": {"polyline": polyline, "spacing": H}, "friction": 0.4}
                        for name, polyline in (("barrier", [[FACE, 8], [FACE, 0]]), ("back", [[0.2, 0], [0.2, 8]]))],
        "boulders": [{"name": "rock", "shape": shape, "density": boulder.ratio * SOIL_DENSITY, "friction": 0.5,
                      "soil_friction": 0.6, "restitution": boulder.restitution,
                      "centre": [FACE - reach - 0.05, DEPTH + reach + 0.05], "orientation": [0.3],
                      "velocity": [boulder.speed, -0.3 * boulder.speed]}],
        "time": {"end": END, "dt": DT, "dt_min": DT / 1024}, "output": {"interval": END},
    }
    return [f"mpm.json:/{key}={json.dumps(value)}" for key, value in mpm.items()]


@dataclass
class Outcome:
    """Numbers of a run that left nothing are 0; gained, unfound over the energy of throw and fall."""

    ended: str
    named: bool
    cuts: int = 0
    gained: float = 0  #: largest rise of the energy of soil and boulder
    unfound: float = 0  #: change of the boulder's energy less the works of gravity, soil and contact
    momentum: float = 0  #: error of the soil's momentum over that of the boulder

    @property
    def faults(self) -> list[str]:
        found = [] if self.ended == "end" else [self.ended]
        found += [f"energy + {100 * self.gained:.2g} %"] * (self.gained > MAX_GAIN)
        found += [f"work not found {100 * self.unfound:.1g} %"] * (self.unfound > MAX_GAIN)
        return found + [f"momentum error {self.momentum:.1g}"] * (self.momentum > MAX_MOMENTUM)


def energies(results: Results) -> tuple[np.ndarray, np.ndarray]:
    """Energy of soil and boulder together, and of the boulder less the works on it [J/m]."""
    table = results.table("probes.csv")
    boulder = table["boulders_kinetic_energy"] - table["boulders_gravity_work"] + table["boulder_contact_energy"]
    soil = sum(table[f"{kind}_energy"] for kind in ("kinetic", "elastic", "contact")) - table["gravity_work"]
    lost = table["boulders_contact_loss"] + table["boulders_surface_work"] - table["boulders_soil_work"]
    return soil + boulder, boulder + lost


def outcome(attempt: Attempt, boulder: Boulder) -> Outcome:
    if attempt.results is None:
        return Outcome("no end" if attempt.code is None else f"exit code {attempt.code}, nothing written", named=False)
    results = attempt.results
    try:
        ended, named = verdict(results.summary), attempt.code in (0, 3)
    except ResultsError as error:
        ended, named = str(error), False
    mass = boulder.ratio * SOIL_DENSITY * np.pi * boulder.radius**2
    thrown = 0.5 * mass * 1.09 * boulder.speed**2 + mass * GRAVITY * END * boulder.speed
    both, alone = energies(results)
    table = results.table("probes.csv")
    error = np.hypot(table["momentum_error_x"], table["momentum_error_y"])
    scale = mass * (boulder.speed + GRAVITY * END) + table["mass"][0] * GRAVITY * END
    return Outcome(ended, named, results.summary["steps"] and results.summary["cuts"],
                   largest_rise(both) / thrown, float(np.ptp(alone)) / thrown, float(np.max(error)) / scale)


def kind(boulder: Boulder) -> str:
    return "boxes, explicit" if boulder.is_box else f"discs, {'implicit' if boulder.implicit else 'explicit'}"


def described(boulder: Boulder) -> str:
    return ", ".join(f"{field.name} {getattr(boulder, field.name):g}" for field in fields(boulder)[:4])


def boulder_sweep(runner: Runner) -> None:
    """A boulder against barrier and soil, over mass ratio, size, speed and restitution: each run ends and says why."""
    cases = boulders()
    attempts = runner.attempts([(folder_of(f"boulder_{k}"), SCENE, settings_of(case)) for k, case in enumerate(cases)])
    outcomes = [outcome(attempt, case) for attempt, case in zip(attempts, cases)]
    rows = []
    for name in dict.fromkeys(map(kind, cases)):
        listed = [one for one, case in zip(outcomes, cases) if kind(case) == name]
        rows.append([name, len(listed), sum(one.ended == "end" for one in listed), sum(not one.named for one in listed),
                     sum(one.cuts for one in listed), 100 * max(one.gained for one in listed),
                     100 * max(one.unfound for one in listed), max(one.momentum for one in listed)])
    runner.report(HEAD, rows)
    runner.remark(f"{sum(one.ended == 'end' for one in outcomes)} of {len(outcomes)} runs came to their end")
    faulty = [[k, described(case), kind(case), "; ".join(one.faults)]
              for k, (one, case) in enumerate(zip(outcomes, cases)) if one.faults]
    if faulty:
        runner.report(["run", "settings", "boulder", "what"], faulty, "runs that stopped early or exceeded a limit")


STUDIES = {boulder_sweep.__name__: boulder_sweep}
