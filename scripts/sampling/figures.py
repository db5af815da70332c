# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of a study."""

from typing import Any

import numpy as np

from plotting.style import COLOURS, Figure, plt
from studies.measures import Curve

from .reader import is_number
from .statistics import QUANTILES, Band, Fit, Indices, Level


FEW = 12  # different values that are each a group
MOST_GROUPS, LEAST = 8, 4  # of values of a sample; points of a group


def draw_responses(values: dict[str, list[Any]], answers: dict[str, np.ndarray]) -> Figure:
    """Each answer over each parameter: a dot a point of the study, a line through means.

    values: of each parameter; answers: NaN where there is none; all [num_points].
    """
    figure, grid = plt.subplots(len(answers), len(values), squeeze=False, sharey="row", sharex="col",
                                figsize=(1 + 3.2 * len(values), 0.6 + 2.6 * len(answers)))
    for row, (answer, found) in zip(grid, answers.items()):
        for axes, (name, given) in zip(row, values.items()):
            _draw_response(axes, given, found)
            axes.set_xlabel(name if axes in grid[-1] else "")
        row[0].set_ylabel(answer)
    return figure


def _draw_response(axes: plt.Axes, given: list[Any], found: np.ndarray) -> None:
    numbers = all(map(is_number, given))
    words = list(dict.fromkeys(map(str, given)))
    x = np.array(given, dtype=float) if numbers else np.array([words.index(str(each)) for each in given], dtype=float)
    axes.plot(x, found, "o", ms=4, alpha=0.6, color=COLOURS[0])
    groups = _groups(x[np.isfinite(found)])
    there = found[np.isfinite(found)]
    axes.plot([x[np.isfinite(found)][group].mean() for group in groups], [there[group].mean() for group in groups], "-",
              color=COLOURS[1])
    if not numbers:
        axes.set_xticks(range(len(words)), words)


def _groups(x: np.ndarray) -> list[np.ndarray]:
    """Numbers of like values: equal ones where these are few, else up to MOST_GROUPS of as many each."""
    levels = np.unique(x)
    if len(levels) <= FEW:
        return [np.flatnonzero(x == level) for level in levels]
    return np.array_split(np.argsort(x, kind="stable"), max(2, min(MOST_GROUPS, len(x) // LEAST)))


def draw_indices(names: list[str], found: dict[str, Indices]) -> Figure:
    """First and total index of each parameter with its confidence, a panel an answer."""
    figure, grid = plt.subplots(1, len(found), squeeze=False, sharey=True, figsize=(1.5 + 3.5 * len(found), 3.5))
    for axes, (answer, indices) in zip(grid[0], found.items()):
        for k, (label, centre, ends) in enumerate((("first order", indices.first, indices.first_ends),
                                                   ("total", indices.total, indices.total_ends))):
            place = np.arange(len(names)) + 0.35 * (k - 0.5)
            axes.bar(place, centre, 0.33, color=COLOURS[k], label=label)
            axes.errorbar(place, centre, [np.maximum(centre - ends[0], 0), np.maximum(ends[1] - centre, 0)], fmt="none",
                          ecolor="0.3", lw=1)
        axes.set_xticks(range(len(names)), names)
        axes.set_title(answer, loc="left")
    grid[0, 0].set_ylabel("share of the variance")
    grid[0, -1].legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return figure


def draw_fragility(levels: list[Level], fit: Fit | None, intensity: str, label: str) -> Figure:
    figure, axes = plt.subplots(figsize=(7, 4))
    x = np.array([level.intensity for level in levels])
    share = np.array([level.share for level in levels])
    ends = np.array([level.ends for level in levels]).T
    axes.errorbar(x, share, [share - ends[0], ends[1] - share], fmt="o", color=COLOURS[0], capsize=3,
                  label="share of the runs")
    if fit:
        fine = np.linspace(x.min(), x.max(), 200)
        axes.plot(fine, fit.at(fine), color=COLOURS[1],
                  label=f"lognormal, median {fit.median:.4g}, deviation {fit.deviation:.3g}")
    axes.set_xlabel(intensity)
    axes.set_ylabel(f"probability that\n{label}")
    axes.set_ylim(-0.03, 1.03)
    axes.legend(loc="best")
    return figure


def draw_band(name: str, band: Band, curves: list[Curve]) -> Figure:
    figure, axes = plt.subplots(figsize=(9, 4))
    for curve in curves[:50]:
        axes.plot(curve.time, curve.values, color="0.8", lw=0.5, zorder=0)
    for k in range(len(QUANTILES) // 2):
        axes.fill_between(band.time, band.quantiles[k], band.quantiles[-1 - k], color=COLOURS[0], alpha=0.25, lw=0,
                          label=f"{QUANTILES[k]:.0%} to {QUANTILES[-1 - k]:.0%} of the runs")
    axes.plot(band.time, band.quantiles[len(QUANTILES) // 2], color=COLOURS[0], label="median")
    axes.plot(band.time, band.mean, "--", color=COLOURS[1], label="mean")
    axes.set_xlabel("time [s]")
    axes.set_ylabel(name)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return figure
