# SPDX-License-Identifier: BSD-3-Clause
"""Run-out and height of cylinders of sand over their slenderness, against laws of experiments."""

import subprocess
from dataclasses import dataclass

import numpy as np

from plotting.column import front_of, surface_of
from plotting.results import ResultsError
from plotting.style import COLOURS, legend_beside, new_figure
from studies.columns import setting
from studies.measures import Measured
from studies.runner import ROOT, Runner

SCENE = "column_run_out_3d"
RATIOS = [0.5, 0.9, 1.5, 3.0]  # a = height by radius
EDGE, HALVES = 0.005, 20  # half a cell of the grid [m]; the radius in such halves
CELL = 2 * EDGE
GRAVITY = 9.81  # [m/s^2]
SECTORS = 9  # of the quarter, each with a front of its own
WANTED = 0.1  # largest error that is asked for


def run_out_law(a: float) -> float:
    """(R - R0) / R0 of Lube et al. (2004)."""
    return 1.24 * a if a < 1.7 else 1.6 * a**0.5


def height_law(a: float) -> float:
    """H / R0 of Lajeunesse et al. (2004)."""
    return min(a, 0.74)


def cone_law(a: float) -> float:
    """(R - R0) / R0 of a cone with the height of Lajeunesse et al. (2004) and the volume of the cylinder; they
    find cones for 0.74 < a < 3."""
    return (3 * a / height_law(a)) ** 0.5 - 1 if a > 0.74 else float("nan")


def volume_radius() -> float:
    """Of a cylinder with the volume of the cubes [m]."""
    middle = np.arange(HALVES) + 0.5
    inside = np.add.outer(middle**2, middle**2) < HALVES**2
    return EDGE * float(np.sqrt(4 * inside.sum() / np.pi))


def of_layers(layers: int, mesh: str) -> list[str]:
    """Settings of a cylinder of so many layers of cubes; it is at rest after some 5 sqrt(H / g)."""
    height = layers * EDGE
    a = height / volume_radius()
    cells = int(np.ceil((1 + 1.4 * run_out_law(a)) * HALVES / 2))
    high = int(np.ceil(layers / 2)) + 2
    grid = {"box": {"low": [0, 0, 0], "high": [cells * CELL, cells * CELL, high * CELL], "cells": [cells, cells, high],
                    "type": "hex8"}}
    return [setting("grid", grid), setting("bodies/0/mesh", {"file": mesh}),
            setting("time/end", round(5.5 * np.sqrt(height / GRAVITY), 2))]


@dataclass
class Deposit:
    """What is left of a cylinder, by its initial radius R0."""

    run_out: float  #: (R - R0) / R0, mean over the sectors
    spread: float  #: largest less smallest R over the sectors, by the mean
    height: float  #: H / R0, of the highest point
    volume: float  #: under the surface, by that of the cylinder
    r: np.ndarray  #: surface
    surface: np.ndarray


def fronts(x: np.ndarray, y: np.ndarray, spacing: float) -> np.ndarray:
    """Radius at which the connected deposit ends, in each sector of the quarter [m]."""
    r, sector = np.hypot(x, y), np.minimum(np.arctan2(y, x) / (0.5 * np.pi) * SECTORS, SECTORS - 1).astype(int)
    found = []
    for k in range(SECTORS):
        # Near the axis a sector is narrower than a point.
        of_sector = np.maximum(r[sector == k], volume_radius())
        found.append(front_of(np.column_stack([of_sector, of_sector]), spacing))
    return np.array(found)


def volume_under(r: np.ndarray, height: np.ndarray) -> float:
    """Below a surface of revolution, linear between its places and level inside of the first [m^3]."""
    low, high = r[:-1], r[1:]
    rings = np.pi / 3 * ((high - low) * (height[:-1] * (2 * low + high) + height[1:] * (low + 2 * high)))
    return float(rings.sum() + np.pi * r[0] ** 2 * height[0])


