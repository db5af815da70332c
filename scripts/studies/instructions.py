# SPDX-License-Identifier: BSD-3-Clause
"""What a step of the soil costs in instructions, which no load of the machine changes."""

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

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


LAW_HEAD = ["law", *(f"{state}: {what}" for state in ("elastic", "yielding")
                     for what in ("stress and K", "over Mohr-Coulomb", "all"))]
HOOKE = {"density": 2650, "young_modulus": 840e3, "poisson_ratio": 0.3}
SOFT = {"slip": 0.01}


def in_both_states(law: str, constants: dict, elastic: dict, yielding: dict) -> tuple[dict, dict]:
    """Material of a law that stays elastic, and one that yields."""
    return tuple({"law": law, **HOOKE, **constants, **own} for own in (elastic, yielding))


SAND = {"friction_angle": 30, "dilation_angle": 5}
STRONG, WEAK = {"cohesion": 2e4}, {"cohesion": 50}
# Material that stays elastic, material that yields, by law.
FORMS_OF_LAWS: dict[str, tuple[dict | None, dict | None]] = {
    "Mohr-Coulomb": in_both_states("mohr_coulomb", SAND, STRONG, WEAK),
    "Mohr-Coulomb with a tension cut-off": in_both_states(
        "mohr_coulomb", SAND, STRONG | {"tension_cutoff": 1e4}, WEAK | {"tension_cutoff": 20}),
    "Mohr-Coulomb that softens": in_both_states(
        "mohr_coulomb", SAND, STRONG | {"softening": SOFT | {"residual_cohesion": 1e4}},
        WEAK | {"softening": SOFT | {"residual_cohesion": 25, "residual_friction_angle": 25}}),
    "Drucker-Prager": in_both_states("drucker_prager", SAND, STRONG, WEAK),
    "Tresca": in_both_states("tresca", {}, STRONG, WEAK),
    "Tresca that softens": in_both_states(
        "tresca", {}, STRONG | {"softening": SOFT | {"residual_cohesion": 1e4}},
        WEAK | {"softening": SOFT | {"residual_cohesion": 25}}),
    "Bingham": in_both_states("herschel_bulkley", {"consistency": 15}, {"yield_stress": 2e4}, {"yield_stress": 20}),
    "Herschel-Bulkley, flow index 0.5": in_both_states(
        "herschel_bulkley", {"consistency": 15, "flow_index": 0.5}, {"yield_stress": 2e4}, {"yield_stress": 20}),
    "mu(I)": in_both_states(
        "mu_i", {"inertial_number": 0.279, "grain_size": 5e-4, "grain_density": 2650},
        {"static_friction": 50, "limit_friction": 60}, {"static_friction": 0.2, "limit_friction": 0.3}),
    "Cam-Clay": 2 * ({"law": "cam_clay", "density": 2650, "poisson_ratio": 0.3, "compression_index": 0.1,
                      "swelling_index": 0.02, "critical_state_ratio": 1, "reference_pressure": 1e4},),
    "Newtonian fluid": (None, {"law": "newtonian", "density": 2650, "sound_speed": 20, "viscosity": 5}),
    "Hencky's elasticity": ({"law": "hencky_elastic", **HOOKE}, None),
}


OCR = {"elastic": 20, "yielding": 1}  # over-consolidation ratio, which Cam-Clay alone knows


def pressed_block(material: dict, ocr: float) -> dict:
    """A block of 5,000 points between smooth walls, under a small weight, that one of them presses by 0.1 % a step.

    Its initial stress is isotropic.
    """
    unloaded = 0.3 / 0.7  # horizontal over vertical stress of elastic unloading
    mesh = {"box": {"low": [0, 0], "high": [0.5, 0.25], "cells": [50, 25], "type": "quad4"}}
    grid = {"box": {"low": [0, 0], "high": [0.5, 0.27], "cells": [50, 27], "type": "quad4"}}
    walls = [{"group": wall, "condition": "slip"} for wall in ("left", "bottom", "right")]
    walls[-1]["motion"] = {"velocity": [-5e-4, 0]}
    soil = {"name": "soil", "mesh": mesh, "points_per_cell": 4, "material": material,
            "initial_stress": {"k0": (1 + (ocr - 1) * unloaded) / ocr, "ocr": ocr, "surface": 0.25}}
    return {
        "dimension": 2, "grid": grid, "basis": "linear", "locking": {"method": "fbar"}, "gravity": [0, -0.5],
        "analysis": "quasi_static", "walls": walls, "bodies": [soil],
        "time": {"end": 1, "dt": 1, "dt_min": 1 / 64}, "output": {"interval": 1},
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


def count(folder: Path, settings: dict, steps: int) -> Count:
    """Run that many steps under callgrind."""
    settings = settings | {"time": settings["time"] | {"end": steps * settings["time"]["dt"]}}
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


def law_rows(folder: Path) -> list[list]:
    """Rows of a block that stays elastic and of one that yields, a row a law."""
    rows, first = [], {}
    for name, forms in FORMS_OF_LAWS.items():
        row = [name]
        for state, material in zip(("elastic", "yielding"), forms):
            if material is None:
                row += ["", "", ""]
                continue
            print(f"{name}, {state}: running", flush=True)
            at = folder / folder_of(f"{name}_{state}")
            few, many = (count(at, pressed_block(material, OCR[state]), steps) for steps in (1, 4))
            if material["law"] != "newtonian":
                check_state(at, state, name)
            newton = (many.newton - few.newton) * many.points
            stress = (many.stress - few.stress) / newton
            row += [stress, stress / first.setdefault(state, stress), (many.total - few.total) / newton]
        rows.append(row)
    return rows


def check_state(folder: Path, state: str, name: str) -> None:
    """@raises ResultsError  points of an elastic block yielded, or points of a yielding one did not"""
    share = float(np.mean(Results(folder / "out").frames_of_soil().frame(-1).fields["plastic_strain"] > 0))
    if share != (0 if state == "elastic" else 1):
        raise ResultsError(f"{name}, {state}: {100 * share:.0f} % of the points yielded")


def instructions(runner: Runner) -> None:
    """Instructions of a step of the soil by basis, F-bar and cells, in the plane and in space; needs valgrind."""
    if shutil.which("valgrind") is None:
        raise ResultsError("found no valgrind; it needs: apt-get install --no-install-recommends valgrind")
    rows = []
    for name, form in FORMS.items():
        print(f"{name}: running", flush=True)
        folder = runner.folder / folder_of(name)
        few, many = (1, 3) if name.startswith("hex8") else (2, 10)
        rows.append(row(name, many - few, count(folder, scene(*form), few),
                        count(folder, scene(*form), many)))
    runner.report(HEAD, rows)
    runner.report(LAW_HEAD, law_rows(runner.folder), "by law")


STUDIES = {"instructions": instructions}
