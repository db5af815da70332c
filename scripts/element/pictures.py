# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of element tests: stress path and curves."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from element.curves import LENGTH, QUANTITIES, STRAIN, STRESS, LabTable
from element.laboratory import COMPRESSION_TESTS, SHEAR_TESTS, TIME_TESTS
from plotting.style import COLOURS, plt, save


@dataclass
class Drawn:
    """Curves of one test, with those of the laboratory if there are any."""

    label: str
    curves: dict[str, np.ndarray]
    measured: LabTable | None = None


def panels_of(test: str, undrained: bool) -> list[tuple[str, str]]:
    """Quantities of the abscissa and ordinate of each panel."""
    if test in COMPRESSION_TESTS:
        return [("eps_v", "sigma_a"), ("p", "q"), ("sigma_a", "sigma_r")]
    if test in TIME_TESTS:
        return [("t", "eps_a"), ("p", "q"), ("t", "q")]
    last = "u" if undrained else "eps_v"
    if test in SHEAR_TESTS:
        along = "slip" if test == "direct_shear" else "gamma"
        return [(along, "tau"), ("sigma_a", "tau"), (along, last)]
    return [("eps_a", "q"), ("p", "q"), ("eps_a", last)]


def draw(path: Path, title: str, panels: list[tuple[str, str]], drawn: list[Drawn]) -> Path:
    """One panel beside the other, a colour a test; measured values as dots."""
    figure, axes = plt.subplots(1, len(panels), figsize=(4.4 * len(panels), 3.8), squeeze=False)
    for place, (x, y) in zip(axes[0], panels):
        for test, colour in zip(drawn, [COLOURS[k % len(COLOURS)] for k in range(len(drawn))]):
            if x in test.curves and y in test.curves:
                place.plot(_shown(x, test.curves[x]), _shown(y, test.curves[y]), color=colour, label=test.label)
            if test.measured and x in test.measured.columns and y in test.measured.columns:
                columns = test.measured.columns
                place.plot(_shown(x, columns[x]), _shown(y, columns[y]), "o", ms=3, mfc="none", color=colour)
        place.set_xlabel(_name(x))
        place.set_ylabel(_name(y))
    axes[0][0].legend(loc="best", fontsize=9)
    figure.suptitle(title, fontsize=12)
    return save(figure, path)


def _shown(quantity: str, values: np.ndarray) -> np.ndarray:
    units = QUANTITIES[quantity][0]
    return values / (0.01 if units is STRAIN else 1e3 if units is STRESS else 1e-3 if units is LENGTH else 1)


def _name(quantity: str) -> str:
    units, words = QUANTITIES[quantity]
    unit = "%" if units is STRAIN else "kPa" if units is STRESS else "mm" if units is LENGTH else "s"
    return f"{words} [{unit}]"
