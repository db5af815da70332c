# SPDX-License-Identifier: BSD-3-Clause
"""What the linear systems of a structure in space cost by method, shape and size."""

import json
import math
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from plotting.results import Results, ResultsError
from studies.instructions import has_run
from studies.runner import ROOT, Runner

SOLVER = ROOT / "build" / "release" / "bin" / "fem_solver"
CELL = 0.1  # [m]
WAVE_SPEED = 3727.0  # of P waves in MATERIAL [m/s]
MATERIAL = {"law": "neo_hookean", "density": 2400, "young_modulus": 30e9, "poisson_ratio": 0.2}
METHODS = {
    "mumps": {"method": "mumps"},
    "cg + ilu": {"method": "cg", "preconditioner": "ilu"},
    "cg + multigrid": {"method": "cg", "preconditioner": "multigrid"},
    "auto": {},
}
SHAPES = {  # cells along the axes by size
    "wall, 2 cells thick": [(n, 2, n) for n in (17, 36, 72, 102)],
    "wall, 4 cells thick": [(110, 4, 110)],
    "block": [(n, n, n) for n in (9, 15, 24, 31, 45)],
}
REGIMES = {"static": 1, "dynamic, c dt/h = 16": 10}  # steps
HEAD = ["shape", "unknowns", "analysis", "method", "linear systems", "set-ups", "iterations a system", "solution [s]",
        "memory [MB]"]


@dataclass
class Run:
    """Cost of a run of the structure."""

    results: Results
    megabytes: float  #: largest resident memory of the program


def scene(cells: tuple[int, int, int], regime: str, linear: dict) -> dict:
    """A cantilever of concrete that is pushed from one side."""
    steps = REGIMES[regime]
    dt = 1 if regime == "static" else 16 * CELL / WAVE_SPEED
    return {
        "dimension": 3, "material": MATERIAL, "linear_solver": linear,
        "mesh": {"box": {"low": [0, 0, 0], "high": [CELL * n for n in cells], "cells": cells, "type": "hex8"}},
        "analysis": regime.split(",")[0], "supports": [{"group": "bottom"}],
        "tractions": [{"group": "front", "traction": [0, 500, 0]}],
        "time": {"end": steps * dt, "dt": dt, "dt_min": dt}, "output": {"interval": steps * dt},
    }


def run(folder: Path, settings: dict, reuse: bool) -> Run:
    """@raises ResultsError  the run failed"""
    memory = folder / "memory.json"
    if reuse and memory.exists() and has_run(folder, settings, "fem.json"):
        return Run(Results(folder / "out"), json.loads(memory.read_text(encoding="utf-8")))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "fem.json").write_text(json.dumps(settings), encoding="utf-8")
    command = [str(SOLVER), str(folder), "--output", str(folder / "out"), "--log-level", "warn"]
    with (folder / "log").open("w", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT,
                                   env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise ResultsError(f"{folder.name}: exit code {process.returncode}\n"
                           f"{(folder / 'log').read_text(encoding='utf-8')}")
    megabytes = usage.ru_maxrss / 1024
    memory.write_text(json.dumps(megabytes), encoding="utf-8")
    return Run(Results(folder / "out"), megabytes)


def tried(method: str, cells: tuple[int, int, int], regime: str) -> bool:
    """Whether a method is tried: not factors that take minutes, nor iterations that are known to end in a
    factor."""
    large = min(cells) > 2 and max(cells) > 24
    if math.prod(cells) > 40_000:
        return method != "mumps" and regime == "static"
    stalls = min(cells) == 2 and max(cells) > 72 and regime == "static"
    return not (method == "mumps" and large) and not (method == "cg + ilu" and stalls)


def row(shape: str, regime: str, method: str, found: Run) -> list:
    summary = found.results.summary
    solver = summary["solver"]
    name = method if method != "auto" else f"auto: {solver['linear_solver']}"
    systems = solver["newton_iterations"]
    return [shape, 3 * solver["nodes"], regime, name, systems, solver["factorisations"],
            summary["linear_iterations"] / systems, solver["wall_seconds"]["solve"], round(found.megabytes)]


def solvers(runner: Runner) -> None:
    """Linear systems of a structure in space: a factor, ILU(0) and multigrid by shape, size and step."""
    rows = []
    for shape, sizes in SHAPES.items():
        for cells in sizes:
            for regime in REGIMES:
                for method, linear in METHODS.items():
                    if not tried(method, cells, regime):
                        continue
                    label = "_".join([shape.split(",")[0], str(cells[0]), regime.split(",")[0],
                                      method.replace(" + ", "_")])
                    print(f"{label}: running", flush=True)
                    found = run(runner.folder / label, scene(cells, regime, linear), runner.reuse)
                    rows.append(row(shape, regime, method, found))
    runner.report(HEAD, rows)


STUDIES = {"solvers": solvers}
