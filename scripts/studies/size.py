# SPDX-License-Identifier: BSD-3-Clause
"""How time and memory of the soil grow with its points."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from plotting.results import Results, Table
from studies.instructions import FORMS, SOLVER, scene, solve
from studies.runner import Runner, folder_of

STEPS = 10
#: Runs: form, and the cells of instructions.scene along an edge times these.
SIZES = {
    "tri3": (1, 4, 12),
    "quad4, linear": (1, 4, 16),
    "quad4, gimp, F-bar": (1, 4, 16),
    "hex8, linear": (1, 2, 4, 5),
    "hex8, gimp, F-bar": (1, 2, 4, 5),
}
PHASES = {"points and nodes": ("search", "points to grid", "grid to points"), "stress and K": ("assembly",),
          "linear solve": ("solve",), "pattern": ("pattern",)}
#: Of the summary's "memory", and what is asked for [kB a point].
FIELDS = ("points", "weights", "trial", "nodes", "stiffness", "pattern", "preconditioner")
WANTED = {"tri3": 0.6, "quad4, linear": 0.6, "quad4, gimp, F-bar": 1.0, "hex8, linear": 2.5, "hex8, gimp, F-bar": 2.5}
HEAD = ["soil", "points", "Newton a step", "a step [s]", "a point and iteration [µs]", *PHASES, "other",
        "memory a point [kB]"]


def refined(form: tuple[str, str, str], times: int) -> dict:
    """The scene with cells smaller by that factor, and steps too: waves cross as many cells in a step."""
    settings = scene(*form)
    for mesh in (settings["grid"]["box"], settings["bodies"][0]["mesh"]["box"]):
        mesh["cells"] = [times * cells for cells in mesh["cells"]]
    time = settings["time"]
    time["dt"] /= times
    time["dt_min"] /= times
    time["end"] = STEPS * time["dt"]
    return settings


def read(out: Path) -> tuple[dict, Table]:
    """Summary and steps of a run."""
    results = Results(out)
    return results.summary, results.table("steps.csv")


def row(name: str, summary: dict, steps: Table, smallest: dict) -> list:
    """Row of a run. smallest: summary of that with the fewest points; memory counts from there."""
    soil, phases = summary["solver"], summary["solver"]["wall_seconds"]
    total = summary["wall_seconds"]["solve"] + summary["wall_seconds"]["accept"]
    shares = [sum(phases.get(phase, 0) for phase in group) / total for group in PHASES.values()]
    iterations = int(np.sum(steps["newton_iterations"]))
    each = float(np.median(steps["wall_seconds"] / steps["newton_iterations"]))
    points = soil["points"] - smallest["solver"]["points"]
    memory = soil["peak_memory"]["largest_rank"] - smallest["solver"]["peak_memory"]["largest_rank"]
    return [name, soil["points"], iterations / steps.num_rows, float(np.median(steps["wall_seconds"])),
            1e6 * each / soil["points"], *(f"{100 * share:.0f} %" for share in [*shares, 1 - sum(shares)]),
            memory / points / 1e3 if points else ""]


def memory_row(name: str, largest: dict, smallest: dict) -> list:
    """kB a point by field, in what the larger run has more."""
    points = largest["solver"]["points"] - smallest["solver"]["points"]

    def more(of: Callable[[dict], float]) -> float:
        return (of(largest["solver"]) - of(smallest["solver"])) / points / 1e3

    fields = [more(lambda soil, field=field: soil["memory"][field]) for field in FIELDS]
    peak = more(lambda soil: soil["peak_memory"]["largest_rank"])
    return [name, largest["solver"]["points"], *fields, peak - sum(fields), peak, WANTED[name]]


def size(runner: Runner) -> None:
    """Time and memory of a step of the soil over its points, in the plane and in space, and where they go."""
    rows, exponents, memory = [], [], []
    for name, sizes in SIZES.items():
        of_form = []
        smallest = None
        for times in sizes:
            print(f"{name}, cells / {times}: running", flush=True)
            folder = runner.folder / f"{folder_of(name)}_{times}"
            solve(folder, refined(FORMS[name], times), [SOLVER])
            summary, steps = read(folder / "out")
            smallest = smallest or summary
            of_form.append(row(name, summary, steps, smallest))
        ratio = of_form[-1][4] / of_form[0][4]
        exponents.append(f"{name} {1 + math.log(ratio) / math.log(of_form[-1][1] / of_form[0][1]):.2f}")
        rows += of_form
        memory.append(memory_row(name, summary, smallest))
    runner.report(HEAD, rows)
    runner.report(["soil", "points", *FIELDS, "other", "all", "goal"], memory, "memory a point [kB]")
    runner.remark(f"time of an iteration over points, exponent: {', '.join(exponents)}")


STUDIES = {"size": size}
