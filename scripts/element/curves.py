# SPDX-License-Identifier: BSD-3-Clause
"""Curves that a laboratory plots, from the table of element_test and from tables of a laboratory.

Compression is positive. Curves begin at the end of consolidation, the excess of pore pressure at zero there.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from element.laboratory import CONSOLIDATION, ElementError
from plotting.results import Table
from sampling.measured_csv import MeasuredCsv

STRAIN, STRESS, TIME, LENGTH = ({"-": 1.0, "%": 0.01}, {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
                                {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}, {"m": 1.0, "mm": 1e-3})
#: quantity -> its units, what it is
QUANTITIES: dict[str, tuple[dict[str, float], str]] = {
    "eps_a": (STRAIN, "axial strain"),
    "eps_r": (STRAIN, "radial strain"),
    "eps_v": (STRAIN, "volume strain"),
    "gamma": (STRAIN, "angle of shear"),
    "slip": (LENGTH, "slip of the band"),
    "q": (STRESS, "deviator q"),
    "tau": (STRESS, "shear stress"),
    "p": (STRESS, "mean effective stress p"),
    "sigma_a": (STRESS, "axial effective stress"),
    "sigma_r": (STRESS, "radial effective stress"),
    "u": (STRESS, "excess of pore pressure"),
    "t": (TIME, "time"),
}


def curves_of(table: Table, band_width: float | None = None) -> dict[str, np.ndarray]:
    """Quantity -> values from the end of consolidation on."""
    stages = list(table["stage"])
    first = max((k + 1 for k, stage in enumerate(stages) if stage == CONSOLIDATION), default=0)
    if first == len(stages):
        raise ElementError(f"{table.path}: found no row after {CONSOLIDATION}")
    cut = {name: table[name][first:] for name in table.names if table[name].dtype.kind == "f"}
    pressure = cut["pore_pressure"]
    curves = {
        "eps_a": cut["strain_yy"], "eps_r": cut["strain_xx"], "eps_v": cut["volume_strain"], "gamma": cut["strain_xy"],
        "q": cut["deviator"], "tau": cut["stress_xy"], "p": cut["p"],
        "sigma_a": cut["stress_yy"] - pressure, "sigma_r": cut["stress_xx"] - pressure,
        "u": pressure - pressure[0], "t": cut["time"] - cut["time"][0],
    }
    if band_width is not None:
        curves["slip"] = band_width * curves["gamma"]
    return curves


def friction_angle_of(table: Table) -> np.ndarray:
    """Mobilised angle of friction, as if there were no cohesion, of each row [deg]; NaN where the soil is pulled or
    free of stress."""
    u = table["pore_pressure"]
    stress = np.zeros((table.num_rows, 3, 3))
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)):
        stress[:, i, j] = stress[:, j, i] = table[f"stress_{'xyz'[i]}{'xyz'[j]}"] * (1 if i == j else -1) - u * (i == j)
    principal = np.linalg.eigvalsh(stress)
    low, high = principal[:, 0], principal[:, 2]
    squeezed = low > 1e-9 * np.max(np.abs(principal))
    sine = np.divide(high - low, high + low, out=np.full(len(low), np.nan), where=squeezed)
    return np.degrees(np.arcsin(sine))


@dataclass(frozen=True)
class LabTable:
    """Curves of a laboratory, in SI units."""

    path: Path
    columns: dict[str, np.ndarray]


def read_laboratory(path: Path) -> LabTable:
    """A CSV whose head names quantity and unit, such as eps_a[%],q[kPa]; see MeasuredCsv.

    @raises ElementError  an unknown quantity or unit, no number, fewer than three rows, a row of another length
    """
    table = MeasuredCsv(path, ElementError, str(path), min_rows=3)
    return LabTable(path, {name: _factor(path, name, unit) * table.numbers(name)
                           for name, (_, unit) in table.columns.items()})


def _factor(path: Path, name: str, unit: str | None) -> float:
    """The unit of a quantity in SI units."""
    if unit is None or name not in QUANTITIES:
        head = name if unit is None else f"{name}[{unit}]"
        raise ElementError(f"{path}: found the column {head!r}, allowed: NAME[UNIT] with one of "
                           f"{', '.join(QUANTITIES)}; compression is positive")
    units = QUANTITIES[name][0]
    if unit not in units:
        raise ElementError(f"{path}: found the unit {unit!r} of {name}, allowed: {', '.join(units)}")
    return units[unit]
