#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw scene.png: the slide from above with and without pore pressure, and the force of each on the barrier.

    picture.py UNDRAINED DRY     folders of results

Prints the numbers of the README's table.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from plotting.results import Results  # noqa: E402
from plotting.style import plt, save  # noqa: E402

INSTANTS = (2.0, 3.0, 4.0, 6.0)  # [s]
LINE = np.array([[49.0, 7.0], [52.0, 20.0], [50.0, 33.0]])  # of the barrier, from above [m]
THICKNESS = 2.0  # [m]
HIGHEST = 15.0  # of the speeds that are told apart [m/s]


def is_beyond(points: np.ndarray) -> np.ndarray:
    """Whether points lie behind the barrier: beyond its line between its ends, or past the ends."""
    x, y = points[:, 0], points[:, 1]
    return x > np.interp(y, LINE[:, 1], LINE[:, 0]) + 0.5 * THICKNESS


def describe(name: str, results: Results) -> None:
    """Print the column of the table."""
    steps, soil = results.table("steps.csv"), results.frames_of_soil()
    time, force = steps["time"], np.hypot(steps["fx"], steps["fy"]) / 1e6
    frame = soil.frame(len(soil) - 1)
    mass = frame.fields["mass"] if "mass" in frame.fields else np.ones(len(frame.points))
    crest = results.table("probes.csv")
    moved = np.sqrt(sum(crest[f"structure.crest.u{c}"] ** 2 for c in "xyz")).max()
    touching = steps["iterations"][force > 0]
    print(f"{name}: arrives {time[np.argmax(force > 0)]:.2f} s, "
          f"peak {force.max():.2f} MN at {time[force.argmax()]:.2f} s, "
          f"at the end {force[time > time[-1] - 0.5].mean():.2f} MN, impulse {np.sum(force * steps['dt']):.2f} MN s, "
          f"beyond {100 * np.sum(mass[is_beyond(frame.points)]) / np.sum(mass):.1f} % of what is left in the area, "
          f"crest {1e3 * moved:.2f} mm, {steps.num_rows} steps, {touching.mean():.2f} iterations, at most "
          f"{touching.max():.0f}")


def draw(runs: dict[str, Results], out: Path) -> None:
    """The slide at some instants, coloured by speed, above the forces over time."""
    figure = plt.figure(figsize=(11, 6), layout="constrained")
    grid = figure.add_gridspec(3, len(INSTANTS), height_ratios=(1, 1, 1.2))
    for row, (name, results) in enumerate(runs.items()):
        soil = results.frames_of_soil()
        for column, time in enumerate(INSTANTS):
            axes = figure.add_subplot(grid[row, column])
            frame = soil.frame(soil.nearest(time))
            speed = np.linalg.norm(frame.fields["velocity"], axis=1)
            order = np.argsort(frame.points[:, 2])
            drawn = axes.scatter(*frame.points[order, :2].T, c=speed[order], s=1, vmin=0, vmax=HIGHEST, cmap="viridis")
            axes.plot(*LINE.T, color="black", linewidth=3)
            axes.set(xlim=(0, 86), ylim=(0, 40), aspect="equal")
            axes.set_title(f"{name}, {time:g} s" if column == 0 else f"{time:g} s")
            axes.label_outer()
    figure.colorbar(drawn, ax=figure.axes, label="speed [m/s]", extend="max", shrink=0.6)
    axes = figure.add_subplot(grid[2, :])
    for name, results in runs.items():
        steps = results.table("steps.csv")
        axes.plot(steps["time"], np.hypot(steps["fx"], steps["fy"]) / 1e6, label=name)
    axes.set(xlabel="t [s]", ylabel="force on the barrier [MN]", ylim=(0, None))
    axes.legend(frameon=False)
    save(figure, out)


def main() -> None:
    runs = {name: Results(Path(folder)) for name, folder in zip(("undrained", "dry"), sys.argv[1:])}
    for name, results in runs.items():
        describe(name, results)
    draw(runs, Path(__file__).resolve().parent / "scene.png")


if __name__ == "__main__":
    main()
