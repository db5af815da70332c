# SPDX-License-Identifier: BSD-3-Clause
"""Least squares of parameters of a law against tests of a laboratory, and how well the tests determine each of them."""

import tempfile
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
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
        require_columns(test, curves, curves)
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


CONSTANT = 1e-6  # share of the measured range by which a curve has to change
POOR = 0.2  # misfit over the range of a curve beyond which the law does not follow it


WITHIN = (0.3, 0.5, 0.7)  # where in the bounds the curves of a test are looked at


def require_columns(test: LabTest, curves: Collection[str], allowed: Collection[str]) -> None:
    """@raises ElementError  a column is not one of these curves"""
    for name in (test.over, *test.fitted):
        if name not in curves:
            what = "does not change" if name in allowed else "is not known"
            raise ElementError(f"{test.measured.path}: found the column {name}, which {what} in the test {test.name} "
                               f"({test.test}), allowed: {', '.join(name for name in allowed if name in curves)}"
                               + ("; slip needs \"band_width\"" if name == "slip" else ""))


def require_answers(plan: CalibrationPlan, model: Model) -> None:
    """@raises ElementError  a test keeps a column as it is, whatever the parameters"""
    for test in plan.tests:
        changing, known = set(), set()
        for z in WITHIN:
            with tempfile.TemporaryDirectory() as folder:
                curves = model.curves(np.full(len(plan.sought), z), test, Path(folder)) or {}
            known |= curves.keys()
            changing |= {name for name, curve in curves.items() if np.ptp(curve) > CONSTANT * max(
                test.scale(name) if name in test.measured.columns else 0, np.finfo(float).tiny)}
        if known:  # else the search says why
            require_columns(test, changing, sorted(known))


def calibrate(plan: CalibrationPlan, model: Model) -> Fit:
    """Samples over the whole box, the best of them polished.

    @raises ElementError  no sample has an answer, or a test none to a column
    """
    require_answers(plan, model)
    how = Search(plan.samples, plan.polished, plan.seed, OUTLIER if plan.robust else None)
    try:
        best = search(plan.sought, model, how)[0]
        if not best.converged:
            raise ElementError(f"no minimum in {how.evaluations} evaluations; narrower bounds or fewer parameters may "
                               "help")
        (r,) = model.misfits([best.z])
        fit = evaluate(plan.sought, r, slopes_at(plan.sought, model, best.z, how.step), best.z, JUDGE)
        return replace(fit, remarks=[*fit.remarks, *remarks_on_curves(misfit_of_curves(plan, fit))])
    except FitError as error:
        raise ElementError(str(error)) from error


def remarks_on_curves(misfits: dict[str, float]) -> list[str]:
    return [f"{name}: the law misses the curve by {100 * misfit:.0f} % of its range, whatever the parameters: the "
            "values above do not describe this soil" for name, misfit in misfits.items() if misfit > POOR]


def misfit_of_curves(plan: CalibrationPlan, fit: Fit) -> dict[str, float]:
    """Root mean square by test and column, over its range."""
    found, first = {}, 0
    for test in plan.tests:
        size = len(test.measured.columns[test.over])
        for column in test.fitted:
            found[f"{test.name} {column}"] = float(np.sqrt(np.mean(fit.misfits[first:first + size] ** 2)))
            first += size
    return found
