# SPDX-License-Identifier: BSD-3-Clause
"""Statistics of the answers of many runs."""

from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

from studies.measures import Curve

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
SAMPLES = 201  # times of bands
RESAMPLED, RESAMPLING_SEED = 1000, 0  # for the confidence of Sobol indices
GROUPS = 8  # of intensities that differ from run to run
CONFIDENCE = 0.95


def standard_error(values: np.ndarray) -> float:
    """Standard error of the mean of independent values; NaN of fewer than two."""
    return float(np.std(values, ddof=1) / np.sqrt(len(values))) if len(values) > 1 else float("nan")


@dataclass(frozen=True)
class Indices:
    """Sobol indices of each parameter: share of the variance by it alone, and with all others; both [count], and the
    lower and upper ends of their confidence, [2, count]."""

    first: np.ndarray
    total: np.ndarray
    first_ends: np.ndarray
    total_ends: np.ndarray


def sobol_indices(answers: np.ndarray) -> Indices:
    """Indices by groups of runs (design.points_of), [groups, count + 2]: A, A with each parameter from B, B.

    First order by Saltelli et al. (2010, doi:10.1016/j.cpc.2009.09.018), total by Jansen (1999,
    doi:10.1016/S0010-4655(98)00154-4), the estimators of SALib and scipy.stats (from 1.11 on); confidence by resampling
    the groups. NaN where all answers are the same.
    """
    first, total = _indices(answers)
    if np.isnan(first).any():
        return Indices(first, total, np.stack([first, first]), np.stack([total, total]))
    random = np.random.default_rng(RESAMPLING_SEED)
    again = [_indices(answers[random.integers(len(answers), size=len(answers))]) for _ in range(RESAMPLED)]
    ends = np.nanquantile(again, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2], axis=0)
    return Indices(first, total, ends[:, 0], ends[:, 1])


def _indices(answers: np.ndarray) -> np.ndarray:
    """First and total, [2, count]; NaN where all answers are the same."""
    a, mixed, b = answers[:, :1], answers[:, 1:-1], answers[:, -1:]
    mean, variance = np.mean(answers[:, [0, -1]]), np.var(answers[:, [0, -1]])
    if not variance > 1e-24 * max(mean**2, 1e-300):
        return np.full((2, mixed.shape[1]), np.nan)
    first = np.mean((b - mean) * (mixed - a), axis=0) / variance
    return np.stack([first, np.mean((a - mixed) ** 2, axis=0) / 2 / variance])


@dataclass(frozen=True)
class Level:
    """Runs of like intensity: its mean, how many they are, in how many the demand exceeds the capacity."""

    intensity: float
    runs: int
    exceeded: int

    @property
    def share(self) -> float:
        return self.exceeded / self.runs

    @property
    def ends(self) -> tuple[float, float]:
        """Confidence of the share (Clopper and Pearson 1934)."""
        tail, failed = (1 - CONFIDENCE) / 2, self.runs - self.exceeded
        low = stats.beta.ppf(tail, self.exceeded, failed + 1) if self.exceeded else 0.0
        high = stats.beta.ppf(1 - tail, self.exceeded + 1, failed) if failed else 1.0
        return float(low), float(high)


def levels_of(intensity: np.ndarray, exceeded: np.ndarray) -> list[Level]:
    """Runs grouped by equal intensities where each comes at least twice on average, else in GROUPS of as many runs
    each."""
    values = np.unique(intensity)
    order = np.argsort(intensity, kind="stable")
    if 2 * len(values) <= len(intensity):
        groups = [np.flatnonzero(intensity == value) for value in values]
    else:
        groups = np.array_split(order, min(GROUPS, len(order)))
    return [Level(float(np.mean(intensity[group])), len(group), int(np.sum(exceeded[group]))) for group in groups]


@dataclass(frozen=True)
class Fit:
    """Lognormal curve: probability Phi(ln(x / median) / deviation)."""

    median: float
    deviation: float

    def at(self, intensity: np.ndarray) -> np.ndarray:
        return stats.norm.cdf(np.log(intensity / self.median) / self.deviation)


def fit_fragility(intensity: np.ndarray, exceeded: np.ndarray) -> Fit | str:
    """Fit by maximum likelihood (Baker 2015, doi:10.1193/021113EQS025M), or the reason why the runs allow none."""
    if exceeded.all() or not exceeded.any():
        return f"the demand exceeds the capacity in {'all' if exceeded.all() else 'no'} runs"
    if intensity.min() <= 0:
        return f"a lognormal curve needs intensities > 0, found {intensity.min():g}"
    if intensity[~exceeded].max() <= intensity[exceeded].min():
        return (f"no run below {intensity[exceeded].min():g} exceeds the capacity and all above do: the runs say where "
                "the curve lies, not how steep it is")
    if np.mean(np.log(intensity[exceeded])) <= np.mean(np.log(intensity[~exceeded])):
        return "the demand exceeds the capacity less often at larger intensity"
    logs = np.log(intensity)

    def unlikeliness(slopes: np.ndarray) -> float:
        score = slopes[0] + np.exp(slopes[1]) * (logs - logs.mean())
        return -float(np.sum(stats.norm.logcdf(np.where(exceeded, score, -score))))

    found = optimize.minimize(unlikeliness, [0.0, -np.log(max(np.std(logs), 1e-6))], method="Nelder-Mead",
                              options={"xatol": 1e-8, "fatol": 1e-10, "maxiter": 4000})
    if not found.success:
        return f"the likelihood has no maximum: {found.message}"
    deviation = float(np.exp(-found.x[1]))
    return Fit(float(np.exp(logs.mean() - found.x[0] * deviation)), deviation)


@dataclass(frozen=True)
class Band:
    """Curves at common times [num_times]: mean, its standard error, quantiles [num quantiles, num_times]."""

    time: np.ndarray
    mean: np.ndarray
    error: np.ndarray
    quantiles: np.ndarray
    ends: tuple[float, float]  #: shortest and longest of the curves [s]


def band_of(curves: list[Curve]) -> Band:
    """Band of the curves over the times that all of them have."""
    first = max(curve.time[0] for curve in curves)
    ends = min(curve.time[-1] for curve in curves), max(curve.time[-1] for curve in curves)
    time = np.linspace(first, ends[0], SAMPLES)
    values = np.array([curve.at(time) for curve in curves])
    error = np.std(values, axis=0, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.full(len(time), np.nan)
    return Band(time, values.mean(axis=0), error, np.quantile(values, QUANTILES, axis=0), ends)
