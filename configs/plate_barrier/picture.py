#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw scene.png: soil and plate from the side, the plate from uphill, forces over time.

    picture.py RESULTS [OUT]       such as: picture.py results/plate_barrier
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from plotting.contact import contact_series  # noqa: E402
from plotting.results import Frame, Results, Table  # noqa: E402
from plotting.style import COLOURS, STRUCTURE, plt, save  # noqa: E402

INSTANT = 0.365  # [s] of the largest displacement
SCALE = 5  # of the plate's displacement, from the side


def draw_side(axes, results: Results, start: Frame, surface: Frame) -> None:
    """Soil, and the plate with its displacement since the start enlarged."""
    soil = results.soil.frame(results.soil.nearest(INSTANT))
    axes.scatter(soil.points[:, 0], soil.points[:, 2], s=30, color=COLOURS[5], edgecolors="none", label="soil")
    plate = start.points + SCALE * (surface.points - start.points)
    axes.add_collection(PolyCollection(plate[surface.cells][:, :, [0, 2]], facecolors="none", edgecolors=STRUCTURE,
                                       linewidths=0.7))
    axes.set(title=f"t = {INSTANT:g} s, bend of the plate {SCALE} times", xlabel="x [m]", ylabel="z [m]",
             xlim=(-0.1, 1.3), ylim=(-0.02, 0.55), aspect="equal")


def draw_front(figure, axes, start: Frame, surface: Frame) -> None:
    """Displacement of the plate downhill, mean of each facet."""
    downhill = 1e3 * (surface.points - start.points)[surface.cells].mean(axis=1)[:, 0]
    drawn = PolyCollection(start.points[start.cells][:, :, [1, 2]], array=downhill, edgecolors="white", linewidths=0.5)
    axes.add_collection(drawn)
    axes.vlines([0.2, 0.6], 0, 0.5, color="white", linestyle="--")
    figure.colorbar(drawn, ax=axes, label="downhill [mm]", shrink=0.7)
    axes.set(title="the plate, posts dashed", xlabel="y [m]", ylabel="z [m]", xlim=(0, 0.8), ylim=(0, 0.5),
             aspect="equal")


def draw_forces(axes, results: Results) -> None:
    """Draw the forces of the soil on the plate, and of the posts on their feet."""
    steps = results.table("steps.csv")
    axes.plot(steps["time"], 1e-3 * steps["fx"], color=COLOURS[0], label="soil on the plate")
    feet = Table(results.folder / "structure" / "reactions.csv")
    for k, node in enumerate(np.unique(feet["node"])):
        of_node = feet["node"] == node
        axes.plot(feet["time"][of_node], -1e-3 * feet["fx"][of_node], color=COLOURS[1 + k],
                  linestyle=("-", "--")[k % 2],
                  label=f"post {k + 1} on its foot")
    axes.set(title="forces downhill", xlabel="time [s]", ylabel="[kN]", xlim=(0.32, float(steps["time"][-1])))
    axes.set_ylim(top=1.5e-3 * steps["fx"].max())
    axes.legend(loc="upper right")


def main() -> None:
    results = Results(Path(sys.argv[1]))
    series = contact_series(results)["plate"]
    start, surface = series.frame(0), series.frame(series.nearest(INSTANT))
    figure, axes = plt.subplot_mosaic([["side", "side"], ["front", "forces"]], figsize=(10, 7.5))
    draw_side(axes["side"], results, start, surface)
    draw_front(figure, axes["front"], start, surface)
    draw_forces(axes["forces"], results)
    out = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).resolve().parent
    print(save(figure, out / "scene.png"))


if __name__ == "__main__":
    main()
