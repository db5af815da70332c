#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Force on the wall, its bending and its damage: draw.py RESULTS INTACT, with the results of this scene as it is and
with LARGEST_DAMAGE = 0. Writes damage.png."""

import csv
import sys
from pathlib import Path
from xml.etree import ElementTree

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

TIMES = (0.14, 0.5)  # of the walls [s]


def column(path: Path, name: str) -> np.ndarray:
    with path.open(encoding="utf-8") as file:
        return np.array([float(row[name]) for row in csv.DictReader(file)])


def frame(results: Path, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the cells in their present place [mm], cells x 4 x 2, and the mean damage of each."""
    index = ElementTree.parse(results / "structure" / "structure.pvd").getroot()
    files = [entry.get("file") for entry in index.iter("DataSet") if abs(float(entry.get("timestep")) - time) < 1e-9]
    name = files[0].replace("structure", "structure_p0_").replace(".pvtu", ".vtu")  # of a run on one rank
    piece = ElementTree.parse(results / "structure" / name)
    arrays = {item.get("Name") or "points": np.array(item.text.split(), dtype=float)
              for item in piece.iter("DataArray") if item.get("type") != "UInt8"}
    places = arrays["points"].reshape(-1, 3) + arrays["displacement"].reshape(-1, 3)
    cells = arrays["connectivity"].astype(int).reshape(len(arrays["damage"]), -1)[:, :4]
    return 1e3 * places[cells][:, :, :2], arrays["damage"]


def main() -> None:
    results, intact = Path(sys.argv[1]), Path(sys.argv[2])
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), width_ratios=(3, 3, 2), constrained_layout=True)
    for folder, label, line in ((intact, "intact", "0.6"), (results, "weakens", "C3")):
        steps, probes = folder / "steps.csv", folder / "probes.csv"
        axes[0].plot(column(steps, "time"), column(steps, "fx"), line, label=label, lw=0.9)
        axes[1].plot(column(probes, "time"), 1e3 * column(probes, "structure.A.ux"), line, label=label)
    for axis, text in zip(axes, ("horizontal force on the wall [N/m]", "displacement of A [mm]")):
        axis.set(xlabel="t [s]", title=text, xlim=(0.1, 0.5))
        axis.legend()
    for k, time in enumerate(TIMES):
        polygons, damage = frame(results, time)
        drawn = axes[2].add_collection(PolyCollection(polygons + (40 * k, 0), array=damage, cmap="inferno_r",
                                                      edgecolor="0.5", lw=0.3))
        drawn.set_clim(0, 0.6)
        axes[2].text(250 + 40 * k, -5, f"{time} s")
    axes[2].set(xlim=(245, 320), ylim=(-8, 55), xticks=[], yticks=[], aspect="equal", title="damage")
    figure.colorbar(drawn, ax=axes[2])
    figure.savefig(Path(__file__).parent / "damage.png", dpi=110)


if __name__ == "__main__":
    main()
