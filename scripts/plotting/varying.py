# SPDX-License-Identifier: BSD-3-Clause
"""Constants of the materials that vary in space, before a scene runs: one picture a constant."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from plotting.results import ResultsError, Table
from plotting.scene import DISC, label_of, point_size
from plotting.style import plt, save
from running.programs import PROGRAMS

PANEL = 8.5  # width of a picture [inch]


def read_varying(scene: Path, overrides: list[str], programs: Path = PROGRAMS) -> Table:
    """Table of the material points of a scene as mpm_solver writes it. @raises ResultsError  its message"""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "varying.csv"
        words = [word for each in overrides for word in ("--set", each)]
        done = subprocess.run([str(programs / "mpm_solver"), str(scene), "--write-varying", str(path), *words],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ResultsError((done.stderr or done.stdout).strip() or f"mpm_solver ended with {done.returncode}")
        return Table(path)


def names_of(table: Table) -> list[str]:
    """The constants that vary."""
    return [name for name in table.names if name not in ("body", "x", "y", "z")]


def slice_of(points: np.ndarray, size: float) -> np.ndarray:
    """Marks of the points in the vertical slice through the middle that is one distance of points thick; in a section
    all."""
    if points.shape[1] == 2:
        return np.ones(len(points), dtype=bool)
    middle = np.median(points[:, 1])
    nearest = points[np.argmin(np.abs(points[:, 1] - middle)), 1]
    return np.abs(points[:, 1] - nearest) <= 0.5 * size


def draw_constant(axes: Axes, points: np.ndarray, values: np.ndarray) -> PolyCollection:
    """Points coloured by a constant: a section, or in 3D the slice through the middle."""
    size = point_size(points, points.shape[1])
    shown = slice_of(points, size) & ~np.isnan(values)
    section = points[shown][:, [0, -1]]
    discs = PolyCollection(section[:, None] + size * DISC[None], array=values[shown], cmap="viridis", linewidths=0)
    axes.add_collection(discs)
    axes.autoscale_view()
    axes.set(aspect="equal", ylabel=f"{'y' if points.shape[1] == 2 else 'z'} [m]")
    return discs


def plot_varying(table: Table, out: Path) -> Path:
    """varying.png: the constants below each other, with their ranges."""
    names = names_of(table)
    columns = ("x", "y", "z") if "z" in table else ("x", "y")
    points = np.column_stack([table[column] for column in columns])
    extent = np.ptp(points[:, [0, -1]], axis=0)
    height = float(np.clip(0.72 * PANEL * extent[1] / max(extent[0], 1e-9), 1.2, 8.0)) + 0.5
    figure, grid = plt.subplots(len(names), 1, figsize=(PANEL, height * len(names) + 0.3), sharex=True, squeeze=False)
    for axes, name in zip(grid[:, 0], names):
        values = np.asarray(table[name], dtype=float)
        drawn = draw_constant(axes, points, values)
        figure.colorbar(drawn, ax=axes, label=label_of(name, values), aspect=18)
        axes.set_title(f"{name.replace('_', ' ')}: {np.nanmin(values):.4g} to {np.nanmax(values):.4g}, mean "
                       f"{np.nanmean(values):.4g}", loc="left")
    grid[-1, 0].set_xlabel("x [m]")
    return save(figure, out / "varying.png")
