# SPDX-License-Identifier: BSD-3-Clause
"""Whether the soil solver comes to an end, and makes no energy, far from the usual settings."""

from dataclasses import dataclass

import numpy as np

from plotting.column import front_of, surface_of
from plotting.results import Results, ResultsError
from studies.runner import Runner

SCENE = "column_collapse"
H, END, DT = 0.01, 0.3, 1e-3  # [m], [s], [s]: coarse and short, so that all runs take minutes
SPACING = 0.005  # [m] mean distance of points, 3 in a triangle of H
YOUNG = 840e3  # [Pa]
MATERIAL = "mpm.json:/bodies/0/material"


@dataclass
class Case:
    """One run: its name and what it changes."""

    name: str
    settings: list[str]


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
    """The base first; then each quantity by itself, and stiffness with step size."""
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


def verdict(summary: dict) -> str:
    """"end", or why and when the run stopped: the causes of its failed steps."""
    if summary.get("completed", False):
        return "end"
    causes = ", ".join(f"{n} x {cause}" for cause, n in summary["solver"]["newton"]["failures"].items())
    if not summary.get("reason") or not causes:
        raise ResultsError("a run ended without a reason")
    return f"{summary['end_time']:.3g} s: {causes}"


def last_points(results: Results) -> np.ndarray:
    soil = results.soil
    if soil is None:
        raise ResultsError(f"{results.folder}: no mpm/soil.xdmf")
    return soil.frame(len(soil) - 1).points


def stability(runner: Runner) -> None:
    """Soil alone with stiffness, step size, points, grid and strength far off: every run ends, named."""
    rows, reference = [], None
    for case in cases():
        results = runner.attempt(case.name, SCENE, [*base(), *case.settings])
        summary, points = results.summary, last_points(results)
        if reference is None:
            reference = surface_of(points, SPACING)
        ended = summary["completed"]
        height = np.interp(reference[0], *surface_of(points, SPACING), right=0)
        difference = 1e3 * float(np.mean(np.abs(height - reference[1]))) if ended else ""
        mean = summary["solver"]["newton"]["mean"]
        rows.append([case.name, verdict(summary), summary["steps"], summary["cuts"],
                     "" if mean is None else float(mean), front_of(points, SPACING), difference,
                     float(results.table("probes.csv")["created_energy"][-1]),
                     float(summary["wall_seconds"]["total"])])
    head = ["case", "ended", "steps", "cuts", "Newton mean", "front [m]", "height against base [mm]",
            "energy created [J/m]", "run time [s]"]
    runner.report(head, rows)
    runner.remark(f"{sum(row[1] == 'end' for row in rows)} of {len(rows)} runs came to their end")


STUDIES = {stability.__name__: stability}
