# SPDX-License-Identifier: BSD-3-Clause
"""Picture of a fit: measured data against the best run."""

import numpy as np

from plotting.results import Results
from plotting.style import COLOURS, Figure, plt

from .data import DataSet, OneNumber, OverTime

PER_ROW = 3


def draw_fit(data: list[DataSet], results: Results, predicted: list[np.ndarray]) -> Figure:
    """A panel a data set: over time or place, the curve of the run and the data with their standard deviations; else
    fitted over measured."""
    rows = -(-len(data) // PER_ROW)
    columns = min(len(data), PER_ROW)
    figure, grid = plt.subplots(rows, columns, figsize=(4.6 * columns, 3.6 * rows), squeeze=False)
    for axes in grid.flat[len(data):]:
        axes.set_visible(False)
    for axes, each, found in zip(grid.flat, data, predicted):
        axes.set_title(each.name, fontsize=11)
        if len(each.over) == 1 and not isinstance(each.source, OneNumber):
            _draw_curve(axes, each, results)
        else:
            _draw_pairs(axes, each, found)
        axes.legend(loc="best", fontsize=9)
    return figure


def _draw_curve(axes: plt.Axes, each: DataSet, results: Results) -> None:
    axes.plot(*each.source.course(results), color=COLOURS[0], label="fitted")
    axes.errorbar(each.at[:, 0], each.values, each.deviation, fmt="o", ms=4, mfc="none", color=COLOURS[1],
                  label="measured")
    over_time = isinstance(each.source, OverTime)
    axes.set_xlabel(f"{each.over[0]} [{'s' if over_time else 'm'}]")
    axes.set_ylabel(each.source.column if over_time else each.source.field)


def _draw_pairs(axes: plt.Axes, each: DataSet, found: np.ndarray) -> None:
    axes.errorbar(each.values, found, xerr=each.deviation, fmt="o", ms=4, mfc="none", color=COLOURS[1],
                  label="of each place" if each.over else "the number")
    ends = [min(each.values.min(), found.min()), max(each.values.max(), found.max())]
    axes.plot(ends, ends, color=COLOURS[0], label="equal")
    axes.set_xlabel("measured")
    axes.set_ylabel("fitted")
