# SPDX-License-Identifier: BSD-3-Clause
"""Whether soil and boulder, solved in turn, come together where the boulder is light and steps are long."""

import json
from dataclasses import dataclass
from itertools import product

import numpy as np

from studies.boulders import FACE, GRAVITY, SOIL_DENSITY, Boulder, H, energies, settings_of
from studies.outcome import MAX_GAIN, largest_rise, verdict
from studies.runner import Attempt, Runner, folder_of

YOUNG, POISSON = 10e6, 0.3  # of the soil [Pa]
SIZE, SPEED, END = 3.01, 5.0, 0.3  # in cells; [m/s]; [s]
RATIOS, COURANT = (0.5, 1.0, 3.0), (0.5, 3.0, 10.0)
COHESION = {"yields": 0.0, "elastic": 1e7}  # of the soil [Pa]
HEAD = ["soil", "density over the soil's", "Courant number", "step [ms]", "r", "steps", "cut steps",
        "by the coupling", "solutions a step", "energy gained [%]", "end"]


@dataclass(frozen=True)
class Case:
    soil: str
    ratio: float  #: density over that of the soil
    courant: float  #: of the elastic wave

    @property
    def speed(self) -> float:
        """Of the wave [m/s]."""
        modulus = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
        return float(np.sqrt(modulus / SOIL_DENSITY))

    @property
    def dt(self) -> float:
        return self.courant * H / self.speed

    @property
    def contraction(self) -> float:
        """Factor by which a correction of the force comes back, with the stiffness of an elastic column of soil in a
        step: S A dt^2 / (2 m), S = (rho c / dt) sqrt(1 / beta + 1 / (2 beta C)^2), of a disc."""
        beta = 0.25
        stiffness = SOIL_DENSITY * self.speed / self.dt * np.sqrt(1 / beta + 1 / (2 * beta * self.courant) ** 2)
        radius = 0.5 * SIZE * H
        return float(stiffness * 2 * radius * self.dt**2 / (2 * self.ratio * SOIL_DENSITY * np.pi * radius**2))

    @property
    def boulder(self) -> Boulder:
        return Boulder(self.ratio, SIZE, SPEED, 0.5, is_box=False, implicit=True)

    @property
    def settings(self) -> list[str]:
        return [*settings_of(self.boulder),
                f"mpm.json:/time={json.dumps({'end': END, 'dt': self.dt, 'dt_min': self.dt / 1024})}",
                f"mpm.json:/bodies/0/material/cohesion={COHESION[self.soil]}"]


def row_of(case: Case, attempt: Attempt) -> list:
    first = [case.soil, case.ratio, case.courant, 1e3 * case.dt, case.contraction]
    if attempt.results is None:
        return [*first, "", "", "", "", "", f"exit code {attempt.code}"]
    summary, boulder = attempt.results.summary, case.boulder
    mass = boulder.ratio * SOIL_DENSITY * np.pi * boulder.radius**2
    thrown = 0.5 * mass * 1.09 * boulder.speed**2 + mass * GRAVITY * END * boulder.speed
    both = energies(attempt.results)[0]
    of_newton = sum(summary["solver"]["newton"]["failures"].values())
    return [*first, summary["steps"], summary["cuts"], summary["cuts"] - of_newton,
            summary["solver"]["solutions"] / max(1, summary["steps"]), 100 * largest_rise(both) / thrown,
            verdict(summary)]


def boulder_coupling(runner: Runner) -> None:
    """Light boulders on soil in long implicit steps: solutions a step, cut steps, energy."""
    cases = [Case(*values) for values in product(COHESION, RATIOS, COURANT)]
    attempts = runner.attempts([(folder_of(f"coupling_{case.soil}_{case.ratio:g}_{case.courant:g}"), "column_collapse",
                                 case.settings) for case in cases])
    rows = [row_of(case, attempt) for case, attempt in zip(cases, attempts)]
    runner.report(HEAD, rows)
    ended = sum(row[-1] == "end" for row in rows)
    gained = sum(isinstance(row[-2], float) and row[-2] > 100 * MAX_GAIN for row in rows)
    runner.remark(f"discs of {SIZE:g} cells, thrown at a wall {FACE:g} m from the origin and on soil; r: factor by "
                  "which a correction of the force comes back with the stiffness of an elastic column of soil in a "
                  "step; by the coupling: cut steps that are none of the soil's Newton iteration; "
                  f"{ended} of {len(rows)} runs came to their end, {gained} gained energy")


STUDIES = {boulder_coupling.__name__: boulder_coupling}
