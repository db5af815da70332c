# SPDX-License-Identifier: BSD-3-Clause
"""Whether runs come to an end, keep their points and make no energy, far from the usual settings."""

import resource
from dataclasses import dataclass

from studies.outcome import MAX_GAIN, MAX_MOMENTUM, Outcome, outcome
from studies.runner import Runner
from studies.throw import Throw, described, settings_of, throws

SCENE = "column_collapse"  # of soil alone, and at a rigid wall
COUPLED = "granular_obstacle"
H, END, DT = 0.01, 0.3, 1e-3  # [m], [s], [s]: coarse and short, so that all runs take minutes
YOUNG = 840e3  # [Pa]
MATERIAL = "mpm.json:/bodies/0/material"
SAMPLE = 24  # runs of the sample, each form of the grid


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
    return f"{family}_{case.name}".replace(",", "").replace(" ", "_")


def family_row(family: str, outcomes: list[Outcome]) -> list:
    return [family, len(outcomes), sum(one.ended == "end" for one in outcomes), sum(not one.named for one in outcomes),
            sum(one.cuts for one in outcomes), max(one.iterations for one in outcomes),
            *(float(100 * max(one.gained for one in outcomes)), float(100 * max(one.contact for one in outcomes))),
            sum(one.behind for one in outcomes), float(max(one.momentum for one in outcomes))]


HEAD = ["family", "runs", "to the end", "without reason", "cut steps", "most iterations", "energy gained [%]",
        "made by contact [%]", "points lost", "momentum error"]
FULL_HEAD = ["family", "case", "ended", "steps", "cuts", "iterations", "gained", "contact", "momentum", "behind",
             "setting"]


def stability(runner: Runner) -> None:
    """Soil alone and thrown at walls, with every setting far off: each run ends, named, and keeps energy and points."""
    listed = families()
    attempts = iter(runner.attempts([(folder(family, case), case.scene, case.settings)
                                     for family, all_cases in listed.items() for case in all_cases]))
    outcomes = {family: [outcome(next(attempts), case.throw) for case in all_cases]
                for family, all_cases in listed.items()}
    everything = [(family, case, one) for family in listed for case, one in zip(listed[family], outcomes[family])]
    runner.keep(FULL_HEAD, [[family, case.name, one.ended, one.steps, one.cuts, one.iterations, one.gained, one.contact,
                             one.momentum, one.behind, described(case.throw) if case.throw else ""]
                            for family, case, one in everything], "runs")
    runner.report(HEAD, [family_row(family, all_outcomes) for family, all_outcomes in outcomes.items()])
    ended = sum(one.ended == "end" for _, _, one in everything)
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    runner.remark(f"{ended} of {len(everything)} runs came to their end; {(spent.ru_utime + spent.ru_stime) / 60:.0f} "
                  "minutes of one core")
    runner.remark(f"gained: largest rise of kinetic, elastic, contact's and gravity's energy together over the energy of "
                  f"throw and fall, limit {100 * MAX_GAIN:g} %. Made by contact: `contact_created` over the same. Momentum: "
                  f"error over what throw and gravity gave, limit {MAX_MOMENTUM:g}")
    rows = [[family, case.name, described(case.throw) if case.throw else "", "; ".join(one.faults)]
            for family, case, one in everything if one.faults]
    if rows:
        runner.report(["family", "case", "settings", "what"], rows, "not to the end, or beyond a limit")


STUDIES = {stability.__name__: stability}
