# SPDX-License-Identifier: BSD-3-Clause
"""Least squares between bounds with restarts, and how well the data determine each parameter."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy import optimize
from scipy.stats import norm, qmc, t

from .bounds import Sought

BEYOND = 1e3  # least misfit where the model has no answer
FARTHER = 10.0  # times the largest misfit that a sample has
ALIKE = 0.95  # correlation from which two parameters stand for each other
WIDE = 0.5  # standard deviation, of the value or its logarithm, from which nothing is known
AT_BOUND = 1e-3  # of z
OUTLIER = 0.05  # misfit from which robust fits count less, where misfits are shares of a range
LARGEST = 500.0  # half an interval of the logarithm, whose exponential is a number
UNSEEN = 1e-12  # share of the largest singular value at which a direction is round-off


class FitError(Exception):
    """A fit that cannot be made; the text says why."""


class Model(Protocol):
    """last_refusal: why a point had no answer the last time."""

    last_refusal: str

    def misfits(self, points: list[np.ndarray]) -> list[np.ndarray | None]:
        """Misfits at each point z; None: the model has no answer there."""


@dataclass(frozen=True)
class Search:
    """samples: over the whole box; polished: how many of the best are starts of least squares, after `start` [z] if
    given; outlier: misfit from which values count less, None: all alike; step: of z, for differences; tolerance:
    relative change of cost or z that ends a start; evaluations: most steps of one; floor: cost that the errors of the
    data alone give, of which a change by the tolerance ends a start too."""

    samples: int
    polished: int
    seed: int
    outlier: float | None = None
    step: float = 1e-4
    tolerance: float = 1e-10
    evaluations: int = 60
    start: np.ndarray | None = None
    floor: float = 0.0


@dataclass(frozen=True)
class Minimum:
    """End of one start. cost: half the sum of squared misfits."""

    z: np.ndarray
    cost: float
    converged: bool


@dataclass(frozen=True)
class Judge:
    """How sure a minimum is. of: what the data are called; flat: share of the largest singular value below which a
    direction is not seen; known: misfits are in standard deviations of the data, so that a misfit below one is no
    reason for more confidence."""

    of: str
    flat: float = UNSEEN
    known: bool = False


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
    misfits: np.ndarray
    remarks: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Slopes:
    """Derivatives of the misfits by z, [num_misfits, num_parameters]; bend: size of the second difference over that of
    the first one by each parameter, NaN where there is one side only or neither changes."""

    jacobian: np.ndarray
    bend: np.ndarray


def search(sought: Sequence[Sought], model: Model, how: Search) -> list[Minimum]:
    """Ends of the starts, the best one first.

    @raises FitError  no sample has an answer
    """
    cube = list(qmc.LatinHypercube(len(sought), seed=how.seed).random(how.samples)) if how.polished else []
    given = [] if how.start is None else [how.start]
    found = model.misfits([*given, *cube])
    order = sorted((float(np.sum(r**2)), k) for k, r in enumerate(found[len(given):]) if r is not None)
    starts = [z for z, r in zip(given, found) if r is not None] + [cube[k] for _, k in order[:how.polished]]
    if not starts:
        raise FitError(f"none of {len(found)} samples has an answer; the last: {model.last_refusal}")
    there = [r for r in found if r is not None]
    beyond = max(BEYOND, FARTHER * max(float(np.max(np.abs(r))) for r in there))

    constant = np.sqrt(2 * how.floor)  # one more misfit, that no parameter changes

    def misfit(z: np.ndarray) -> np.ndarray:
        (r,) = model.misfits([z])
        r = np.full(len(there[0]), beyond) if r is None else r
        return np.append(r, constant) if how.floor else r

    def jacobian(z: np.ndarray) -> np.ndarray:
        found = slopes_at(sought, model, z, how.step).jacobian
        return np.vstack([found, np.zeros(len(z))]) if how.floor else found

    loss = {} if how.outlier is None else {"loss": "soft_l1", "f_scale": how.outlier}
    ends = [optimize.least_squares(misfit, z, jac=jacobian, bounds=(0, 1), xtol=how.tolerance, ftol=how.tolerance,
                                   max_nfev=how.evaluations, **loss) for z in starts]
    return sorted((Minimum(end.x, float(end.cost) - how.floor, end.status != 0) for end in ends),
                  key=lambda end: end.cost)


def slopes_at(sought: Sequence[Sought], model: Model, z: np.ndarray, step: float) -> Slopes:
    """Central differences; to one side at a bound and where the model has no answer on the other."""
    pairs = []
    for k in range(len(z)):
        pairs += [np.clip(z + sign * step * np.eye(len(z))[k], 0, 1) for sign in (1, -1)]
    here, *found = model.misfits([z, *pairs])
    columns, bend = [], np.full(len(z), np.nan)
    for k, each in enumerate(sought):
        both = found[2 * k:2 * k + 2]
        (above, up), (below, down) = ((f if f is not None else here, p[k] if f is not None else z[k])
                                      for f, p in zip(both, pairs[2 * k:2 * k + 2]))
        if here is None or up == down:
            raise FitError(f"{each.name}: no neighbour of {each.value(z[k]):g} has an answer: {model.last_refusal}")
        columns.append((above - below) / (up - down))
        if all(f is not None for f in both) and np.isclose(up - z[k], z[k] - down):
            first, second = np.linalg.norm(above - below), np.linalg.norm(above - 2 * here + below)
            bend[k] = second / first if first > 0 else np.inf if second > 0 else np.nan
    return Slopes(np.column_stack(columns), bend)


def evaluate(sought: Sequence[Sought], misfits: np.ndarray, slopes: Slopes, z: np.ndarray, judge: Judge) -> Fit:
    """Confidence of a minimum, from misfits and derivatives there."""
    r, jacobian = misfits, slopes.jacobian
    _, singular, rows = np.linalg.svd(jacobian, full_matrices=False)
    seen = singular > UNSEEN * max(singular[0], 1e-300)
    inverse = (rows[seen].T / singular[seen] ** 2) @ rows[seen]
    variance, quantile = _spread(r, len(r) - len(z), judge.known)
    sd_z = np.sqrt(np.diag(inverse * variance))
    sd_z[np.max(np.abs(rows[~seen]), axis=0, initial=0) > 1e-6] = np.inf
    scale = np.sqrt(np.diag(inverse))
    correlation = inverse / np.outer(np.where(scale > 0, scale, 1), np.where(scale > 0, scale, 1))
    fit = Fit(z, {each.name: each.value(x) for each, x in zip(sought, z)},
              {each.name: float(s * each.width) for each, s in zip(sought, sd_z)},
              {each.name: _interval(each, x, quantile * s) for each, x, s in zip(sought, z, sd_z)},
              correlation, r)
    _remark(sought, fit, judge.of)
    for value, row in zip(singular, rows):
        if value < judge.flat * singular[0]:
            part = ", ".join(each.name for each, share in zip(sought, row) if abs(share) > 0.3)
            fit.remarks.append(f"{part}: not identified by {judge.of}: their change together is not seen in any curve "
                               f"(singular value {value / max(singular[0], 1e-300):.1e} of the largest)")
    return fit


def _spread(r: np.ndarray, freedom: int, known: bool) -> tuple[float, float]:
    """Variance of a misfit, and the quantile that makes an interval of 95 % of a standard deviation."""
    found = float(r @ r) / freedom if freedom else 0.0
    if known and found <= 1:
        return 1.0, float(norm.ppf(0.975))
    return found, float(t.ppf(0.975, freedom))


def _remark(sought: Sequence[Sought], fit: Fit, of: str) -> None:
    """Say of which parameters, alone and in pairs, the data know too little."""
    for each, z in zip(sought, fit.z):
        relative = fit.sd[each.name] / (1 if each.by_log else max(abs(fit.values[each.name]), 1e-300))
        if relative > WIDE:
            fit.remarks.append(f"{each.name}: not identified by {of}: standard deviation {100 * relative:.3g} %")
        if min(z, 1 - z) < AT_BOUND:
            fit.remarks.append(f"{each.name}: at the bound {each.value(round(z)):g}; the best value may lie beyond, "
                               "its standard deviation does not count")
    for (a, first), (b, second) in itertools.combinations(enumerate(sought), 2):
        if abs(fit.correlation[a, b]) > ALIKE:
            fit.remarks.append(f"{first.name}, {second.name}: not identified by {of} one without the other: "
                               f"correlation {fit.correlation[a, b]:.3f}")


def _interval(sought: Sought, z: float, half: float) -> tuple[float, float]:
    if not np.isfinite(half) or (sought.by_log and half * sought.width > LARGEST):
        return (0.0 if sought.by_log else -np.inf, np.inf)
    return (sought.value(z - half), sought.value(z + half))
