# SPDX-License-Identifier: BSD-3-Clause
"""The slide on terrain against walls of half a cell to two cells, on three grids: force, impulse, what comes over."""

import numpy as np

from studies.balances import arrival, soil, times
from studies.measures import Measured
from studies.runner import ROOT, Runner
from terrain_scene.plan import read_plan
from terrain_scene.scene import make, write_scene

PLAN = ROOT / "configs" / "slide_on_terrain" / "plan.json"
CELLS = (1.5, 1.25, 1.0)  # [m]
THICKNESSES = (0.5, 1, 2)  # of the wall, in cells
DT = 0.04  # [s] of a step on cells of 1 m
LAST = 0.2  # share of a run that its end is the mean of
OVER, ROUND = ("crest_1", "crest_2"), ("end_1", "end_2")
HEAD = ["cell [m]", "wall [cells]", "wall [m]", "points", "soil [t]", "soil arrives [s]", "force: largest [MN]",
        "end [MN]", "impulse [MN s]", "over the crest [t]", "momentum along x [kN s]", "at [m/s]", "round the ends [t]",
        "cuts", "CPU time [s]"]


def gauges() -> list[dict]:
    """Upright planes through the middle of the wall, which soil only crosses above it, and on from its ends."""
    plan = read_plan(PLAN)
    corners, height = plan.barrier.line, plan.barrier.height + plan.clear_height
    south, north = plan.low[1], plan.high[1]
    ends = [corners[0], [corners[0][0], south]], [corners[-1], [corners[-1][0], north]]
    lines = {OVER[0]: corners[0:2], OVER[1]: corners[1:3], ROUND[0]: ends[0][::-1], ROUND[1]: ends[1]}
    return [{"name": name, "line": np.asarray(line).tolist(), "height": height} for name, line in lines.items()]


def write(runner: Runner, cell: float, thickness: float) -> str:
    """Write the scene with that wall [cells]; returns its folder."""
    folder = runner.folder / "scenes" / f"cell_{cell:g}_wall_{thickness:g}"
    folder.mkdir(parents=True, exist_ok=True)
    changes = {"cell_size": cell, "barrier": {"thickness": thickness * cell}, "gauges": gauges(),
               "time": {"dt": DT * cell}}
    write_scene(make(read_plan(PLAN, changes)), folder)
    return str(folder)


def passed(run: Measured, names: tuple[str, str], what: str) -> float:
    """Sum over gauges at the end."""
    return float(sum(soil(run, f"{name}.passed_{what}")[-1] for name in names))


def row(run: Measured, cell: float, thickness: float) -> list:
    force, start = run.force(), arrival(run)
    mass, momentum = passed(run, OVER, "mass"), passed(run, OVER, "momentum_x")
    solver = run.summary["participants"]["soil"]
    return [cell, thickness, cell * thickness, solver["points"], 1e-3 * float(soil(run, "mass")[0]),
            float(times(run)[start]), 1e-6 * float(force.values.max()),
            1e-6 * force.mean_of_last(LAST * float(force.time[-1])), 1e-6 * float(run.impulse().values[-1]),
            1e-3 * mass, 1e-3 * momentum, momentum / mass if mass else 0.0, 1e-3 * passed(run, ROUND, "mass"),
            run.cuts(), run.solver_seconds()]


def thin_walls(runner: Runner) -> None:
    """slide_on_terrain with walls of 0.5, 1 and 2 cells on three grids: force, impulse, mass and momentum over them."""
    cases = [(cell, thickness) for cell in CELLS for thickness in THICKNESSES]
    runs = runner.run_all([(f"cell_{cell:g}_wall_{thickness:g}", write(runner, cell, thickness), [])
                           for cell, thickness in cases])
    runner.report(HEAD, [row(run, *case) for run, case in zip(runs, cases)])


STUDIES = {thin_walls.__name__: thin_walls}
