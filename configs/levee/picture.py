#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw scene.png: pore pressure in the levee before and after the river has risen.

    picture.py RESULTS [OUT]       such as: picture.py results/levee
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.tri import Triangulation

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from plotting.results import Results  # noqa: E402
from plotting.style import plt, save  # noqa: E402

INSTANTS = {32400: 1.0, 162000: 2.75}  # [s]: level of the river [m]
CREST, LAND = (7.5, 9.0), 1.0  # ends of the pools [m], level of the water behind the levee [m]


def inside(points: np.ndarray) -> Triangulation:
    """Triangles between neighbouring points, not those across the air beside the slopes."""
    triangles = Triangulation(points[:, 0], points[:, 1])
    corners = points[triangles.triangles][:, :, :2]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    triangles.set_mask(longest > 0.4)
    return triangles


def main() -> None:
    results = Results(Path(sys.argv[1]))
    out = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).with_name("scene.png")
    figure, panels = plt.subplots(2, 1, sharex=True, figsize=(9, 4.2), layout="constrained")
    for axes, (time, level) in zip(panels, INSTANTS.items()):
        frame = results.soil.frame(results.soil.nearest(time))
        pressure = frame.fields["pore_pressure"] / 1e3
        x, z = frame.points[:, :2].T
        drawn = axes.scatter(x, z, c=pressure, s=5, cmap="RdBu_r", vmin=-27, vmax=27)
        axes.tricontour(inside(frame.points), pressure, levels=[0], colors="black", linewidths=0.8)
        for ends, height in (((0, CREST[0]), level), ((CREST[1], 16), LAND)):
            axes.plot(ends, (height, height), color="tab:blue", linewidth=1.2, zorder=0)
        axes.set(title=f"river at {level:g} m, {time / 3600:g} h", ylabel="z [m]", aspect="equal", xlim=(0, 16),
                 ylim=(0, 3.1))
    panels[-1].set_xlabel("x [m]")
    figure.colorbar(drawn, ax=panels, label="pore pressure [kPa]")
    save(figure, out)


if __name__ == "__main__":
    main()
