# SPDX-License-Identifier: BSD-3-Clause
"""Least squares of parameters of a law against tests of a laboratory, and what the tests say of each of them."""

import itertools
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc, t

from element.calibration_plan import CalibrationPlan, LabTest, Sought
from element.curves import curves_of
from element.laboratory import ElementError
from element.program import CANNOT_FOLLOW, PROGRAMS, Soil, run_program
from studies.runner import CORES

REFUSED_INPUT = 2  # exit code: values that the law does not allow together
STEP = 1e-4  # of z, for differences
BEYOND = 1e3  # misfit where the law has no answer
ALIKE = 0.95  # correlation from which two parameters stand for each other
WIDE = 0.5  # standard deviation, of the value or its logarithm, from which nothing is known
FLAT = 1e-3  # share of the largest singular value below which a direction is not seen
AT_BOUND = 1e-3  # of z
EVALUATIONS = 60  # of one polish
OUTLIER = 0.05  # misfit from which robust fits count less
LARGEST = 500.0  # half an interval of the logarithm, whose exponential is a number


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

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """Derivatives by central differences; to one side at a bound and where the law has no answer on the other."""
        pairs = []
        for k in range(len(z)):
            pairs += [np.clip(z + sign * STEP * np.eye(len(z))[k], 0, 1) for sign in (1, -1)]
        here, *found = self.misfits([z, *pairs])
        columns = []
        for k in range(len(z)):
            (above, up), (below, down) = ((f if f is not None else here, p[k] if f is not None else z[k])
                                          for f, p in zip(found[2 * k:2 * k + 2], pairs[2 * k:2 * k + 2]))
            if here is None or up == down:
                sought = self.plan.sought[k]
                raise ElementError(f"{sought.name}: no neighbour of {sought.value(z[k]):g} has an answer: "
                                   f"{self.last_refusal}")
            columns.append((above - below) / (up - down))
        return np.column_stack(columns)


@dataclass
class Fit:
    """The best parameters, and how sure they are.

    sd and interval hold if misfits are independent and equally large.
    """

    z: np.ndarray
    values: dict[str, float]
    sd: dict[str, float]  #: of the value, or of its logarithm where it was sought by that
    interval: dict[str, tuple[float, float]]  #: 95 %
    correlation: np.ndarray
    misfit: dict[str, float]  #: root mean square by test and column, over its range
    remarks: list[str] = field(default_factory=list)


def calibrate(plan: CalibrationPlan, model: Model) -> Fit:
    """Samples over the whole box, the best of them polished.

    @raises ElementError  no sample has an answer
    """
    cube = qmc.LatinHypercube(len(plan.sought), seed=plan.seed).random(plan.samples)
    found = model.misfits(list(cube))
    order = sorted((float(np.sum(r**2)), k) for k, r in enumerate(found) if r is not None)
    if not order:
        raise ElementError(f"none of {plan.samples} samples has an answer of the law; the last: {model.last_refusal}")
    size = len(found[order[0][1]])

    def misfit(z: np.ndarray) -> np.ndarray:
        (r,) = model.misfits([z])
        return np.full(size, BEYOND) if r is None else r

    loss = {"loss": "soft_l1", "f_scale": OUTLIER} if plan.robust else {}
    tried = [least_squares(misfit, cube[k], jac=model.jacobian, bounds=(0, 1), xtol=1e-10, ftol=1e-10,
                           max_nfev=EVALUATIONS, **loss)
             for _, k in order[:plan.polished]]
    best = min(tried, key=lambda result: result.cost)
    if best.status == 0:
        raise ElementError(f"no minimum in {EVALUATIONS} evaluations; narrower bounds or fewer parameters may help")
    return evaluate(plan, model, best.x)


def evaluate(plan: CalibrationPlan, model: Model, z: np.ndarray) -> Fit:
    """Confidence of a minimum, from the Jacobian there."""
    (r,), J = model.misfits([z]), model.jacobian(z)
    _, singular, rows = np.linalg.svd(J, full_matrices=False)
    seen = singular > 1e-12 * max(singular[0], 1e-300)
    freedom = len(r) - len(z)
    inverse = (rows[seen].T / singular[seen] ** 2) @ rows[seen]
    covariance = inverse * float(r @ r) / freedom
    sd_z = np.sqrt(np.diag(covariance))
    sd_z[np.max(np.abs(rows[~seen]), axis=0, initial=0) > 1e-6] = np.inf
    scale = np.sqrt(np.diag(inverse))
    correlation = inverse / np.outer(np.where(scale > 0, scale, 1), np.where(scale > 0, scale, 1))
    quantile = t.ppf(0.975, freedom)
    fit = Fit(z, {each.name: each.value(x) for each, x in zip(plan.sought, z)},
              {each.name: float(s * each.width) for each, s in zip(plan.sought, sd_z)},
              {each.name: _interval(each, x, quantile * s) for each, x, s in zip(plan.sought, z, sd_z)},
              correlation, _misfits(plan, r))
    _remark(plan, fit)
    for value, row in zip(singular, rows):
        if value < FLAT * singular[0]:
            part = ", ".join(each.name for each, share in zip(plan.sought, row) if abs(share) > 0.3)
            fit.remarks.append(f"{part}: not identified by these tests: their change together is not seen in any curve "
                               f"(singular value {value / max(singular[0], 1e-300):.1e} of the largest)")
    return fit


def _remark(plan: CalibrationPlan, fit: Fit) -> None:
    """Say of which parameters, alone and in pairs, the tests know too little."""
    for each, z in zip(plan.sought, fit.z):
        relative = fit.sd[each.name] / (1 if each.by_log else max(abs(fit.values[each.name]), 1e-300))
        if relative > WIDE:
            fit.remarks.append(f"{each.name}: not identified by these tests: standard deviation {100 * relative:.3g} %")
        if min(z, 1 - z) < AT_BOUND:
            fit.remarks.append(f"{each.name}: at the bound {each.value(round(z)):g}; the best value may lie beyond, "
                               "its standard deviation does not count")
    for (a, first), (b, second) in itertools.combinations(enumerate(plan.sought), 2):
        if abs(fit.correlation[a, b]) > ALIKE:
            fit.remarks.append(f"{first.name}, {second.name}: not identified by these tests one without the other: "
                               f"correlation {fit.correlation[a, b]:.3f}")


def _interval(sought: Sought, z: float, half: float) -> tuple[float, float]:
    if not np.isfinite(half) or (sought.by_log and half * sought.width > LARGEST):
        return (0.0 if sought.by_log else -np.inf, np.inf)
    return (sought.value(z - half), sought.value(z + half))


def _misfits(plan: CalibrationPlan, r: np.ndarray) -> dict[str, float]:
    found, first = {}, 0
    for test in plan.tests:
        size = len(test.measured.columns[test.over])
        for column in test.fitted:
            found[f"{test.name} {column}"] = float(np.sqrt(np.mean(r[first:first + size] ** 2)))
            first += size
    return found
