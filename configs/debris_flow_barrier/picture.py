#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw scene.png and force.png: the slide with and without pore pressure, and the force of each on the barrier.

    picture.py UNDRAINED DRAINED [BETWEEN]     folders of results, such as results/debris_flow_barrier

Prints what the README has in its table.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from plotting.results import Results  # noqa: E402
from plotting.style import plt, save  # noqa: E402

FACE, BACK, HEIGHT = 14.0, 14.3, 2.0  # of the barrier [m]
INSTANTS = (1.0, 2.0, 3.0, 5.0)  # [s]


def shares_of_water(results: Results) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the part of the water in the total stress across the barrier at the points in contact with it.

    A point is in contact within three quarters of its side. NaN: no point pushes.
    """
    soil, shares = results.frames_of_soil(), []
    for k in range(len(soil)):
        frame = soil.frame(k)
        x, y = frame.points[:, :2].T
        side = np.sqrt(frame.fields["volume"])
        near = (x < FACE) & (x > FACE - 0.75 * side) & (y < HEIGHT)
        total = -np.sum(frame.fields["stress"][near, 0] * side[near])
        pore = frame.fields.get("pore_pressure", np.zeros(len(x)))
        shares.append(np.sum(pore[near] * side[near]) / total if total > 0 else np.nan)
    return soil.times, np.array(shares)


def describe(name: str, results: Results) -> None:
    """Print the row of the table."""
    steps, soil = results.table("steps.csv"), results.frames_of_soil()
    time, force = steps["time"], steps["fx"] / 1e3
    peak = np.argmax(force)
    first, last = soil.frame(0), soil.frame(len(soil) - 1)
    over = 1 - np.sum(last.points[:, 0] <= BACK) / len(first.points)
    times, shares = shares_of_water(results)
    pushing = np.isfinite(shares)
    weights = np.interp(times, time, force)[pushing]
    share = np.sum(weights * shares[pushing]) / np.sum(weights)
    crest = np.abs(results.table("probes.csv")["structure.crest.ux"]).max()
    print(f"{name}: arrives {time[np.argmax(force > 0)]:.2f} s, peak {force[peak]:.1f} kN/m at {time[peak]:.2f} s, "
          f"{abs(steps['barrier.mz'][peak] / steps['fx'][peak]):.2f} m above the bed, "
          f"mean of the last 0.5 s {force[time > time[-1] - 0.5].mean():.1f}, "
          f"impulse {np.sum(force * steps['dt']):.1f} kN s/m, over {100 * over:.0f} %, part of the water {share:.3f}, "
          f"crest {1e3 * crest:.2f} mm, {steps.num_rows} steps, {np.mean(steps['iterations']):.2f} iterations")


def draw_scene(wet: Results, dry: Results, out: Path) -> None:
    """The slide at some instants, coloured by pore pressure on the left."""
    figure, panels = plt.subplots(len(INSTANTS), 2, sharex=True, sharey=True, figsize=(11, 6.2), layout="constrained")
    figure.get_layout_engine().set(rect=(0.02, 0, 0.98, 1))  # labels at the left are cut off without it
    for row, time in zip(panels, INSTANTS):
        for axes, results in zip(row, (wet, dry)):
            soil = results.frames_of_soil()
            frame = soil.frame(soil.nearest(time))
            x, y = frame.points[:, :2].T
            if results is wet:
                drawn = axes.scatter(x, y, c=frame.fields["pore_pressure"] / 1e3, s=3, cmap="viridis", vmin=0, vmax=40)
            else:
                axes.scatter(x, y, color="tab:brown", s=3)
            axes.add_patch(plt.Rectangle((FACE, 0), BACK - FACE, HEIGHT, color="black"))
            axes.set(xlim=(0, 26), ylim=(0, 5), aspect="equal")
            axes.text(0.3, 4.1, f"{time:g} s")
        row[0].set_ylabel("y [m]")
    panels[0][0].set_title("undrained")
    panels[0][1].set_title("drained")
    for axes in panels[-1]:
        axes.set_xlabel("x down the slope [m]")
    figure.colorbar(drawn, ax=panels, label="pore pressure [kPa]", extend="max")
    save(figure, out)


def draw_forces(runs: dict[str, Results], out: Path) -> None:
    """Forces over time, means over 0.05 s."""
    figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
    for name, results in runs.items():
        steps = results.table("steps.csv")
        bins = np.round(steps["time"] / 0.05).astype(int)
        weight = np.bincount(bins, steps["dt"])
        mean = np.bincount(bins, steps["fx"] * steps["dt"]) / np.where(weight > 0, weight, 1)
        axes.plot(0.05 * np.arange(len(mean)), mean / 1e3, label=name, linewidth=1.2)
    axes.axhline(0.5 * 2000 * 8.891 * HEIGHT**2 / 1e3, color="grey", linewidth=0.8, linestyle="--",
                 label="fluid at rest, as deep as the barrier is high")
    axes.set(xlabel="t [s]", ylabel="force on the barrier [kN/m]", ylim=(0, 220))
    axes.legend(frameon=False)
    save(figure, out)


def main() -> None:
    names = ("undrained", "drained", "permeability 1 mm/s")
    runs = {name: Results(Path(folder)) for name, folder in zip(names, sys.argv[1:])}
    here = Path(__file__).resolve().parent
    for name, results in runs.items():
        describe(name, results)
    draw_scene(runs["undrained"], runs["drained"], here / "scene.png")
    draw_forces(runs, here / "force.png")


if __name__ == "__main__":
    main()
