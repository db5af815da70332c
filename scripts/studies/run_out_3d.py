# SPDX-License-Identifier: BSD-3-Clause
"""Run-out and height of cylinders of sand over their slenderness, against laws of experiments."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plotting.column import front_of, surface_of
from plotting.style import COLOURS, legend_beside, new_figure
from studies.columns import setting
from studies.measures import Measured
from studies.run_out import GRAVITY, draw_deposits, draw_law
from studies.runner import ROOT, Runner, folder_of

SCENE = "column_run_out_3d"
RATIOS = {10: (0.5, 0.9, 1.5, 3.0), 15: (0.5, 0.9, 1.5)}  # a = height by radius, by cells a radius
RADIUS = 0.1  # [m]
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


@dataclass(frozen=True)
class Cylinder:
    """A quarter of a cylinder of cubes, each half as wide as a cell of the grid and with one point."""

    ratio: float  #: height by RADIUS, rounded to whole cubes
    cells: int = 10  #: of the grid in a radius

    @property
    def edge(self) -> float:
        """Edge of a cube [m]."""
        return RADIUS / (2 * self.cells)

    @property
    def layers(self) -> int:
        return round(2 * self.cells * self.ratio)

    @property
    def radius(self) -> float:
        """Radius of a cylinder with the volume of the cubes [m]."""
        middle = np.arange(2 * self.cells) + 0.5
        inside = np.add.outer(middle**2, middle**2) < (2 * self.cells) ** 2
        return self.edge * float(np.sqrt(4 * inside.sum() / np.pi))

    @property
    def a(self) -> float:
        """Height by radius."""
        return self.layers * self.edge / self.radius

    def settings(self, mesh: str) -> list[str]:
        """Settings of a run: the column is at rest after some 5 sqrt(H / g); dt keeps its ratio to the cells."""
        cell, dt = 2 * self.edge, 0.02 / self.cells
        wide, high = int(np.ceil((1 + 1.4 * run_out_law(self.a)) * self.cells)), int(np.ceil(self.layers / 2)) + 2
        size = [round(number * cell, 9) for number in (wide, wide, high)]
        grid = {"box": {"low": [0, 0, 0], "high": size, "cells": [wide, wide, high], "type": "hex8"}}
        return [setting("grid", grid), setting("bodies/0/mesh", {"file": mesh}), setting("time/dt", dt),
                setting("time/dt_min", dt / 1000),
                setting("time/end", round(5.5 * np.sqrt(self.layers * self.edge / GRAVITY), 2))]

    def write_mesh(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run([ROOT / "configs" / SCENE / "make_cylinder", "--edge", str(self.edge), "--radius",
                        str(2 * self.cells), "--layers", str(self.layers), path], check=True, capture_output=True)


@dataclass
class Deposit:
    """Deposit of a cylinder, by its initial radius R0."""

    run_out: float  #: (R - R0) / R0, mean over the sectors
    spread: float  #: largest less smallest R over the sectors, by the mean
    height: float  #: H / R0, of the highest point
    volume: float  #: under the surface, by that of the cylinder
    r: np.ndarray  #: surface
    surface: np.ndarray


def fronts(x: np.ndarray, y: np.ndarray, spacing: float, inside: float) -> np.ndarray:
    """inside: soil within this radius counts as connected [m]. Radius at which the connected deposit ends, in each
    sector of the quarter [m]."""
    r, sector = np.hypot(x, y), np.minimum(np.arctan2(y, x) / (0.5 * np.pi) * SECTORS, SECTORS - 1).astype(int)
    found = []
    for k in range(SECTORS):
        # Near the axis a sector is narrower than a point.
        of_sector = np.maximum(r[sector == k], inside)
        found.append(front_of(np.column_stack([of_sector, of_sector]), spacing))
    return np.array(found)


def volume_under(r: np.ndarray, height: np.ndarray) -> float:
    """Volume below a surface of revolution, linear between its places and level inside of the first [m^3]."""
    low, high = r[:-1], r[1:]
    rings = np.pi / 3 * ((high - low) * (height[:-1] * (2 * low + high) + height[1:] * (low + 2 * high)))
    return float(rings.sum() + np.pi * r[0] ** 2 * height[0])


def deposit_of(run: Measured, cylinder: Cylinder) -> Deposit:
    soil = run.results.frames_of_soil()
    x, y, z = soil.frame(len(soil) - 1).points.T
    radius, edge = cylinder.radius, cylinder.edge
    found = fronts(x, y, edge, radius)
    r, surface = surface_of(np.column_stack([np.hypot(x, y), z]), edge)
    return Deposit(found.mean() / radius - 1, np.ptp(found) / found.mean(), (z.max() + 0.5 * edge) / radius,
                   volume_under(r, surface) / (np.pi * cylinder.a * radius**3), r / radius, surface / radius)


HEAD = ["points", "run-out", "law", "error", "cone", "spread", "height", "law", "error", "volume kept", "Newton a step",
        "CPU [s]"]


def measure(runner: Runner, label: str, cylinder: Cylinder, settings: list[str]) -> tuple[list, Deposit]:
    """A row of HEAD."""
    mesh = (runner.folder / f"{label}.msh").resolve()
    cylinder.write_mesh(mesh)
    run = runner.run(label, SCENE, [*cylinder.settings(str(mesh)), *settings])
    deposit, out, high = deposit_of(run, cylinder), run_out_law(cylinder.a), height_law(cylinder.a)
    return [run.summary["solver"]["points"], deposit.run_out, out, deposit.run_out / out - 1, cone_law(cylinder.a),
            deposit.spread, deposit.height, high, deposit.height / high - 1, deposit.volume, run.newton_per_step(),
            run.cpu_seconds()], deposit


def run_out_3d(runner: Runner) -> None:
    """Cylinders of sand of four slendernesses: run-out and height against Lube and Lajeunesse et al. (2004)."""
    found: dict[int, np.ndarray] = {}
    met = []
    for cells, ratios in RATIOS.items():
        rows, deposits = [], {}
        for ratio in ratios:
            row, deposits[ratio] = measure(runner, f"a_{ratio:g}_cells_{cells}", Cylinder(ratio, cells), [])
            rows.append([ratio, *row])
        shown = [["" if value != value else value for value in row] for row in rows]  # no cone: NaN
        runner.report(["a", *HEAD], shown, f"{cells} cells a radius")
        found[cells] = np.array(rows, dtype=float)
        met.append(f"{cells} cells {sum(abs(row[4]) <= WANTED for row in rows)} of {len(rows)}")
        draw_profiles(runner, deposits, f"deposits_3d_{cells}.png")
    runner.remark(f"run-out within {100 * WANTED:.0f} % of the law: {', '.join(met)}")
    draw_laws(runner, found)
    changed = []
    for name, (cells, settings) in FACTORS.items():
        label = "changed_" + folder_of(name).replace("/", "_by_")
        changed.append([name, *measure(runner, label, Cylinder(CHANGED, cells), settings)[0]])
    runner.report(["changed", *HEAD], changed, f"a = {CHANGED:g}, one thing changed")


CHANGED = 0.9
FACTORS = {
    "friction 37°": (10, [setting("bodies/0/material/friction_angle", 37)]),
    "linear": (10, [setting("basis", "linear")]),
    "linear, no F-bar": (10, [setting("basis", "linear"), setting("locking/method", "none")]),
    "6 cells a radius": (6, []),
}


def draw_profiles(runner: Runner, deposits: dict[float, Deposit], name: str) -> None:
    """deposits: by slenderness."""
    figure, (axes,) = new_figure(9, 2.6)
    draw_deposits(axes, {ratio: (deposit.r, deposit.surface) for ratio, deposit in deposits.items()})
    axes.set_xlabel("distance from the axis by initial radius")
    axes.set_ylabel("height by initial radius")
    runner.save(figure, name)


def draw_laws(runner: Runner, found: dict[int, np.ndarray]) -> None:
    """found: rows of the tables by cells a radius."""
    figure, panels = new_figure(8, 7, 2)
    a = np.geomspace(0.4, 4, 200)
    laws = ((panels[0], run_out_law, 2, "run-out by initial radius", "Lube et al. (2004)"),
            (panels[1], height_law, 7, "height by initial radius", "Lajeunesse et al. (2004)"))
    for axes, law, column, name, source in laws:
        draw_law(axes, a, np.array([law(value) for value in a]), WANTED, source)
        for marker, (cells, rows) in zip("os", found.items()):
            axes.loglog(rows[:, 0], rows[:, column], marker, color=COLOURS[1], label=f"{cells} cells a radius")
        axes.set_ylabel(name)
    cone = a[(a > 0.74) & (a < 3)]
    panels[0].loglog(cone, [cone_law(value) for value in cone], "--", color=COLOURS[2],
                     label="cone of Lajeunesse's height")
    for axes in panels:
        legend_beside(axes)
    panels[-1].set_xlabel("a = initial height by radius")
    runner.save(figure, "run_out_3d.png")


STUDIES = {run_out_3d.__name__: run_out_3d}