def deposit_of(run: Measured, a: float) -> Deposit:
    soil = run.results.soil
    if soil is None:
        raise ResultsError(f"{run.results.folder}: no mpm/soil.xdmf")
    x, y, z = soil.frame(len(soil) - 1).points.T
    radius = volume_radius()
    found = fronts(x, y, EDGE)
    r, surface = surface_of(np.column_stack([np.hypot(x, y), z]), EDGE)
    return Deposit(found.mean() / radius - 1, np.ptp(found) / found.mean(), (z.max() + 0.5 * EDGE) / radius,
                   volume_under(r, surface) / (np.pi * a * radius**3), r / radius, surface / radius)


def run_out_3d(runner: Runner) -> None:
    """Cylinders of sand of four slendernesses: run-out and height against Lube and Lajeunesse et al. (2004)."""
    rows, deposits = [], {}
    for ratio in RATIOS:
        layers = round(ratio * HALVES)
        mesh = (runner.folder / f"cylinder_{ratio:g}.msh").resolve()
        mesh.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run([ROOT / "configs" / SCENE / "make_cylinder", "--edge", str(EDGE), "--radius", str(HALVES),
                        "--layers", str(layers), mesh], check=True, capture_output=True)
        run = runner.run(f"a_{ratio:g}", SCENE, of_layers(layers, str(mesh)))
        a = layers * EDGE / volume_radius()
        deposit = deposits[ratio] = deposit_of(run, a)
        rows.append([ratio, run.summary["solver"]["points"], deposit.run_out, run_out_law(a),
                     deposit.run_out / run_out_law(a) - 1, cone_law(a), deposit.spread, deposit.height, height_law(a),
                     deposit.height / height_law(a) - 1, deposit.volume, run.newton_per_step(), run.cpu_seconds()])
    head = ["a", "points", "run-out", "law", "error", "cone", "spread", "height", "law", "error", "volume kept",
            "Newton a step", "CPU [s]"]
    runner.report(head, rows)
    met = sum(abs(row[4]) <= WANTED for row in rows)
    runner.remark(f"run-out within {100 * WANTED:.0f} % of the law: {met} of {len(rows)}")
    draw_laws(runner, np.array(rows, dtype=float))
    figure, (axes,) = new_figure(9, 2.6)
    for ratio, deposit in deposits.items():
        axes.plot(deposit.r, deposit.surface, label=f"a = {ratio:g}")
    axes.set_aspect("equal")
    axes.set_xlabel("distance from the axis by initial radius")
    axes.set_ylabel("height by initial radius")
    legend_beside(axes)
    runner.save(figure, "deposits_3d.png")


def draw_laws(runner: Runner, rows: np.ndarray) -> None:
    figure, panels = new_figure(8, 7, 2)
    a = np.geomspace(0.4, 4, 200)
    laws = ((panels[0], run_out_law, 2, "run-out by initial radius", "Lube et al. (2004)"),
            (panels[1], height_law, 7, "height by initial radius", "Lajeunesse et al. (2004)"))
    for axes, law, column, name, source in laws:
        values = np.array([law(value) for value in a])
        axes.fill_between(a, (1 - WANTED) * values, (1 + WANTED) * values, color=COLOURS[0], alpha=0.2)
        axes.loglog(a, values, color=COLOURS[0], label=source)
        axes.loglog(rows[:, 0], rows[:, column], "o", color=COLOURS[1], label="simulated")
        axes.set_ylabel(name)
    cone = a[(a > 0.74) & (a < 3)]
    panels[0].loglog(cone, [cone_law(value) for value in cone], "--", color=COLOURS[2], label="cone of Lajeunesse's height")
    for axes in panels:
        legend_beside(axes)
    panels[-1].set_xlabel("a = initial height by radius")
    runner.save(figure, "run_out_3d.png")


STUDIES = {run_out_3d.__name__: run_out_3d}
