# SPDX-License-Identifier: BSD-3-Clause
"""The boulders of a run: their surfaces, and curves of height, speed, spin, energy and force of the soil over time."""

from pathlib import Path

import numpy as np

from plotting.contact import chain
from plotting.results import Results, Series, Table
from plotting.style import COLOURS, legend_beside, new_figure, save

TURN = ".qw"  # a column that boulders alone have
AXES = "xyz"
MOST_NAMED = 12  # more boulders have no legend


class Boulders:
    """Positions of the surfaces of the boulders."""

    def __init__(self, results: Results):
        series, names = results.contacts, results.boulders
        self._series: list[Series] = [series[name] for name in names]
        self._plane = results.dim == 2

    def at(self, time: float) -> list[np.ndarray]:
        """Faces of each boulder at `time`, num_faces x num_corners x 3 [m]; in 2D one, its outline."""
        found = []
        for series in self._series:
            frame = series.frame(series.nearest(time))
            cells = frame.cells
            found.append(frame.points[cells[chain(cells)][:, 0]][None] if self._plane else frame.points[cells])
        return found


def boulder_names(table: Table) -> list[str]:
    """Boulders that probes.csv has columns of, such as "soil.block"."""
    return [name.removesuffix(TURN) for name in table.names if name.endswith(TURN)]


def _size(table: Table, boulder: str, part: str) -> np.ndarray:
    """Length of a vector such as part "v", of what components there are."""
    names = [f"{boulder}.{part}{axis}" for axis in AXES]
    return np.sqrt(sum(table[name] ** 2 for name in names if name in table))


def _height(table: Table, boulder: str) -> np.ndarray:
    return table[[name for axis in AXES if (name := f"{boulder}.{axis}") in table][-1]]


def plot_boulders(results: Results, out: Path) -> Path | None:
    """Figure of all boulders: a panel a quantity, a colour a boulder."""
    table = results.table("probes.csv")
    boulders = boulder_names(table) if table else []
    if not boulders:
        return None
    panels = {
        "height [m]": _height,
        "speed [m/s]": lambda *of: _size(*of, "v"),
        "spin [rad/s]": lambda *of: _size(*of, "w"),
        f"kinetic energy\n[J{results.per_metre}]": lambda of, name: of[f"{name}.kinetic_energy"],
        f"force of the soil\n[N{results.per_metre}]": lambda *of: _size(*of, "f"),
    }
    figure, axes = new_figure(9.5, 2.2 * len(panels), len(panels))
    for each, (label, values) in zip(axes, panels.items()):
        for k, boulder in enumerate(boulders):
            each.plot(table["time"], values(table, boulder), color=COLOURS[k % len(COLOURS)], lw=1.1,
                      label=boulder.rpartition(".")[2].replace("_", " "))
        each.set_ylabel(label)
        if len(boulders) <= MOST_NAMED:
            legend_beside(each)
    axes[-1].set_xlabel("time [s]")
    return save(figure, out / "boulders.png")
