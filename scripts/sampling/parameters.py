# SPDX-License-Identifier: BSD-3-Clause
"""Parameters of a plan: settings with the values that they take."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy import stats

from .reader import PlanError, PlanReader, is_number

DISTRIBUTIONS = ("uniform", "log_uniform", "normal", "lognormal")
LISTED = ("list", "range")
KEYS = ("set", *LISTED, "variants", *DISTRIBUTIONS)


@dataclass(frozen=True)
class Parameter:
    """A name for settings that get one value in each run, or for variants: names for several settings together.

    paths: FILE:/key/key of each; levels: the values of a list or range, names of variants, None of a distribution;
    variants: name -> path -> value.
    """

    name: str
    paths: tuple[str, ...]
    where: str  #: in the plan
    levels: tuple[Any, ...] | None
    distribution: Any = None  #: of scipy.stats, frozen
    variants: dict[str, dict[str, Any]] = field(default_factory=dict)

    def settings(self, value: Any) -> dict[str, Any]:
        """Path -> value of the settings that one of its values sets."""
        return self.variants[value] if self.variants else {path: value for path in self.paths}

    @property
    def all_paths(self) -> set[str]:
        """Every path that one of its values sets."""
        return {*self.paths, *(path for settings in self.variants.values() for path in settings)}

    def at(self, shares: np.ndarray) -> list[Any]:
        """Values at shares of the probability, in (0, 1); values of a list are equally probable."""
        if self.levels is not None:
            numbers = np.minimum((shares * len(self.levels)).astype(int), len(self.levels) - 1)
            return [self.levels[number] for number in numbers]
        return self.distribution.ppf(shares).tolist()


def read_parameter(name: str, reader: PlanReader) -> Parameter:
    kind = reader.one_of((*LISTED, "variants", *DISTRIBUTIONS))
    if kind == "variants":
        return _variants(name, reader)
    paths = reader.words("set")
    if kind in LISTED:
        levels = _list(reader) if kind == "list" else _range(reader)
        return Parameter(name, paths, reader.where, levels)
    return Parameter(name, paths, reader.where, None, {"uniform": _uniform, "log_uniform": _uniform, "normal": _normal,
                                                       "lognormal": _lognormal}[kind](reader, kind))


def require_apart(parameters: list[Parameter], settings: dict[str, Any]) -> None:
    """Check that a parameter keeps what it sets in each run: none that comes later sets the same, or an object around
    it; and that it sets nothing that the settings of the plan set.

    @raises PlanError  one does
    """
    for each in parameters:
        for path in sorted(each.all_paths):
            if any(own == path or own.startswith(f"{path}/") for own in settings):
                raise PlanError(f"{each.where}: found {path}, which \"settings\" of the plan sets too, allowed: one of "
                                "both")
    for number, later in enumerate(parameters):
        for earlier in parameters[:number]:
            for path in sorted(later.all_paths):
                if any(own == path or own.startswith(f"{path}/") for own in earlier.all_paths):
                    raise PlanError(f"{later.where}: found {path}, which overwrites what {earlier.name} sets, allowed: "
                                    "another setting, or an object before what is in it")


def _variants(name: str, reader: PlanReader) -> Parameter:
    reader = PlanReader(reader.values, reader.where, ("variants",))
    variants = {each: inner.values for each, inner in reader.named("variants", None).items()}
    if not variants:
        raise reader.fail("variants", "name -> path -> value, at least one")
    return Parameter(name, (), reader.where, tuple(variants), variants=variants)


def _list(reader: PlanReader) -> tuple[Any, ...]:
    values = reader.values["list"]
    if not isinstance(values, list) or not values or any(values.count(value) > 1 for value in values):
        raise reader.fail("list", "a list of different values, at least one")
    return tuple(values)


def _range(reader: PlanReader) -> tuple[Any, ...]:
    """Values from the first to the last one; whole ones stay whole."""
    inner = reader.inner("range", ("from", "to", "count", "spacing"))
    low, high, count = inner.real("from"), inner.real("to"), inner.whole("count", 2)
    spacing = inner.word("spacing", ("linear", "log")) if "spacing" in inner.values else "linear"
    if low == high:
        raise inner.fail("to", f"another number than from, {low:g}")
    if spacing == "log" and not (low > 0 and high > 0):
        raise inner.fail("from", "from and to > 0 with spacing log")
    values = np.geomspace(low, high, count) if spacing == "log" else np.linspace(low, high, count)
    whole = all(isinstance(inner.values[key], int) for key in ("from", "to"))
    whole = whole and np.array_equal(values, np.rint(values))
    return tuple(int(value) if whole else float(value) for value in values)


def _uniform(reader: PlanReader, kind: str) -> Any:
    pair = reader.values[kind]
    if not isinstance(pair, list) or len(pair) != 2 or not all(map(is_number, pair)) or not pair[0] < pair[1]:
        raise reader.fail(kind, "[low, high] with low < high")
    if kind == "log_uniform":
        if pair[0] <= 0:
            raise reader.fail(kind, "[low, high] with 0 < low")
        return stats.loguniform(*pair)
    return stats.uniform(pair[0], pair[1] - pair[0])


def _normal(reader: PlanReader, kind: str) -> Any:
    inner = reader.inner(kind, ("mean", "deviation"))
    return stats.norm(inner.real("mean"), inner.number("deviation"))


def _lognormal(reader: PlanReader, kind: str) -> Any:
    """Distribution by median and deviation of the logarithm, or by mean and coefficient of variation."""
    inner = reader.inner(kind, ("median", "log_deviation", "mean", "variation"))
    first = inner.one_of(("median", "mean"))
    if first == "median":
        median, deviation, second = inner.number("median"), inner.number("log_deviation"), "log_deviation"
    else:
        deviation = float(np.sqrt(np.log1p(inner.number("variation") ** 2)))
        median, second = inner.number("mean") / np.exp(deviation**2 / 2), "variation"
    for key in inner.values:
        if key not in (first, second):
            raise PlanError(f"{inner.where}/{key}: found beside {first}, allowed: {second}")
    return stats.lognorm(deviation, scale=median)
