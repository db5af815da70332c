# SPDX-License-Identifier: BSD-3-Clause
"""What a step of the soil costs in instructions, which no load of the machine changes."""

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from plotting.results import Results, ResultsError, object_of
from studies.runner import ROOT, Runner, folder_of

SOLVER = ROOT / "build" / "release" / "bin" / "mpm_solver"
MATERIAL = ROOT / "configs" / "column_collapse" / "mpm.json"
# Environment that makes glibc use copies without the instructions that callgrind counts once for each byte.
COPIES = "glibc.cpu.x86_rep_stosb_threshold=1000000000:glibc.cpu.x86_rep_movsb_threshold=1000000000"
CALLS = ("solve_step", "accept_step")  # what a step is
HEAD = ["soil", "points", "Newton a step", "Krylov a Newton", "a step [M]", "an iteration [M]", "of it stress and K",
        "linear solve", "a point and iteration"]


@dataclass
class Count:
    """Counts of one run, from its first step to its last."""

    points: int
    newton: int
    krylov: int
    total: int
    stress: int
    solve: int


def scene(basis: str, remedy: str, cell: str) -> dict:
    """A column of sand that begins to collapse: 5,000 points in the plane, 8,000 in space."""
    box, grid, walls, points = [[0.2, 0.1], [50, 25]], [[0.4, 0.12], [100, 30]], ["left", "bottom", "right"], 4
    if cell == "tri3":
        points = 3
    gravity, dt = [0, -9.81], 2e-4
    if cell == "hex8":
        box, grid = [[0.1, 0.1, 0.1], [10, 10, 10]], [[0.2, 0.1, 0.12], [20, 10, 12]]
        walls, points, gravity, dt = [*walls, "front", "back"], 8, [0, 0, -9.81], 5e-4

    def mesh(size: list[float], cells: list[int]) -> dict:
        return {"box": {"low": [0] * len(size), "high": size, "cells": cells, "type": cell}}

    material = json.loads(MATERIAL.read_text(encoding="utf-8"))["bodies"][0]["material"]
    return {
        "dimension": len(gravity), "grid": mesh(*grid), "basis": basis, "locking": {"method": remedy},
        "gravity": gravity,
        "walls": [{"group": wall, "condition": "slip" if wall in ("front", "back") else "fixed"} for wall in walls],
        "bodies": [{"name": "soil", "mesh": mesh(*box), "points_per_cell": points, "material": material}],
        "time": {"end": 1, "dt": dt, "dt_min": dt / 64}, "output": {"interval": 1},
    }


FORMS = {
    "quad4, linear": ("linear", "none", "quad4"),
    "quad4, linear, F-bar": ("linear", "fbar", "quad4"),
    "tri3": ("linear", "none", "tri3"),
    "quad4, gimp": ("gimp", "none", "quad4"),
    "quad4, gimp, F-bar": ("gimp", "fbar", "quad4"),
    "hex8, linear": ("linear", "none", "hex8"),
    "hex8, gimp, F-bar": ("gimp", "fbar", "hex8"),
}


def inclusive(listing: str, function: str) -> int:
    """Instructions of a function and what it calls; the largest of its instances."""
    found = re.findall(rf"^\s*([\d,]+) \([^)]*\)\s+\S*{function}", listing, re.MULTILINE)
    return max((int(number.replace(",", "")) for number in found), default=0)


def solve(folder: Path, settings: dict, command: list, environment: dict[str, str] | None = None,
          file: str = "mpm.json") -> str:
    """Run a solver alone with its results in folder/out; returns what it says on its error output.

    command: the solver, with what stands before it and options of its own; file: that of its settings.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / file).write_text(json.dumps(settings), encoding="utf-8")
    done = subprocess.run([*command, folder, "--output", folder / "out"], env=os.environ | (environment or {}),
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ResultsError(f"{folder.name}: exit code {done.returncode}\n{done.stderr[-600:]}")
    return done.stderr


def has_run(folder: Path, settings: dict, file: str = "mpm.json") -> bool:
    """Whether `solve` has run these settings here to their end."""
    if not (folder / "out").is_dir() or object_of(folder / file) != json.loads(json.dumps(settings)):
        return False
    return Results(folder / "out").completed


def count(folder: Path, form: tuple[str, str, str], steps: int) -> Count:
    """Run that many steps under callgrind."""
    settings = scene(*form)
    settings["time"]["end"] = steps * settings["time"]["dt"]
    counts = folder / "callgrind.out"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}",
               *(f"--toggle-collect=gabion::mpm::MpmSolver<{len(settings['gravity'])}>::{call}*" for call in CALLS),
               SOLVER]
    environment = {"GLIBC_TUNABLES": COPIES, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    said = solve(folder, settings, command, environment)
    total = re.search(r"Collected : (\d+)", said)
    if not total:
        raise ResultsError(f"{folder.name}: no count of callgrind\n{said[-600:]}")
    listing = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", counts], check=True,
                             capture_output=True, text=True).stdout
    summary = Results(folder / "out").summary["solver"]
    return Count(summary["points"], summary["newton"]["iterations"], summary["linear_iterations"], int(total.group(1)),
                 inclusive(listing, r"gabion::mpm::InternalForces<\d>::evaluate"),
                 inclusive(listing, r"gabion::LinearSolver<\d>::solve"))


def row(name: str, steps: int, few: Count, many: Count) -> list:
    """Row from the additional steps of the longer run, which have no start in them."""
    newton = many.newton - few.newton
    total = many.total - few.total
    return [name, many.points, newton / steps, (many.krylov - few.krylov) / newton, total / steps / 1e6,
            total / newton / 1e6, f"{100 * (many.stress - few.stress) / total:.0f} %",
            f"{100 * (many.solve - few.solve) / total:.0f} %", total / newton / many.points]


def instructions(runner: Runner) -> None:
    """Instructions of a step of the soil by basis, F-bar and cells, in the plane and in space; needs valgrind."""
    if shutil.which("valgrind") is None:
        raise ResultsError("found no valgrind; it needs: apt-get install --no-install-recommends valgrind")
    rows = []
    for name, form in FORMS.items():
        print(f"{name}: running", flush=True)
        folder = runner.folder / folder_of(name)
        few, many = (1, 3) if name.startswith("hex8") else (2, 10)
        rows.append(row(name, many - few, count(folder, form, few), count(folder, form, many)))
    runner.report(HEAD, rows)


STUDIES = {"instructions": instructions}
