# SPDX-License-Identifier: BSD-3-Clause
"""Answers that a study takes from each run: numbers and curves over time."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plotting.results import Results, ResultsError
from studies.measures import Curve

from .reader import PlanReader, is_number

TABLES = ("probes.csv", "steps.csv")
TAKES = ("largest", "smallest", "peak", "time_of_peak", "last", "mean", "integral")
ALLOWED = f"one of {', '.join(TAKES)}, or {{\"mean_of_last\": seconds}}"


@dataclass(frozen=True)
class Answer:
    """A number of a run: of a column over time, or at a JSON pointer of summary.json."""

    name: str
    table: str = ""
    column: str = ""
    take: Any = None
    pointer: str = ""

    def of(self, results: Results) -> float:
        """@raises ResultsError  no such column or number"""
        if self.pointer:
            return _number_at(results, self.pointer)
        return _TAKEN[self.take](*_samples(results, self.table, self.column)) if isinstance(self.take, str) else \
            Curve(*_samples(results, self.table, self.column)).mean_of_last(self.take["mean_of_last"])


def read_answer(name: str, reader: PlanReader) -> Answer:
    if reader.one_of(("column", "summary")) == "summary":
        pointer = reader.text("summary", "a JSON pointer into summary.json, such as /steps")
        if not pointer.startswith("/") or len(reader.values) > 1:
            raise reader.fail("summary", "a JSON pointer into summary.json, such as /steps, and no other key")
        return Answer(name, pointer=pointer)
    take = reader.values.get("take")
    last = isinstance(take, dict) and list(take) == ["mean_of_last"] and is_number(take["mean_of_last"]) and \
        take["mean_of_last"] > 0
    if not last and (not isinstance(take, str) or take not in TAKES):
        raise reader.fail("take", ALLOWED)
    table, column = read_column(reader)
    return Answer(name, table, column, take)


def read_column(reader: PlanReader) -> tuple[str, str]:
    """Table and column of an answer or a curve."""
    table = reader.word("table", TABLES) if "table" in reader.values else TABLES[0]
    return table, reader.text("column", f"the name of a column of {table}")


def curve_of(results: Results, table: str, column: str) -> Curve:
    """@raises ResultsError  no such column, or no number in it"""
    return Curve(*_samples(results, table, column))


def _samples(results: Results, name: str, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and values where there is one."""
    table = results.table(name)
    if table is None:
        raise ResultsError(f"{results.folder}: no {name}")
    values = table[column]
    if values.dtype.kind != "f":
        raise ResultsError(f"{table.path}: {column} is a column of texts")
    there = np.isfinite(values)
    if not there.any():
        raise ResultsError(f"{table.path}: no number in the column {column}")
    return table["time"][there], values[there]


def _number_at(results: Results, pointer: str) -> float:
    value: Any = results.summary
    for key in pointer[1:].split("/"):
        below = value.get(key) if isinstance(value, dict) else None
        if below is None:
            known = ", ".join(value) if isinstance(value, dict) else "a value without keys"
            raise ResultsError(f"{results.folder}/summary.json: nothing at {pointer}; there are {known}")
        value = below
    if not is_number(value):
        raise ResultsError(f"{results.folder}/summary.json: found {value!r} at {pointer}, allowed: a number")
    return float(value)


def _peak_at(values: np.ndarray) -> int:
    return int(np.argmax(np.abs(values)))


def _mean(time: np.ndarray, values: np.ndarray) -> float:
    """Mean over time."""
    return _integral(time, values) / float(time[-1] - time[0]) if len(time) > 1 else float(values[0])


def _integral(time: np.ndarray, values: np.ndarray) -> float:
    return float(np.sum(np.diff(time) * (values[1:] + values[:-1]) / 2))


_TAKEN = {
    "largest": lambda time, values: float(np.max(values)),
    "smallest": lambda time, values: float(np.min(values)),
    "peak": lambda time, values: float(values[_peak_at(values)]),
    "time_of_peak": lambda time, values: float(time[_peak_at(values)]),
    "last": lambda time, values: float(values[-1]),
    "mean": _mean,
    "integral": _integral,
}
