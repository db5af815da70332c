# SPDX-License-Identifier: BSD-3-Clause
"""What a step costs with each code that can be the structure of the obstacle scene."""

import importlib.util
import os
import shutil
from dataclasses import dataclass

import numpy as np

from plotting.results import ResultsError
from studies.measures import Measured
from studies.runner import ROOT, Runner, folder_of

# Some 60 steps in contact: a part of the column stands before the wall and moves towards it.
SHORT = ["mpm.json:/bodies/0/mesh/box/low=[0.1975,0]", "mpm.json:/bodies/0/mesh/box/high=[0.2475,0.06]",
         "mpm.json:/bodies/0/mesh/box/cells=[10,12]", "mpm.json:/bodies/0/velocity=[0.5,0]",
         "coupler.json:/time/end=0.0061", "coupler.json:/output/interval=1"]


@dataclass(frozen=True)
class Code:
    scene: str  # a folder of configs/
    needs: str = ""  # a program in PATH, a file of this tree, or a module of Python
    python: str = ""  # environment variable that may name the python of that module

    def is_here(self) -> bool:
        return not self.needs or shutil.which(self.needs) is not None or (ROOT / self.needs).is_file() or \
            self.python in os.environ or "/" not in self.needs and importlib.util.find_spec(self.needs) is not None


# Another code is a line here.
CODES = {
    "fem_solver, 4 x 40 quad4": Code("granular_obstacle"),
    "matrices of the same": Code("granular_obstacle_matrices"),
    "CalculiX, 2 x 20 CPE8": Code("granular_obstacle_calculix", "ccx"),
    "deal.II, 2 x 20 of degree 2 and refined": Code("granular_obstacle_dealii",
                                                    "build/dealii/program/dealii_structure"),
    "dolfinx, 4 x 40 of degree 1": Code("granular_obstacle_dolfinx", "dolfinx"),
    "OpenSees, 40 beams": Code("granular_obstacle_opensees", "openseespy", "GABION_OPENSEES_PYTHON"),
    "beam in Python": Code("granular_obstacle_external"),
}
HEAD = ["structure", "steps in contact", "iterations a step", "a step [ms]", "soil [ms]", "structure [ms]",
        "messages [ms]", "acceleration [ms]", "rest of the coupler [ms]", "a solution of the structure [ms]"]


def row(name: str, run: Measured) -> list:
    """Means over the steps in contact."""
    table = run.table("steps.csv")
    contact = table["skipped"] == "none"
    if not contact.any():
        raise ResultsError(f"{name}: no step in contact")
    parts = [table["soil.busy_seconds"], table["structure.busy_seconds"],
             table["soil.message_seconds"] + table["structure.message_seconds"], table["acceleration_seconds"]]
    step, *means = (1e3 * float(np.mean(seconds[contact])) for seconds in (table["wall_seconds"], *parts))
    iterations = float(np.mean(table["iterations"][contact]))
    return [name, int(contact.sum()), iterations, step, *means, step - sum(means), means[1] / iterations]


def codes(runner: Runner) -> None:
    """A step in contact of granular_obstacle, shortened, with each structural code: its time, messages, coupler."""
    rows, absent = [], []
    for name, code in CODES.items():
        if code.is_here():
            rows.append(row(name, runner.run(folder_of(code.scene), code.scene, SHORT)))
        else:
            absent.append(f"{name} ({code.needs})")
    runner.report(HEAD, rows)
    if absent:
        runner.remark(f"not here: {', '.join(absent)}")


STUDIES = {"codes": codes}
