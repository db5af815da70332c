# SPDX-License-Identifier: BSD-3-Clause
"""Least squares of parameters of a law against tests of a laboratory, and how well the tests determine each of them."""

import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from element.calibration_plan import CalibrationPlan, LabTest
from element.curves import curves_of
from element.laboratory import ElementError
from element.program import CANNOT_FOLLOW, PROGRAMS, Soil, run_program
from fitting.least_squares import OUTLIER, Fit, FitError, Judge, Search, evaluate, search, slopes_at
from studies.runner import CORES

REFUSED_INPUT = 2  # exit code: values that the law does not allow together
JUDGE = Judge("these tests", flat=1e-3)


class Model:
    """Misfits of all tests at given values."""

    def __init__(self, plan: CalibrationPlan, programs: Path = PROGRAMS):
        self.plan, self.programs = plan, programs
        self.last_refusal = ""
        self.runs = 0
        self._known: dict[bytes, np.ndarray | None] = {}

    def misfits(self, points: list[np.ndarray]) -> list[np.ndarray | None]:
        """Misfits over the ranges of the curves at each point; None: the law has no answer."""
        new = {z.tobytes(): z for z in points if z.tobytes() not in self._known}
        with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(CORES) as pool:
            jobs = [(z, test, Path(folder) / str(n)) for n, z in enumerate(new.values()) for test in self.plan.tests]
            for job in jobs:
                job[2].mkdir(exist_ok=True)
            found = list(pool.map(lambda job: self._misfit(*job), jobs))
        count = len(self.plan.tests)
        for n, key in enumerate(new):
            parts = found[n * count:(n + 1) * count]
            self._known[key] = None if any(part is None for part in parts) else np.concatenate(parts)
        return [self._known[z.tobytes()] for z in points]

    def curves(self, z: np.ndarray, test: LabTest, folder: Path) -> dict[str, np.ndarray] | None:
        """Curves of one test; None: it was not followed to its end."""
        self.runs += 1
        run = run_program(folder, test.name, test.program, Soil(blocks=self.plan.blocks_at(z)), self.programs)
        if run.code not in (0, REFUSED_INPUT, CANNOT_FOLLOW):
            raise ElementError(f"{test.name}: {run.message}")
        if run.code != 0:
            self.last_refusal = f"{test.name}: {run.message}"
            return None
        return curves_of(run.table, test.band_width)

    def _misfit(self, z: np.ndarray, test: LabTest, folder: Path) -> np.ndarray | None:
        curves = self.curves(z, test, folder)
        if curves is None:
            return None
        x, at = curves[test.over], test.measured.columns[test.over]
        if not (np.diff(x) > 0).all():
            raise ElementError(f"{test.name}: {test.over} of the model does not ascend, "
                               "allowed: an \"over\" that does")
        slack = 1e-9 * abs(x[-1])
        if at.min() < x[0] - slack or at.max() > x[-1] + slack:
            raise ElementError(f"{test.measured.path}: {test.over} goes from {at.min():g} to {at.max():g}, "
                               f"the model from {x[0]:g} to {x[-1]:g}: measured values have to lie within")
        return np.concatenate([(np.interp(at, x, curves[column]) - test.measured.columns[column]) / test.scale(column)
                               for column in test.fitted])


def calibrate(plan: CalibrationPlan, model: Model) -> Fit:
    """Samples over the whole box, the best of them polished.

    @raises ElementError  no sample has an answer
    """
    how = Search(plan.samples, plan.polished, plan.seed, OUTLIER if plan.robust else None)
    try:
        best = search(plan.sought, model, how)[0]
        if not best.converged:
            raise ElementError(f"no minimum in {how.evaluations} evaluations; narrower bounds or fewer parameters may "
                               "help")
        (r,) = model.misfits([best.z])
        return evaluate(plan.sought, r, slopes_at(plan.sought, model, best.z, how.step), best.z, JUDGE)
    except FitError as error:
        raise ElementError(str(error)) from error


def misfit_of_curves(plan: CalibrationPlan, fit: Fit) -> dict[str, float]:
    """Root mean square by test and column, over its range."""
    found, first = {}, 0
    for test in plan.tests:
        size = len(test.measured.columns[test.over])
        for column in test.fitted:
            found[f"{test.name} {column}"] = float(np.sqrt(np.mean(fit.misfits[first:first + size] ** 2)))
            first += size
    return found
