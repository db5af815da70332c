# SPDX-License-Identifier: BSD-3-Clause
"""How much of the answer of granular_obstacle is the method's: contact, functions of the grid, its cells and sizes."""

import json

import numpy as np

from studies.coupled import REST, SCENE
from studies.measures import Measured
from studies.runner import Runner, folder_of

PAPER = f"{SCENE}_paper"
INTERFACE = "mpm.json:/interfaces/0"


def triangles(fine: bool) -> list[str]:
    """Unstructured grid of triangles, three points in each triangle of the body."""
    box = {"low": [0, 0], "high": [0.2, 0.1], "cells": [80, 40] if fine else [40, 20], "type": "tri3"}
    name = "fine" if fine else "grid"
    grid = {"file": f"../{PAPER}/{name}.msh"}
    return [f"mpm.json:/grid={json.dumps(grid)}", f"mpm.json:/bodies/0/mesh={json.dumps({'box': box})}",
            "mpm.json:/bodies/0/points_per_cell=3"]


def row_of(name: str, run: Measured) -> list:
    steps = run.table("steps.csv")
    iterations = steps["iterations"][steps["skipped"] == "none"]
    return [name, 1e3 * run.peak()[0], 1e3 * run.displacement().mean_of_last(REST), float(np.max(steps["fx"])),
            run.force().mean_of_last(REST), float(run.impulse().values[-1]), float(np.mean(iterations)),
            int(np.max(iterations)), run.cuts(), run.seconds()]


HEAD = ["", "peak of A [mm]", "rest [mm]", "peak force [N/m]", "rest [N/m]", "impulse [N s/m]", "iterations", "most",
        "cuts", "run time [s]"]


def forms(runner: Runner, size: str) -> None:
    """Functions of the grid and its cells, with and without F-bar; size: "5" or "2.5" [mm]."""
    fine = size == "2.5"
    settings = {
        "quad4, gimp": [],
        "quad4, bspline": ["mpm.json:/basis=bspline"],
        "quad4, linear": ["mpm.json:/basis=linear"],
        "tri3": triangles(fine),
    }
    scene = f"{SCENE}_fine" if fine else SCENE
    rows = []
    for locking in ("fbar", "none"):
        for name, changes in settings.items():
            run = runner.run(folder_of(f"{name} {size} {locking}"), scene,
                             [*changes, f"mpm.json:/locking/method={locking}"])
            rows.append(row_of(f"{name}, {'F-bar' if locking == 'fbar' else 'no cure'}", run))
    runner.report(HEAD, rows, f"h = {size} mm")


def contact(runner: Runner) -> None:
    """The answer of granular_obstacle over contact, cure of locking, functions of the grid and its cells."""
    forms(runner, "5")
    kinds = {
        "penalty_factor 5": (SCENE, [f"{INTERFACE}/penalty_factor=5"]),
        "penalty_factor 50": (SCENE, [f"{INTERFACE}/penalty_factor=50"]),
        "penalty_factor 2000": (SCENE, [f"{INTERFACE}/penalty_factor=2000"]),
        "boundary_points": (SCENE, [f"{INTERFACE}/method=boundary_points"]),
        "scene of the literature": (PAPER, []),
    }
    steps = {f"gimp, dt at most {1e3 * dt:g} ms": (SCENE, [f"coupler.json:/time/dt={dt}"]) for dt in (2e-4, 5e-5)}
    for title, runs in (("contact, h = 5 mm; else as shipped", kinds), ("largest step, F-bar, h = 5 mm; 1 ms as shipped", steps)):
        rows = [row_of(name, runner.run(folder_of(name), scene, settings))
                for name, (scene, settings) in runs.items()]
        runner.report(HEAD, rows, title)
    runner.remark(f"iterations: mean of the steps in contact; rest: mean of the last {REST} s")


def contact_fine(runner: Runner) -> None:
    """The answer of granular_obstacle_fine over functions of the grid and its cells."""
    forms(runner, "2.5")
    runner.remark(f"iterations: mean of the steps in contact; rest: mean of the last {REST} s")


STUDIES = {"contact": contact, "contact_fine": contact_fine}
