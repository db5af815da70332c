# SPDX-License-Identifier: BSD-3-Clause
"""A large structure on several MPI ranks: memory, time of a step, a frame, a checkpoint."""

from plotting.results import Results
from studies.instructions import has_run, solve
from studies.ranks import THREADS, mpirun
from studies.runner import Runner
from studies.solvers import CELL, MATERIAL, SOLVER

RANKS = (1, 2, 4)
EDGES = (60, 100)  # nodes
HEAD = ["nodes", "ranks", "iterations a system", "a step [s]", "time of one rank over this", "a frame [s]",
        "a checkpoint [s]", "memory of the largest rank [MB]", "over that of one rank"]


def scene(edge: int) -> dict:
    """One step of a block of concrete that is pushed from one side."""
    dt = 5e-5
    return {
        "dimension": 3, "material": MATERIAL, "linear_solver": {"method": "cg", "preconditioner": "jacobi"},
        "mesh": {"box": {"low": [0, 0, 0], "high": [CELL * (edge - 1)] * 3, "cells": [edge - 1] * 3, "type": "hex8"}},
        "analysis": "dynamic", "supports": [{"group": "bottom"}],
        "tractions": [{"group": "front", "traction": [0, 500, 0]}],
        "time": {"end": dt, "dt": dt, "dt_min": dt}, "output": {"interval": dt},
    }


def summary_of(runner: Runner, edge: int, ranks: int) -> dict:
    folder = runner.folder / f"{edge}_{ranks}"
    settings = scene(edge)
    if not (runner.reuse and has_run(folder, settings, "fem.json")):
        print(f"{folder.name}: running", flush=True)
        solve(folder, settings, [*mpirun(ranks), SOLVER, "--log-level", "warn"], THREADS, "fem.json")
    return Results(folder / "out").summary


def structure_ranks(runner: Runner) -> None:
    """A structure of 216,000 and of a million nodes on 1, 2 and 4 MPI ranks: memory, time, output."""
    rows = []
    for edge in EDGES:
        found = {ranks: summary_of(runner, edge, ranks) for ranks in RANKS}
        one = found[1]
        for ranks, summary in found.items():
            solver, seconds = summary["solver"], summary["wall_seconds"]
            memory = solver["peak_memory"]["largest_rank"]
            rows.append([solver["nodes"], ranks, summary["linear_iterations"] / solver["newton_iterations"],
                         seconds["solve"], one["wall_seconds"]["solve"] / seconds["solve"],
                         seconds["output"] / 2, seconds["checkpoint"], round(memory / 1e6),
                         memory / one["solver"]["peak_memory"]["largest_rank"]])
    runner.report(HEAD, rows)


STUDIES = {"structure_ranks": structure_ranks}
