# SPDX-License-Identifier: BSD-3-Clause
"""Whether runs come to an end, keep their points and make no energy, far from the usual settings."""

from dataclasses import dataclass

from studies.outcome import MAX_GAIN, MAX_MOMENTUM, Outcome, outcome
from studies.runner import Runner, folder_of
from studies.throw import Throw, described, settings_of, throws

SCENE = "column_collapse"  # of soil alone, and at a rigid wall
COUPLED = "granular_obstacle"
H, END, DT = 0.01, 0.3, 1e-3  # [m], [s], [s]: coarse and short, so that all runs take minutes
YOUNG = 840e3  # [Pa]
MATERIAL = "mpm.json:/bodies/0/material"
SAMPLE = 16  # runs of the sample, each form of the grid


@dataclass
class Case:
    """One run: its name and what it changes; throw: None for soil alone."""

    name: str
    settings: list[str]
    throw: Throw | None = None

    @property
    def scene(self) -> str:
        return SCENE if self.throw is None or self.throw.density is None else COUPLED


def grid(shift: float) -> str:
    """The grid moved by a share of H to the lower left; soil stays where it is."""
    low = -shift * H
    return (f'mpm.json:/grid={{"box": {{"low": [{low:g}, {low:g}], "high": [{low + 0.8:g}, {low + 0.2:g}], '
            '"cells": [80, 20], "type": "tri3"}}')


def base() -> list[str]:
    return [grid(0), "mpm.json:/bodies/0/mesh/box/cells=[20, 10]", f"mpm.json:/time/end={END:g}", *step(1),
            f"mpm.json:/output/interval={END:g}"]


def step(factor: float) -> list[str]:
    return [f"mpm.json:/time/dt={factor * DT:g}", f"mpm.json:/time/dt_min={factor * DT / 256:g}"]


def cases() -> list[Case]:
    """Soil alone. The base first; then each quantity by itself, and stiffness with step size."""
    young = [f"{MATERIAL}/young_modulus={factor * YOUNG:g}" for factor in (0.1, 1, 10, 100)]
    result = [Case("base", [])]
    for e, setting in zip((0.1, 1, 10, 100), young):
        for dt in (0.25, 1, 5, 20):
            if (e, dt) != (1, 1):
                result.append(Case(f"E_x{e:g}_dt_x{dt:g}", [setting, *step(dt)]))
    result += [Case(f"points_{n}", [f"mpm.json:/bodies/0/points_per_cell={n}"]) for n in (1, 6, 16)]
    result += [Case(f"shift_{s:g}h", [grid(s)]) for s in (0.1, 0.25, 0.5, 0.9)]
    result += [Case(f"psi_{psi:g}", [f"{MATERIAL}/dilation_angle={psi:g}"]) for psi in (10, 19.8)]
    result += [Case(f"c_{c:g}Pa", [f"{MATERIAL}/cohesion={c:g}"]) for c in (10, 1000)]
    return result


def families() -> dict[str, list[Case]]:
    result = {"soil alone": [Case(case.name, [*base(), *case.settings]) for case in cases()]}
    for family, runs in throws(SAMPLE).items():
        result[family] = [Case(name, settings_of(run), run) for name, run in runs.items()]
    return result


def folder(family: str, case: Case) -> str:
    return folder_of(f"{family}_{case.name}")


def family_row(family: str, outcomes: list[Outcome]) -> list:
    def largest(name: str) -> float:
        return float(max(getattr(one, name) for one in outcomes))

    return [family, len(outcomes), sum(one.ended == "end" for one in outcomes),
            sum(not one.named for one in outcomes), sum(one.cuts for one in outcomes), int(largest("iterations")),
            100 * largest("gained"), 100 * largest("contact"), sum(one.behind for one in outcomes),
            largest("momentum")]


HEAD = ["family", "runs", "to the end", "without reason", "cut steps", "most iterations", "energy gained [%]",
        "created by contact [%]", "points lost", "momentum error"]


def stability(runner: Runner) -> None:
    """Soil alone and thrown at walls, extreme settings: each run ends and says why, with its energy and points."""
    everything = [(family, case) for family, listed in families().items() for case in listed]
    attempts = runner.attempts([(folder(family, case), case.scene, case.settings) for family, case in everything])
    outcomes = [outcome(attempt, case.throw) for attempt, (_, case) in zip(attempts, everything)]
    rows = {}
    for (family, _), one in zip(everything, outcomes):
        rows.setdefault(family, []).append(one)
    runner.report(HEAD, [family_row(family, listed) for family, listed in rows.items()])
    runner.remark(f"{sum(one.ended == 'end' for one in outcomes)} of {len(outcomes)} runs came to their end")
    runner.remark("gained: largest increase of kinetic, elastic, contact and gravitational energy together, over the "
                  f"energy of throw and fall, limit {100 * MAX_GAIN:g} %; created by contact: `contact_created` over "
                  "the same energy; points lost: those that left the box or are behind the wall at the end; momentum: "
                  f"error over what throw and gravity gave, limit {MAX_MOMENTUM:g}")
    faulty = [[family, case.name, described(case.throw) if case.throw else "", "; ".join(one.faults)]
              for (family, case), one in zip(everything, outcomes) if one.faults]
    if faulty:
        runner.report(["family", "case", "settings", "what"], faulty, "runs that stopped early or exceeded a limit")


STUDIES = {stability.__name__: stability}
