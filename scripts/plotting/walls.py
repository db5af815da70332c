# SPDX-License-Identifier: BSD-3-Clause
"""Rigid walls of a scene in 2D: where they are at a time, with short strokes on the side without soil."""

import math

import numpy as np

from plotting.contact import chain, contact_series
from plotting.results import Results, Series

STROKE = 0.012  # length of a stroke over the longer edge of the window
APART = 0.02  # of two strokes, likewise


def dropped_at(names: list[str], phases: list[dict]) -> dict[str, float]:
    """Name of a rigid wall -> time [s] from which on it no longer acts; only those that a phase drops."""
    dropped: dict[str, float] = {}
    start = 0.0
    for phase in phases:
        kept = phase.get("rigid_walls", names)
        dropped |= {name: start for name in names if name not in kept and name not in dropped}
        start = phase.get("until", math.inf)
    return dropped


class Walls:
    """The rigid walls of a run; none in space, where a side view would show them edgewise only."""

    def __init__(self, results: Results):
        settings = results.settings("mpm.json") if results.dim == 2 else {}
        names = [wall["name"] for wall in settings.get("rigid_walls", [])]
        series = contact_series(results) if names else {}
        self._series: dict[str, Series] = {name: series[name] for name in names if name in series}
        self._cells: dict[str, np.ndarray] = {}  # in their order, the same in all frames
        for name, frames in self._series.items():
            cells = frames.frame(0).cells
            self._cells[name] = cells[chain(cells)]
        self._dropped = dropped_at(names, settings.get("phases", []))

    def __len__(self) -> int:
        return len(self._series)

    def at(self, time: float) -> list[np.ndarray]:
        """Segments of each wall that acts at `time`, in their order, num_segments x 2 ends x 2 [m]."""
        found = []
        for name, series in self._series.items():
            if time > self._dropped.get(name, math.inf):
                continue
            found.append(series.frame(series.nearest(time)).points[self._cells[name], :2])
        return found


def strokes(segments: np.ndarray, window: float) -> np.ndarray:
    """Short strokes on the left of segments, where no soil is, num_strokes x 2 x 2 [m].

    window: longer edge of the picture [m].
    """
    ways = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(ways, axis=1)
    ways = ways / length[:, None]
    ends = np.cumsum(length)
    apart = APART * window
    places = np.arange(apart / 2, ends[-1], apart)
    if not len(places):
        places = ends[-1:] / 2
    number = np.searchsorted(ends, places)
    start = segments[number, 0] + (places - ends[number] + length[number])[:, None] * ways[number]
    left = np.stack([-ways[number, 1], ways[number, 0]], axis=1)
    return np.stack([start, start + STROKE * window * (left - ways[number])], axis=1)


def widened(low: np.ndarray, high: np.ndarray, walls: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """A window (low, high) with the walls in it.

    It grows on each side by at most half its longer edge, and by a seventh for walls longer than that: beds are long.
    """
    edge = (high - low).max()
    wide_low, wide_high = low, high
    for segments in walls:
        first, last = segments.min(axis=(0, 1)), segments.max(axis=(0, 1))
        most = edge / (7 if (last - first).max() > edge else 2)
        wide_low = np.minimum(wide_low, np.maximum(first, low - most))
        wide_high = np.maximum(wide_high, np.minimum(last, high + most))
    return wide_low, wide_high
