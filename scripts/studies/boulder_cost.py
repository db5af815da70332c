# SPDX-License-Identifier: BSD-3-Clause
"""What a step costs by the number of boulders, in a heap on a floor and on soil."""

import statistics
from dataclasses import dataclass

import numpy as np

from plotting.results import Results
from studies.instructions import SOLVER, has_run, solve
from studies.runner import Runner, folder_of

H, RADIUS, NEAR = 0.25, 0.5, 1e-6  # [m] of a cell, of a boulder, between neighbours
DENSITY, SPEED, DT = 2650, 0.2, 1e-3  # [kg/m³]; downwards [m/s]; [s]
COUNTS = {10: (5, 1), 100: (10, 5), 1000: (25, 20)}  # number -> columns, rows of each of two layers
HEAP, SOIL = "heap on a floor", "heap on soil"
STEPS = (2, 22)  # of a shorter and a longer run: their difference has no start in it
REPEATS = {10: 3, 100: 1, 1000: 1}  # the median counts
HEAD = ["boulders", "number", "points", "start and frames [s]", "a step [ms]", "the same soil alone [ms]",
        "a step and boulder [ms]", "of it by that of 10", "contact search [%]", "memory [MB]"]


@dataclass(frozen=True)
class Cost:
    """start, step: CPU time [s]; memory: at most [bytes]; search: share of the steps' time."""

    points: int
    start: float
    step: float
    memory: int
    search: float


def places(columns: int, rows: int, where: str) -> np.ndarray:
    """Centres [n, 3]: a layer, and one more in its troughs."""
    width = 2 * RADIUS + NEAR
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    lower = np.column_stack([width * (i.ravel() + 0.5), width * (j.ravel() + 0.5), np.zeros(i.size)])
    lower[:, 2] = (2 * H if where == SOIL else 0) + NEAR + RADIUS
    return np.concatenate([lower, lower + [0.5 * width, 0, np.sqrt(0.75) * width]])


def scene(number: int, where: str, steps: int, with_boulders: bool = True) -> dict:
    """Boulders that move down; on soil a bed of two cells, else a small heap of soil out of their way."""
    columns, rows = COUNTS[number]
    centres = places(columns, rows, where)
    low, high = np.array([-3.0, -1.0, -H]), centres.max(axis=0) + RADIUS
    cells = np.ceil((high + 1 - low) / H).astype(int)
    bed = [[-2, 0, 0], [-2 + 2 * H, 2 * H, 2 * H]]
    if where == SOIL:
        bed = [[-0.5, -0.5, 0], [*(H * np.ceil((high[:2] + 0.5) / H)).tolist(), 2 * H]]
    size = [round((b - a) / H) for a, b in zip(*bed)]
    far = (low + H * cells).tolist()

    def box(corners: list, counts: list) -> dict:
        return {"box": {"low": corners[0], "high": corners[1], "cells": counts, "type": "hex8"}}

    rock = {"shape": {"radius": RADIUS}, "density": DENSITY, "velocity": [0, 0, -SPEED], "friction": 0.5,
            "soil_friction": 0.5}
    settings = {
        "dimension": 3, "grid": box([low.tolist(), far], cells.tolist()), "gravity": [0, 0, -9.81],
        "time_integration": {"scheme": "explicit"},
        "bodies": [{"name": "soil", "mesh": box(bed, size), "points_per_cell": 8,
                    "material": {"law": "mohr_coulomb", "density": 1800, "young_modulus": 5e6, "poisson_ratio": 0.3,
                                 "friction_angle": 33}}],
        "rigid_walls": [{"name": "floor", "friction": 0.5,
                         "surface": {"mesh": box([low.tolist(), [*far[:2], 0]], [1, 1, 1]), "groups": ["top"]}}],
        "time": {"end": steps * DT, "dt": DT, "dt_min": DT / 1024}, "output": {"interval": 100},
    }
    if with_boulders:
        settings["boulders"] = [{"name": f"rock_{k}", "centre": centre, **rock}
                                for k, centre in enumerate(centres.tolist())]
    return settings


def cost(runner: Runner, number: int, where: str, with_boulders: bool = True) -> Cost:
    """Cost of a step: the longer run minus the shorter one, the median of several pairs."""
    steps = []
    for k in range(REPEATS[number]):
        summaries = []
        for count in STEPS:
            name = f"{folder_of(where)}_{number}{'' if with_boulders else '_alone'}_{count}_{k}"
            summaries.append(run(runner, name, scene(number, where, count, with_boulders)))
        short, long = summaries
        steps.append((long["cpu_seconds"] - short["cpu_seconds"]) / (STEPS[1] - STEPS[0]))
    time, solver = long["wall_seconds"], long["solver"]
    step = statistics.median(steps)
    return Cost(solver["points"], short["cpu_seconds"] - STEPS[0] * step, step, solver["peak_memory"]["largest_rank"],
                solver["wall_seconds"]["contact search"] / (time["solve"] + time["accept"]))


def run(runner: Runner, name: str, settings: dict) -> dict:
    """Summary."""
    folder = runner.folder / name
    if not (runner.reuse and has_run(folder, settings)):
        print(f"{folder.name}: running", flush=True)
        solve(folder, settings, [SOLVER])
    return Results(folder / "out").summary


def boulder_cost(runner: Runner) -> None:
    """What a step costs with 10, 100 and 1,000 boulders in a heap, on a floor and on soil."""
    rows = []
    for where in (HEAP, SOIL):
        found = {number: cost(runner, number, where) for number in COUNTS}
        alone = {number: cost(runner, number, where, with_boulders=False) for number in COUNTS}
        each = {number: (found[number].step - alone[number].step) / number for number in COUNTS}
        rows += [[where, number, of.points, of.start, 1e3 * of.step, 1e3 * alone[number].step, 1e3 * each[number],
                  each[number] / each[10], 100 * of.search, 1e-6 * of.memory]
                 for number, of in found.items()]
    runner.report(HEAD, rows)
    runner.remark(f"processor time of one rank, mean of steps {STEPS[0] + 1} to {STEPS[1]}: explicit ones of "
                  f"{1e3 * DT:g} ms; spheres of 1,280 facets in two layers that move down with {SPEED} m/s, "
                  f"{2 * RADIUS / H:.1f} cells across; contact search: share of the soil's search for facets")


STUDIES = {boulder_cost.__name__: boulder_cost}
