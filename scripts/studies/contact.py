# SPDX-License-Identifier: BSD-3-Clause
"""How much of the answer of granular_obstacle is the method's: contact, basis functions, cells.

Each row is an ensemble: single runs scatter by as much as these choices change the answer.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from studies.coupled import (ANSWER, ANSWER_NAMES, EXPLICIT, IMPACT_END, REST, SCENE, answer_of, step_size,
                             without_limits)
from studies.ensemble import deviation, error, mean_and_error, over_places
from studies.measures import Measured
from studies.runner import Runner

PAPER = f"{SCENE}_paper"
INTERFACE = "mpm.json:/interfaces/0"
EXPLICIT_STEPS = [EXPLICIT, without_limits("approach"),
                  "mpm.json:/outside=remove"]  # a grain of the splash that flies over the grid
FINEST = ["mpm.json:/grid/box/cells=[320,160]", "mpm.json:/grid/box/high=[0.4,0.2]",
          "mpm.json:/bodies/0/mesh/box/cells=[160,80]", f"{INTERFACE}/surface/spacing=6.25e-4"]
SIZES = {"5": 8, "2.5": 6, "1.25": 3}  # [mm], runs
STEPS = {"5": 5e-4, "2.5": 2.5e-4, "1.25": 1.25e-4}  # [mm], [s]: of three or four substeps
TIME_STEPS = (1e-3, 5e-4, 2e-4, 5e-5)  # [s]
LOCKING = "mpm.json:/locking/method"
REMEDIES = {"fbar": "F-bar", "none": "no F-bar", "noise": "F-bar, noise kept"}  # for locking and noise
SETTINGS_OF_REMEDY = {"fbar": [f"{LOCKING}=fbar"], "none": [f"{LOCKING}=none"],
           "noise": [f"{LOCKING}=fbar", "mpm.json:/transfer/noise_damping=0"]}


def explicit(dt: float) -> list[str]:
    """Explicit steps of dt [s]; shorter only where a surface would go too far into the soil."""
    return [*EXPLICIT_STEPS, *step_size(dt)]


def body(cells: list[int], cell_type: str) -> str:
    box = {"low": [0, 0], "high": [0.2, 0.1], "cells": cells, "type": cell_type}
    return f"mpm.json:/bodies/0/mesh={json.dumps({'box': box})}"


def triangles(name: str, cells: list[int], points: int = 6) -> list[str]:
    """Unstructured grid of triangles NAME.msh; points in each triangle of the body, which has other triangles."""
    grid = {"file": f"../{PAPER}/{name}.msh"}
    return [f"mpm.json:/grid={json.dumps(grid)}", body(cells, "tri3"), f"mpm.json:/bodies/0/points_per_cell={points}"]


def squares_of_triangles() -> list[str]:
    """Cells of 3.3 mm, as large as the triangles whose edges are 5 mm."""
    box = {"low": [0, 0], "high": [0.4, 0.15], "cells": [120, 45], "type": "quad4"}
    return [f"mpm.json:/grid={json.dumps({'box': box})}", body([60, 30], "quad4"), "mpm.json:/basis=linear",
            f"{INTERFACE}/surface/spacing=1.667e-3"]


def forms_of(fine: bool) -> dict[str, list[str]]:
    """Basis functions and cells, four combinations."""
    return {
        "quad4, gimp": [],
        "quad4, bspline": ["mpm.json:/basis=bspline"],
        "quad4, linear": ["mpm.json:/basis=linear"],
        "tri3": triangles("fine", [80, 40]) if fine else triangles("grid", [40, 20]),
    }


HEAD = ["", "runs", "peak of A [mm]", "residual [mm]", "peak force [N/m]", "force at rest [N/m]",
        f"impulse to {IMPACT_END:g} s [N s/m]", "impulse [N s/m]", "energy balance [%]", "iterations", "cuts",
        "CPU time [s]"]


def row_of(name: str, runs: list[Measured]) -> list:
    peak, rest, force, impact, impulse = (mean_and_error(values) for values in zip(*map(answer_of, runs)))
    steps = [run.table("steps.csv") for run in runs]
    largest = mean_and_error([float(np.max(of["fx"])) for of in steps])
    return [name, len(runs), peak, rest, largest, force, impact, impulse,
            float(np.mean([energy_balance(run) for run in runs])),
            float(np.mean([np.mean(run.iterations_in_contact()) for run in runs])),
            sum(run.cuts() for run in runs),
            float(np.mean([run.solver_seconds() for run in runs]))]


def energy_balance(run: Measured) -> float:
    """Energy of the soil that is unaccounted for at the end, by the work of gravity [%]."""
    table = run.table("probes.csv")
    return 100 * float(table["soil.energy_balance"][-1] / table["soil.gravity_work"][-1])


def answers_of(ensembles: dict[str, list[Measured]]) -> Iterator[tuple]:
    """Values of each number of ANSWER in all runs, ensemble by ensemble."""
    return zip(*(zip(*map(answer_of, runs)) for runs in ensembles.values()))


def report_range(runner: Runner, forms: dict[str, list[Measured]], title: str) -> None:
    """How far the means of forms lie apart, by their mean, beside their standard errors."""
    rows = []
    for name, values in zip(ANSWER_NAMES, answers_of(forms)):
        means = [np.mean(of_form) for of_form in values]
        rows.append([name, *(100 * float(value / np.mean(means)) for value in (
            np.ptp(means), np.mean([error(v) for v in values]), np.mean([deviation(v) for v in values])))])
    head = ["", "range of the means [%]", "standard error of a mean [%]", "deviation of a run [%]"]
    runner.report(head, rows, title)


def forms(runner: Runner, size: str, members: dict[str, int]) -> None:
    """Report the ensembles of forms_of; size of STEPS; members: remedy -> runs."""
    found = {remedy: {name: form(runner, name, size, remedy, number) for name in forms_of(fine=False)}
             for remedy, number in members.items()}
    runner.report(HEAD, [row_of(f"{name}, {REMEDIES[remedy]}", runs) for remedy, of_remedy in found.items()
                         for name, runs in of_remedy.items()], f"h = {size} mm")
    for remedy, of_remedy in found.items():
        report_range(runner, of_remedy, f"the four discretisations, {REMEDIES[remedy]}")


def form(runner: Runner, name: str, size: str, remedy: str, members: int) -> list[Measured]:
    """Ensemble of one of forms_of."""
    scene = SCENE if size == "5" else f"{SCENE}_fine"
    finest = FINEST if size == "1.25" else []
    settings = [*explicit(STEPS[size]), *forms_of(size == "2.5")[name], *finest, *SETTINGS_OF_REMEDY[remedy]]
    return over_places(runner, f"{name} {size} {remedy}", scene, settings, members, 1e-3 * float(size))


@dataclass
class Kind:
    """A row: runs of a scene on cells of 5 mm."""

    settings: list[str]
    members: int = 8
    scene: str = SCENE


def rows(runner: Runner, kinds: dict[str, Kind], title: str) -> None:
    runner.report(HEAD, [row_of(name, over_places(runner, name, kind.scene, kind.settings, kind.members, 5e-3))
                         for name, kind in kinds.items()], title)


def remark(runner: Runner) -> None:
    runner.remark("mean ± standard error of runs whose wall stands at places spread evenly over a cell, from a "
                  "straight line fitted over the places; explicit steps of 0.1 ms per millimetre of cell size unless "
                  "said otherwise; energy balance: error of the soil at the end, over the work of gravity; "
                  "iterations: mean of the steps in contact; cuts: sum over the runs; residual displacement and force "
                  f"at rest: mean of the last {REST} s; CPU time: both solvers, of a run")


def contact(runner: Runner) -> None:
    """The answer of granular_obstacle over basis functions, cells and time steps."""
    forms(runner, "5", {"fbar": 8, "noise": 8})
    rows(runner, {"tri3, 3 points a triangle": Kind([*explicit(STEPS["5"]), *triangles("grid", [40, 20], 3)]),
                  "quad4, linear, cells of 3.3 mm": Kind([*explicit(3.333e-4), *squares_of_triangles()])},
         "cells comparable with triangles with edges of 5 mm")
    steps = {f"explicit, {1e3 * dt:g} ms": Kind(explicit(dt)) for dt in TIME_STEPS}
    steps["implicit, by their error, as shipped"] = Kind([])
    steps["granular_obstacle_explicit, as shipped"] = Kind([], scene=f"{SCENE}_explicit")
    rows(runner, steps, "time steps, gimp, F-bar, h = 5 mm")
    remark(runner)


def contact_kinds(runner: Runner) -> None:
    """The answer of granular_obstacle over contact method and remedy for locking."""
    forms(runner, "5", {"none": 6})
    kinds = {f"penalty_factor {c}": Kind([*explicit(STEPS["5"]), f"{INTERFACE}/penalty_factor={c}"], 6)
             for c in (5, 50)}
    kinds["penalty_factor 2000, implicit"] = Kind([f"{INTERFACE}/penalty_factor=2000"], 4)
    kinds["boundary_points, implicit"] = Kind([f"{INTERFACE}/method=boundary_points"], 4)
    kinds["scene of the literature, implicit"] = Kind([], 4, PAPER)
    rows(runner, kinds, "contact, h = 5 mm; else as shipped")
    remark(runner)


def contact_fine(runner: Runner) -> None:
    """The answer of granular_obstacle_fine over basis functions and cells."""
    forms(runner, "2.5", {"fbar": 6})
    remark(runner)


def contact_sizes(runner: Runner) -> None:
    """The answer of granular_obstacle over the size of the cells."""
    for name in ("quad4, gimp", "quad4, linear"):
        of_size = {size: form(runner, name, size, "fbar", members) for size, members in SIZES.items()}
        runner.report(HEAD, [row_of(f"h = {size} mm", runs) for size, runs in of_size.items()], name)
        report_orders(runner, of_size, f"{name}: differences and order")
    remark(runner)


def report_orders(runner: Runner, of_size: dict[str, list[Measured]], title: str) -> None:
    """Differences of the means from size to size, and the order that they show."""
    rows = []
    for name, values in zip(ANSWER, answers_of(of_size)):
        coarse, fine = [difference(*pair) for pair in zip(values[:-1], values[1:])]
        ratio = coarse[0] / fine[0]
        clear = all(abs(value) > 2 * uncertainty for value, uncertainty in (coarse, fine))
        rows.append([name, *(f"{value:.3g} ± {uncertainty:.2g}" for value, uncertainty in (coarse, fine)),
                     float(np.log2(ratio)) if clear and ratio > 0 else "none"])
    sizes = list(of_size)
    head = ["", *(f"{a} to {b} mm" for a, b in zip(sizes[:-1], sizes[1:])), "order"]
    runner.report(head, rows, title)


def difference(before, after) -> tuple[float, float]:
    """Difference of the means, and its standard error."""
    return float(np.mean(after) - np.mean(before)), float(np.hypot(error(before), error(after)))


STUDIES = {study.__name__: study for study in (contact, contact_fine, contact_kinds, contact_sizes)}
