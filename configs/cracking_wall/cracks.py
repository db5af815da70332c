#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw cracks.png into a results folder of this scene: crack widths and steel stresses at three instants."""

import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import LineCollection, PolyCollection

INTERVAL = 0.1  # of the frames [s]
TIMES = (1.8, 2.2, 4.0)
SCALE = 20  # of the displacements


def frame(folder: Path, series: str, time: float) -> h5py.File:
    return h5py.File(folder / "fem" / f"{series}_{round(time / INTERVAL):06d}.h5")


def draw(axes: plt.Axes, folder: Path, time: float) -> tuple:
    with frame(folder, "structure", time) as file:
        shift = (SCALE - 1) * file["point/displacement"][:, :2]
        places = file["coordinates"][:, :2] + shift
        cells = file["connectivity"][:]
        widths = 1e3 * file["cell/crack_width"][:]
    style = {"cmap": "Greys", "edgecolors": "0.8", "linewidths": 0.3, "clim": (0, 0.5)}
    concrete = PolyCollection(places[cells], array=widths, **style)
    axes.add_collection(concrete)
    with frame(folder, "lines", time) as file:
        ends = file["coordinates"][:, :2]
        lines = file["connectivity"][:]
        stresses = 1e-6 * file["cell/axial_stress"][:]
    # Ends of lines are nodes of cells: the nearest one has their displacement.
    undrawn = places - shift
    nearest = np.array([np.argmin(((undrawn - end) ** 2).sum(1)) for end in ends])
    steel = LineCollection(places[nearest][lines], array=stresses, cmap="coolwarm", linewidths=2.5, clim=(-400, 400))
    axes.add_collection(steel)
    axes.set(title=f"{time:g} s", aspect="equal", xlim=(15.4, 17.1), ylim=(-0.55, 2.6))
    return concrete, steel


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/cracking_wall")
    figure, axes = plt.subplots(1, len(TIMES), figsize=(11, 6.2), sharey=True, layout="constrained")
    for place, time in zip(axes, TIMES):
        concrete, steel = draw(place, folder, time)
    figure.colorbar(concrete, ax=axes, label="crack width [mm]", shrink=0.8)
    figure.colorbar(steel, ax=axes, label="stress of the steel [MPa]", shrink=0.8)
    figure.suptitle(f"displacements times {SCALE}")
    figure.savefig(folder / "cracks.png", dpi=90)


if __name__ == "__main__":
    main()
