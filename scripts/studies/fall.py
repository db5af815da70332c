# SPDX-License-Identifier: BSD-3-Clause
"""The fall of granular_obstacle before it hits anything: runs do not scatter yet, so the method shows."""

import numpy as np

from studies.contact import FINEST, STEPS, explicit, forms_of
from studies.coupled import SCENE
from studies.measures import Measured
from studies.runner import Runner, folder_of

END = 0.1  # [s]: the soil arrives later
TIMES = (0.05, END)  # [s]
QUADRATURES = {"gimp": ("points",), "bspline": ("points",), "linear": ("points", "cells"), "tri3": ("points", "cells")}
POINTS = {"quad4": (4, 16), "tri3": (3, 12)}  # of a cell


def run(runner: Runner, size: str, form: str, quadrature: str, points: int) -> Measured:
    scene = SCENE if size == "5" else f"{SCENE}_fine"
    settings = [*explicit(STEPS[size]), *forms_of(size == "2.5")[form], *(FINEST if size == "1.25" else []),
                f"mpm.json:/quadrature={quadrature}", f"mpm.json:/bodies/0/points_per_cell={points}",
                f"coupler.json:/time/end={END}"]
    return runner.run(folder_of(f"{form} {size} {quadrature} {points}"), scene, settings)


def row_of(name: str, found: Measured) -> list:
    table = found.table("probes.csv")
    of_gravity = table["soil.gravity_work"]
    works = [float(np.interp(time, table["time"], of_gravity)) for time in TIMES]
    loss = 100 * float(table["soil.quadrature_loss"][-1] / of_gravity[-1])
    return [name, *works, 1e3 * float(table["soil.front"][-1]), loss, found.solver_seconds()]


def fall(runner: Runner) -> None:
    """The fall of granular_obstacle over basis functions, quadrature, cells and points."""
    head = ["", *(f"work of gravity to {time:g} s [J/m]" for time in TIMES), "front [mm]",
            "quadrature_loss [%]", "CPU time [s]"]
    for size in STEPS:
        rows = []
        for form in forms_of(fine=False):
            cells = form.partition(",")[0]
            if size == "1.25" and cells == "tri3":
                continue  # no such grid
            for quadrature in QUADRATURES[form.rpartition(" ")[2]]:
                for points in POINTS[cells] if size != "1.25" else POINTS[cells][:1]:
                    found = run(runner, size, form, quadrature, points)
                    rows.append(row_of(f"{form}, {quadrature}, {points} points", found))
        runner.report(head, rows, f"h = {size} mm")
    runner.remark("F-bar, explicit steps of 0.1 ms per millimetre of cell size; front: that of the soil at the end; "
                  "quadrature_loss: over the work of gravity")


STUDIES = {"fall": fall}
