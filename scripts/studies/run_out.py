# SPDX-License-Identifier: BSD-3-Clause
"""Run-out and height of columns of sand over their slenderness, against power laws of experiments."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from plotting.column import area_under, front_of, surface_of
from plotting.style import COLOURS, legend_beside, new_figure
from studies.columns import box, setting
from studies.measures import Measured
from studies.runner import Runner

SCENE = "column_run_out"
RATIOS = [0.5, 1.0, 2.0, 5.0]  # a = height by width
WIDTH, CELL = 0.1, 0.005  # [m]
GRAVITY = 9.81  # [m/s^2]
BAND = 0.15  # scatter of grains and channels that the laws leave


def run_out_law(a: float) -> float:
    """(L - L0) / L0 of Lube et al. (2005), who give the first branch to a = 1.8, the second from 2.8 on."""
    return 1.2 * a if a < 1.8 else 1.9 * a ** (2 / 3)


def height_law(a: float) -> float:
    """H / L0 of Lube et al. (2005)."""
    return a if a < 1.15 else a**0.4


def of_ratio(a: float) -> list[str]:
    """Settings of a column a times as high as wide; it is at rest after some 5 sqrt(H / g)."""
    height = a * WIDTH
    reach = WIDTH * np.ceil(2 + 1.5 * run_out_law(a))
    end = round(5.5 * np.sqrt(height / GRAVITY), 2)
    return [
        setting("grid", box(reach, height + 2 * CELL, CELL, "quad4")),
        setting("bodies/0/mesh", box(WIDTH, height, CELL, "quad4")),
        setting("time/end", end),
    ]


@dataclass
class Deposit:
    """Deposit of a column, by its initial width L0."""

    run_out: float  #: (L - L0) / L0
    height: float  #: H / L0 at the wall
    area: float  #: under the surface, by that of the column
    x: np.ndarray  #: surface
    surface: np.ndarray


def deposit_of(run: Measured, a: float) -> Deposit:
    soil = run.results.frames_of_soil()
    start, last = soil.frame(0), soil.frame(len(soil) - 1)
    spacing = float(np.sqrt(np.prod(np.ptp(start.points[:, :2], axis=0)) / len(start.points)))
    x, height = surface_of(last.points, spacing)
    return Deposit(front_of(last.points, spacing) / WIDTH - 1, float(height[0]) / WIDTH,
                   area_under(x, height) / (a * WIDTH**2), x / WIDTH, height / WIDTH)


def run_out(runner: Runner) -> None:
    """Columns of sand of four slendernesses: run-out and height against the laws of Lube et al. (2005)."""
    rows, deposits = [], {}
    for a in RATIOS:
        run = runner.run(f"a_{a:g}", SCENE, of_ratio(a))
        deposit = deposits[a] = deposit_of(run, a)
        rows.append([a, deposit.run_out, run_out_law(a), deposit.run_out / run_out_law(a) - 1,
                     deposit.height, height_law(a), deposit.height / height_law(a) - 1,
                     deposit.area, run.newton_per_step(), run.cpu_seconds()])
    head = ["a", "run-out", "law", "error", "height", "law", "error", "area kept", "Newton a step", "CPU [s]"]
    runner.report(head, rows)
    draw_laws(runner, np.array(rows))
    figure, (axes,) = new_figure(9, 2.2)
    draw_deposits(axes, {a: (deposit.x, deposit.surface) for a, deposit in deposits.items()})
    axes.set_xlabel("x by initial width")
    axes.set_ylabel("height by initial width")
    runner.save(figure, "deposits.png")


def draw_deposits(axes: Axes, surfaces: dict[float, tuple[np.ndarray, np.ndarray]]) -> None:
    """surfaces: places and heights by slenderness."""
    for a, surface in surfaces.items():
        axes.plot(*surface, label=f"a = {a:g}")
    axes.set_aspect("equal")
    legend_beside(axes)


def draw_law(axes: Axes, a: np.ndarray, values: np.ndarray, band: float, label: str | None) -> None:
    """A law and the band around it that simulations should lie in."""
    axes.fill_between(a, (1 - band) * values, (1 + band) * values, color=COLOURS[0], alpha=0.2)
    axes.loglog(a, values, color=COLOURS[0], label=label)


def draw_laws(runner: Runner, rows: np.ndarray) -> None:
    figure, panels = new_figure(8, 7, 2)
    a = np.geomspace(0.4, 7, 200)
    for axes, law, column, name in ((panels[0], run_out_law, 1, "run-out by initial width"),
                                    (panels[1], height_law, 4, "height by initial width")):
        # A break in the curve where the branches meet: the laws jump there.
        for branch in np.split(a, np.flatnonzero(np.abs(np.diff([law(value) for value in a])) > 0.09) + 1):
            values = np.array([law(value) for value in branch])
            draw_law(axes, branch, values, BAND, "Lube et al. (2005)" if branch[0] == a[0] else None)
        axes.loglog(rows[:, 0], rows[:, column], "o", color=COLOURS[1], label="simulated")
        axes.set_ylabel(name)
        legend_beside(axes)
    panels[-1].set_xlabel("a = initial height by width")
    runner.save(figure, "run_out.png")


STUDIES = {run_out.__name__: run_out}
