# SPDX-License-Identifier: BSD-3-Clause
"""What the coupled scenes of this repository give, with fem_solver as their structure."""

import numpy as np

from plotting.history import displacement_columns, probe_points
from studies.columns import setting
from studies.measures import Curve, Measured
from studies.runner import Runner, folder_of

LAST = 0.2  # share of a run that its end is the mean of
LINEAR = [setting("basis", "linear")]


def step_size(dt: float) -> list[str]:
    return [f"coupler.json:/time/dt={dt:g}"]


def on_boxes(low: list[float], high: list[float], of_body: tuple[list[float], list[float]], h: float) -> list[str]:
    """Grid and body of cells of h [m]. @param of_body  low and high"""
    def cells(low: list[float], high: list[float]) -> dict:
        counts = [round((b - a) / h) for a, b in zip(low, high)]
        return {"box": {"low": low, "high": high, "cells": counts, "type": "quad4"}}
    return [setting("grid", cells(low, high)), setting("bodies/0/mesh", cells(*of_body))]


# Scene -> variants: what is changed -> settings.
SCENES = {
    "granular_obstacle": {"": []},
    "granular_obstacle_fine": {"": []},
    "granular_obstacle_explicit": {"": []},
    "granular_obstacle_paper": {"": []},
    "flexible_gate": {
        "": [],
        "dt 0.5 ms": step_size(5e-4),
        "cells of 20 mm": on_boxes([0, 0], [0.8, 0.24], ([0, 0], [0.2, 0.2]), 0.02),
        "linear": LINEAR,
    },
    "slope_barrier": {
        "": [],
        "dt 1.25 ms": step_size(1.25e-3),
        "cells of 0.25 m": on_boxes([-1, -0.25], [27, 6], ([0, 0], [10, 2.5]), 0.25),
        "linear": LINEAR,
    },
    "two_posts": {"": []},
    "slide_on_terrain": {
        "": [],
        "implicit": [setting("time_integration", {"scheme": "bossak"})],
    },
}
HEAD = ["scene", "point", "displacement: largest [mm]", "at [s]", "end [mm]", "force: largest [kN]", "at [s]",
        "end [kN]", "impulse [kN s]", "iterations", "most", "cuts", "steps", "CPU time [s]"]


def scenes(runner: Runner) -> None:
    """The coupled scenes as shipped, and with a setting changed: structure, force, coupling, cost."""
    rows = []
    for scene, variants in SCENES.items():
        for change, settings in variants.items():
            name = f"{scene}, {change}" if change else scene
            rows += rows_of(name, runner.run(folder_of(name), scene, settings))
    runner.report(HEAD, rows)
    runner.remark(f"displacement and force along x; force of all interfaces, in the plane per metre; end: mean of the "
                  f"last {LAST:g} of the run; iterations: mean of the steps in contact; CPU time: all solvers, "
                  "of a run")


def rows_of(name: str, run: Measured) -> list[list]:
    """One row a point of a structure; what belongs to the run stands in the first."""
    table = run.table("probes.csv")
    points = [point for point in probe_points(table) if not point.startswith("soil.")]
    force, iterations = run.force(), run.iterations_in_contact()
    of_run = [*extremes(force, 1e-3), float(run.impulse().values[-1]) / 1e3, float(iterations.mean()),
              int(iterations.max()), run.cuts(), run.table("steps.csv").num_rows, run.solver_seconds()]
    rows = []
    for point in points:
        moved = Curve(table["time"], table[displacement_columns(table, point)[0]])
        rows.append([name, point, *extremes(moved, 1e3), *of_run])
        name, of_run = "", [""] * len(of_run)
    return rows


def extremes(curve: Curve, unit: float) -> list[float]:
    """Largest value, when, and mean of the end."""
    at = int(np.argmax(np.abs(curve.values)))
    return [unit * float(curve.values[at]), float(curve.time[at]),
            unit * curve.mean_of_last(LAST * float(curve.time[-1]))]


STUDIES = {scenes.__name__: scenes}
