# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the verification problems: errors over cell size or time step, histories."""

import csv
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from plotting.style import legend_beside, new_figure, save


@dataclass
class Figure:
    """Curves that share their axes, as tests/support/verification_row.hpp writes them."""

    x_label: str
    y_label: str
    logarithmic: bool
    curves: dict[str, list[tuple[float, float]]] = field(default_factory=dict)  #: label -> points


def read_figures(paths: list[Path]) -> dict[tuple[str, str], Figure]:
    """(id, name of the figure) -> figure."""
    figures: dict[tuple[str, str], Figure] = {}
    for path in paths:
        with path.open(newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                figure = figures.setdefault(
                    (row["id"], row["figure"]),
                    Figure(row["x_label"], row["y_label"], row["logarithmic"] == "true"))
                figure.curves.setdefault(row["label"], []).append((float(row["x"]), float(row["y"])))
    return figures


def plot_figures(figures: dict[tuple[str, str], Figure], out: Path) -> list[Path]:
    """Draw each figure as <id>_<name>.png; logarithmic ones get lines of first and second order."""
    paths = []
    for (name, title), content in figures.items():
        figure, (axes,) = new_figure(8.5, 4.2)
        for label, points in content.curves.items():
            axes.plot(*np.array(points).T, "o-" if content.logarithmic else "-", ms=4, label=label)
        if content.logarithmic:
            axes.set_xscale("log")
            axes.set_yscale("log")
            _draw_orders(axes, content)
        axes.set_xlabel(content.x_label)
        axes.set_ylabel(content.y_label)
        axes.set_title(f"{name}: {title}", loc="left")
        legend_beside(axes)
        paths.append(save(figure, out / f"{name}_{re.sub(r'[^A-Za-z0-9]+', '_', title).strip('_')}.png"))
    return paths


def _draw_orders(axes, content: Figure) -> None:
    """Thin lines of slope 1 and 2 through the upper right corner of the data."""
    points = np.array([point for curve in content.curves.values() for point in curve])
    x = np.array([points[:, 0].min(), points[:, 0].max()])
    for order, style in ((1, ":"), (2, "--")):
        axes.plot(x, points[:, 1].max() * (x / x[1]) ** order, style, color="0.6", lw=1, label=f"order {order}")
