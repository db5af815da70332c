# SPDX-License-Identifier: BSD-3-Clause
"""Values of the parameters in each point of a study."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats
from scipy.stats import qmc

from .parameters import Parameter
from .reader import PlanError, PlanReader, is_number

SAMPLES = ("random", "latin_hypercube", "sobol")
METHODS = ("factorial", *SAMPLES, "sobol_indices")


@dataclass(frozen=True)
class Design:
    """method: of METHODS; runs: points of a sample, for sobol_indices of each of its two; seed: of the sample; cross:
    parameters of which each level meets each point of the sample; where: in the plan."""

    method: str
    where: str
    runs: int = 0
    seed: int = 0
    cross: tuple[str, ...] = ()

    @property
    def is_sample(self) -> bool:
        """Whether points are independent, or better spread than independent ones, so that means have an error."""
        return self.method in ("random", "latin_hypercube")


def read_design(reader: PlanReader, parameters: list[Parameter]) -> Design:
    method = reader.word("method", METHODS)
    if method == "factorial":
        reader = PlanReader(reader.values, reader.where, ("method",))
        for parameter in parameters:
            if parameter.levels is None:
                raise PlanError(f"{parameter.where}: found a distribution, allowed with method factorial: list, range")
        return Design(method, reader.where)
    runs, seed = reader.whole("runs", 2), reader.whole("seed", 0)
    if method.startswith("sobol") and runs & (runs - 1):
        near = 1 << runs.bit_length()
        raise reader.fail("runs", f"a power of two with method {method}, such as {near // 2} or {near}")
    cross = reader.words("cross") if "cross" in reader.values else ()
    levels = {parameter.name for parameter in parameters if parameter.levels is not None}
    for name in cross:
        if name not in levels or cross.count(name) > 1 or method == "sobol_indices":
            once = f"once each of {', '.join(sorted(levels)) or 'none'}"
            allowed = "no key cross" if method == "sobol_indices" else once
            raise PlanError(f"{reader.where}/cross: found {name}, allowed with this plan: {allowed}")
    if len(cross) == len(parameters):
        raise PlanError(f"{reader.where}/cross: found all parameters, allowed: method factorial for that")
    return Design(method, reader.where, runs, seed, cross)


def read_correlations(reader: PlanReader, parameters: list[Parameter], design: Design) -> np.ndarray:
    """Matrix of the parameters' normal scores, in their order; unit without the key correlations."""
    names = [parameter.name for parameter in parameters]
    matrix, where = np.eye(len(names)), f"{reader.where}/correlations"
    rows = reader.values.get("correlations", [])
    if not isinstance(rows, list):
        raise reader.fail("correlations", "a list of [parameter, parameter, number]")
    free = [parameter.name for parameter in parameters if parameter.distribution is not None]
    for k, row in enumerate(rows):
        fits = isinstance(row, list) and len(row) == 3 and row[0] in free and row[1] in free and row[0] != row[1]
        if not fits or not is_number(row[2]) or not -1 < row[2] < 1:
            raise PlanError(f"{where}/{k}: found {row!r}, allowed: [parameter, parameter, number between -1 and 1] of "
                            f"{', '.join(free) or 'no parameter: none has a distribution'}")
        i, j = names.index(row[0]), names.index(row[1])
        if matrix[i, j]:
            raise PlanError(f"{where}/{k}: found {row[0]} and {row[1]} again, allowed: once")
        matrix[i, j] = matrix[j, i] = row[2]
    if rows and design.method not in SAMPLES:
        raise PlanError(f"{where}: found with method {design.method}, allowed with: {', '.join(SAMPLES)}")
    if np.linalg.eigvalsh(matrix).min() < 1e-10:
        raise PlanError(f"{where}: found correlations that contradict each other, allowed: a positive definite matrix")
    return matrix


def points_of(parameters: list[Parameter], design: Design, correlations: np.ndarray) -> list[dict[str, Any]]:
    """Value of each parameter in each point, in the order of the runs.

    For sobol_indices each of `runs` groups has the points A, then A with one parameter from B in turn, then B
    (Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018).
    """
    if design.method == "factorial":
        combinations = itertools.product(*(parameter.levels for parameter in parameters))
        return [dict(zip((parameter.name for parameter in parameters), values)) for values in combinations]
    if design.method == "sobol_indices":
        return _values(parameters, _saltelli(len(parameters), design))
    sampled = [k for k, parameter in enumerate(parameters) if parameter.name not in design.cross]
    shares = _correlated(_shares(len(sampled), design), correlations[np.ix_(sampled, sampled)])
    points = _values([parameters[k] for k in sampled], shares)
    crossed = [parameter for parameter in parameters if parameter.name in design.cross]
    levels = itertools.product(*(parameter.levels for parameter in crossed))
    named = [dict(zip((parameter.name for parameter in crossed), values)) for values in levels]
    names = [parameter.name for parameter in parameters]
    return [{name: (above | point)[name] for name in names} for above in named for point in points]


def _values(parameters: list[Parameter], shares: np.ndarray) -> list[dict[str, Any]]:
    """Values of the parameters, for each row of shares."""
    columns = [parameter.at(column) for parameter, column in zip(parameters, shares.T)]
    return [dict(zip((parameter.name for parameter in parameters), row)) for row in zip(*columns)]


def _shares(count: int, design: Design) -> np.ndarray:
    """Shares in (0, 1), runs x count."""
    if design.method == "random":
        shares = np.random.default_rng(design.seed).random((design.runs, count))
    else:
        kind = qmc.LatinHypercube if design.method == "latin_hypercube" else qmc.Sobol
        shares = kind(count, seed=design.seed).random(design.runs)
    return np.clip(shares, 2.0**-53, 1 - 2.0**-53)  # the ends of a normal distribution lie at infinity


def _correlated(shares: np.ndarray, correlations: np.ndarray) -> np.ndarray:
    """Shares whose normal scores have these correlations (Gaussian copula)."""
    if np.array_equal(correlations, np.eye(len(correlations))):
        return shares
    return stats.norm.cdf(stats.norm.ppf(shares) @ np.linalg.cholesky(correlations).T)


def _saltelli(count: int, design: Design) -> np.ndarray:
    """Rows A, A with column k of B, …, B of each group: (runs (count + 2)) x count."""
    both = _shares(2 * count, design)
    rows = []
    for a, b in zip(both[:, :count], both[:, count:]):
        rows += [a, *(np.where(np.arange(count) == k, b, a) for k in range(count)), b]
    return np.array(rows)
