# SPDX-License-Identifier: BSD-3-Clause
"""Momentum and energy of a coupled run from its tables. SI units; in the plane per metre."""

import numpy as np

from plotting.results import ResultsError
from studies.measures import Curve, Measured

Row = list  # check with its unit, expected, found


def soil(run: Measured, column: str) -> np.ndarray:
    """A column of the soil in probes.csv: time 0 and each step."""
    return run.table("probes.csv")[f"soil.{column}"]


def times(run: Measured) -> np.ndarray:
    """Times of the rows of probes.csv [s]."""
    return run.table("probes.csv")["time"]


def arrival(run: Measured) -> int:
    """Row of probes.csv before the first step in which soil pushes on a structure."""
    pushed = np.flatnonzero(run.force().values)
    if not len(pushed):
        raise ResultsError(f"{run.results.folder}: the soil never reaches the structure")
    return int(pushed[0])


def impulse(force: np.ndarray, run: Measured, first: int, last: int) -> float:
    """Impulse of a force from row `first` to row `last` of probes.csv [N s]. @param force of each step, mean
    of the step"""
    return float(np.sum((force * run.table("steps.csv")["dt"])[first:last]))


def force_on_wall(run: Measured, wall: str, axis: str = "x") -> np.ndarray:
    """Force of the soil on a rigid wall in each step [N]."""
    return soil(run, f"{wall}.f{axis}")[1:]


def mean_acceleration(run: Measured, last: int) -> float:
    """Mean acceleration of the soil along x from the start to a row of probes.csv [m/s^2]."""
    return float((soil(run, "momentum_x")[last] - soil(run, "momentum_x")[0]) / soil(run, "mass")[0] / times(run)[last])


def acceleration_by_force(run: Measured, wall: str, along: float, last: int) -> float:
    """Mean acceleration by gravity and the force of a rigid wall. @param along  gravity along x [m/s^2]"""
    taken = impulse(force_on_wall(run, wall), run, 0, last)
    return along - taken / float(soil(run, "mass")[0] * times(run)[last])


def front_speed(run: Measured, last: int, duration: float) -> float:
    """Mean speed of the largest x of the soil [m/s] in the time before a row of probes.csv."""
    front = Curve(times(run), soil(run, "front"))
    end = float(front.time[last])
    return float((front.at(end) - front.at(end - duration)) / duration)


def last_kept(run: Measured) -> int:
    """Last row of probes.csv before soil leaves the grid."""
    table = run.table("probes.csv")
    if "soil.removed_mass" not in table:
        return table.num_rows - 1
    return int(np.flatnonzero(table["soil.removed_mass"] == 0)[-1])


def ledger_rows(run: Measured, unit: float, name: str) -> list[Row]:
    """The energy and momentum balance of the soil at the end, and before some of it leaves the grid.

    @param unit  of energy [J]; name: of that unit
    """
    end, kept = len(times(run)) - 1, last_kept(run)
    given, most = soil(run, "gravity_work")[-1] / unit, np.abs(soil(run, "momentum_x")).max()

    def balances(row: int, words: str) -> list[Row]:
        return [[f"`energy_balance` [{name}]{words}, gravity gives {given:.4g} in all", 0,
                 float(soil(run, "energy_balance")[row]) / unit],
                [f"`momentum_error_x` [kg m/s]{words}, momentum {most:.4g} at most", 0,
                 float(soil(run, "momentum_error_x")[row])]]

    made = [[f"`{column}` [{name}]", 0, float(soil(run, column)[-1]) / unit]
            for column in ("created_energy", "contact_created")]
    if kept == end:
        return [*balances(end, ""), *made]
    left = 1e-3 * float(soil(run, "removed_mass")[-1])
    return [*balances(kept, f" to {times(run)[kept]:.4g} s"), *balances(end, f", {left:.3g} t left the grid"), *made]
