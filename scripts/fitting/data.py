# SPDX-License-Identifier: BSD-3-Clause
"""Measured data, and the values of a run in their place."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plotting.deposit import Deposit, find_deposit
from plotting.results import Results, ResultsError
from sampling.answers import Answer, curve_of
from sampling.measured_csv import MeasuredCsv
from sampling.reader import PlanError

FIELDS = ("depth", "max_depth", "max_speed")  # of a deposit
#: units of each quantity, in SI units; columns without a unit are in SI units
QUANTITIES = {
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3}, "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6}, "force over width": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6},
    "stress": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6}, "speed": {"m/s": 1.0, "km/h": 1 / 3.6},
    "share": {"-": 1.0, "%": 1e-2},
}
UNITS = {unit: (quantity, factor) for quantity, units in QUANTITIES.items() for unit, factor in units.items()}


@dataclass(frozen=True)
class OverTime:
    """A column of a table of the run at the times of the data [s], linear between its rows."""

    table: str
    column: str

    def of(self, results: Results, at: np.ndarray, where: str) -> np.ndarray:
        curve = curve_of(results, self.table, self.column)
        time = at[:, 0]
        slack = 1e-9 * abs(curve.time[-1])
        if time.min() < curve.time[0] - slack or time.max() > curve.time[-1] + slack:
            raise ResultsError(f"{where}: found times from {time.min():g} to {time.max():g} s, allowed: those of "
                               f"{self.column} in {results.folder}, {curve.time[0]:g} to {curve.time[-1]:g} s")
        return curve.at(time)

    def course(self, results: Results) -> tuple[np.ndarray, np.ndarray]:
        """Abscissa and values of the run, for a picture."""
        curve = curve_of(results, self.table, self.column)
        return curve.time, curve.values


@dataclass(frozen=True)
class OneNumber:
    """A number of the run, such as the largest value of a column."""

    answer: Answer

    def of(self, results: Results, at: np.ndarray, where: str) -> np.ndarray:
        return np.array([self.answer.of(results)])


@dataclass(frozen=True)
class OverPlan:
    """A field of the deposit (scripts/deposit) at points of the plan, in map coordinates, linear between the centres of
    its cells, 0 where there is no soil. time [s], None: the last frame; cell: its side [m], None: two material points
    wide."""

    field: str
    time: float | None
    cell: float | None

    def of(self, results: Results, at: np.ndarray, where: str) -> np.ndarray:
        deposit = self._deposit(results)
        centres, values = self._padded(results, deposit)
        if len(centres) != at.shape[1]:
            raise ResultsError(f"{where}: found {at.shape[1]} coordinates, allowed: {len(centres)}, those of the plan")
        inside = np.all([(axis[0] <= x) & (x <= axis[-1]) for axis, x in zip(centres, at.T)], axis=0)
        found = np.zeros(len(at))
        if inside.any():
            found[inside] = _linear(centres, values, at[inside])
        return found

    def course(self, results: Results) -> tuple[np.ndarray, np.ndarray]:
        centres, values = self._padded(results, self._deposit(results))
        return centres[0], values

    def _deposit(self, results: Results) -> Deposit:
        deposit = find_deposit(results, self.time, self.cell)
        if self.time is not None and abs(deposit.time - self.time) > 1e-6 * max(1.0, abs(self.time)):
            raise ResultsError(f"{results.folder}: found no frame at {self.time:g} s, the nearest is at "
                               f"{deposit.time:g} s")
        return deposit

    def _padded(self, results: Results, deposit: Deposit) -> tuple[list[np.ndarray], np.ndarray]:
        """Centres of the cells along each axis, with a dry one all around, in map coordinates; values."""
        plan = deposit.plan
        centres = []
        for axis, number in enumerate(plan.axes):
            inner = plan.centres(axis) + results.origin[number]
            centres.append(np.concatenate([[inner[0] - plan.cell], inner, [inner[-1] + plan.cell]]))
        return centres, np.pad(getattr(deposit, self.field), 1)


Source = OverTime | OneNumber | OverPlan


def _linear(centres: list[np.ndarray], values: np.ndarray, at: np.ndarray) -> np.ndarray:
    if len(centres) == 1:
        return np.interp(at[:, 0], centres[0], values)
    from scipy.interpolate import RegularGridInterpolator
    return RegularGridInterpolator(centres, values)(at)


@dataclass(frozen=True)
class DataSet:
    """Measured values [num] with their standard deviations, in SI units, over times [s] or places [m],
    [num, num_coordinates]; where: in the plan."""

    name: str
    where: str
    over: tuple[str, ...]
    at: np.ndarray
    values: np.ndarray
    deviation: np.ndarray
    source: Source

    def predicted(self, results: Results) -> np.ndarray:
        """Values of the run in their place. @raises ResultsError  it lacks them"""
        return self.source.of(results, self.at, self.where)


class MeasuredTable(MeasuredCsv):
    """Measured values in SI units. @raises PlanError  what MeasuredCsv refuses, or an unknown unit"""

    def __init__(self, path: Path, where: str):
        super().__init__(path, PlanError, f"{where}: {path}")
        for name, (_, unit) in self.columns.items():
            if unit is not None and unit not in UNITS:
                raise PlanError(f"{self.where}: found the unit {unit!r} of {name}, allowed: {', '.join(UNITS)}")

    def quantity(self, name: str) -> str:
        """Quantity of its unit; empty: it names no unit."""
        unit = self.column(name).unit
        return "" if unit is None else UNITS[unit][0]

    def factor(self, name: str) -> float:
        """Factor from the unit of a column to SI units."""
        unit = self.column(name).unit
        return 1.0 if unit is None else UNITS[unit][1]

    def numbers(self, name: str) -> np.ndarray:
        """Values of a column in SI units. @raises PlanError  no such column, or a value that is no finite number"""
        return self.factor(name) * super().numbers(name)
