# SPDX-License-Identifier: BSD-3-Clause
"""Depth of the mass over places: each cell of a raster of depths keeps its volume, whatever the grid's cells are."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .outline import Outline, limits_of
from .raster import Raster

SAMPLES = 8  # along each side of a cell where a polygon cuts it


def neighbour(values: np.ndarray, down: int, right: int) -> np.ndarray:
    """Value of the next cell in a direction; the cell's own one where the next one has no mass or there is none."""
    rows, columns = values.shape
    j = np.clip(np.arange(rows) + down, 0, rows - 1)[:, None]
    i = np.clip(np.arange(columns) + right, 0, columns - 1)[None, :]
    other = values[j, i]
    return np.where(other > 0, other, values)


@dataclass
class CellDepths:
    """Depths as means of square cells, 0: no mass; corner: of the cell in the south-west [m].

    Inside a cell the depth is bilinear between the centres of cells that have mass, as if a cell at the rim went on
    beyond it, and is scaled so that the mean of the cell is its value: the volume of a raster is the sum of its cells.
    """

    corner: np.ndarray
    spacing: float
    values: np.ndarray

    def __post_init__(self) -> None:
        v = self.values
        sides = {(a, b): neighbour(v, a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)}
        # Mean of each quarter of a cell: a bilinear function at a quarter of the distance to its neighbours.
        mean = sum(0.5625 * v + 0.1875 * (sides[a, 0] + sides[0, b]) + 0.0625 * sides[a, b]
                   for a in (-1, 1) for b in (-1, 1)) / 4
        self._sides = sides
        self._factor = np.where(v > 0, v / np.where(v > 0, mean, 1), 0)

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Depth at places [m]; 0 outside the raster."""
        rows, columns = self.values.shape
        s, t = (x - self.corner[0]) / self.spacing, (y - self.corner[1]) / self.spacing
        inside = (s >= 0) & (s < columns) & (t >= 0) & (t < rows)
        i, j = np.clip(np.floor(s), 0, columns - 1).astype(int), np.clip(np.floor(t), 0, rows - 1).astype(int)
        a, b = s - i - 0.5, t - j - 0.5
        depth = np.zeros(np.broadcast(s, t).shape)
        for down in (-1, 1):
            for right in (-1, 1):
                here = inside & ((b >= 0) == (down > 0)) & ((a >= 0) == (right > 0))
                p, q, w, z = j[here], i[here], np.abs(a[here]), np.abs(b[here])
                depth[here] = self._factor[p, q] * (
                    (1 - w) * (1 - z) * self.values[p, q] + w * (1 - z) * self._sides[0, right][p, q]
                    + (1 - w) * z * self._sides[down, 0][p, q] + w * z * self._sides[down, right][p, q])
        return depth

    def breaks(self, axis: int, high: float) -> np.ndarray:
        """Edges and centres of its cells along an axis, between 0 and `high`: between two of them depth is bilinear."""
        lines = self.corner[axis] + self.spacing / 2 * np.arange(2 * self.values.shape[1 - axis] + 1)
        return lines[(lines > 0) & (lines < high)]

    def volume(self) -> float:
        return float(self.values.sum()) * self.spacing**2


@dataclass
class Mass:
    """Depth of the mass: of a raster, or one depth for each outline (cells: None); inside the outlines, None:
    everywhere.

    stretch: upright depth over the given one, where that is measured across the slope; None: it is upright.
    """

    cells: CellDepths | None
    depths: list[float]
    outlines: list[Outline] | None
    stretch: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Depth at places [m]; x and y have one shape."""
        if self.outlines is None:
            return self.cells.at(x, y)
        places = np.column_stack([x.ravel(), y.ravel()])
        depth = np.zeros(len(places))
        within = None if self.cells is None else self.cells.at(x, y).ravel()
        for k, outline in enumerate(self.outlines):
            inside = outline.contains(places)
            depth[inside] = self.depths[k] if within is None else within[inside]
        if self.stretch is not None:
            within = depth > 0
            depth[within] *= self.stretch(*places[within].T)
        return depth.reshape(x.shape)

    def asked(self) -> float:
        """Volume [m^3]: sum of the cells of the raster, or area of each outline times its depth, upright."""
        if self.cells is None:
            return sum(depth * outline.area() for depth, outline in zip(self.depths, self.outlines))
        if self.outlines is None:
            return self.cells.volume()
        rows, columns = self.cells.values.shape
        ticks = (np.arange(max(rows, columns) * SAMPLES) + 0.5) * self.cells.spacing / SAMPLES
        x, y = np.meshgrid(self.cells.corner[0] + ticks[:columns * SAMPLES],
                           self.cells.corner[1] + ticks[:rows * SAMPLES])
        return float(self.at(x, y).sum()) * (self.cells.spacing / SAMPLES) ** 2

    def means(self, h: float, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Mean depth of each cell of the grid's plan, and whether soil covers all of it.

        h: side of a cell [m]; shape: rows and columns, from (0, 0). Exact for a raster; sampled where there are
        outlines.
        """
        pieces = [self._pieces(axis, h, shape[1 - axis]) for axis in (0, 1)]
        (x, wide, first_x), (y, high, first_y) = pieces
        depth = self.at(*np.meshgrid(x, y))
        weight = high[:, None] * wide[None, :]

        def gather(values: np.ndarray) -> np.ndarray:
            return np.add.reduceat(np.add.reduceat(values, first_y, axis=0), first_x, axis=1)

        return gather(depth * weight) / h**2, gather((depth <= 0) * weight) <= 0

    def _pieces(self, axis: int, h: float, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Along an axis: centres and lengths of the pieces on each of which depth is bilinear, first piece of each
        cell."""
        lines = h * np.arange(count + 1)
        samples = 1 if self.outlines is None else SAMPLES
        cuts = np.concatenate([h / samples * np.arange(count * samples + 1),
                               [] if self.cells is None else self.cells.breaks(axis, lines[-1])])
        cuts = np.unique(np.concatenate([lines, cuts]))
        cuts = cuts[np.concatenate([[True], np.diff(cuts) > 1e-9 * h])]  # no pieces from round-off
        return (cuts[:-1] + cuts[1:]) / 2, np.diff(cuts), np.searchsorted(cuts, lines[:-1] - 1e-8 * h)


def of_raster(raster: Raster, origin: np.ndarray) -> CellDepths:
    """Depths in local coordinates; cells without data or with a depth of at most 0 have no mass. Of the raster only the
    rows and columns between those with mass are kept: it may be that of a whole valley.
    """
    values = np.where(np.isnan(raster.values), 0, np.maximum(raster.values, 0))
    (bottom, top), (left, right) = (between(values.any(axis=axis)) for axis in (1, 0))
    corner = np.array([raster.x + (left - 0.5) * raster.spacing, raster.y + (bottom - 0.5) * raster.spacing])
    return CellDepths(corner - origin[:2], raster.spacing, values[bottom:top, left:right])


def between(marks: np.ndarray) -> tuple[int, int]:
    """First and behind last of the numbers of the marks; of none the first place alone."""
    places = np.flatnonzero(marks)
    return (int(places[0]), int(places[-1]) + 1) if len(places) else (0, 1)


def near_outlines(raster: Raster, outlines: list[Outline] | None) -> Raster:
    """The part of a raster that reaches a cell beyond the outlines on the map; all of it without any."""
    if outlines is None:
        return raster
    ends = limits_of(outlines)
    parts, first = [], []
    for axis, start in ((1, raster.y), (0, raster.x)):
        count = raster.values.shape[1 - axis]
        low, high = ((end[axis] - start) / raster.spacing for end in ends)
        begin, behind = np.clip([np.floor(low) - 1, np.ceil(high) + 2], 0, count).astype(int)
        begin = min(begin, count - 1)
        parts.append(slice(begin, max(behind, begin + 1)))
        first.append(start + begin * raster.spacing)
    return Raster(raster.path, first[1], first[0], raster.spacing, raster.values[tuple(parts)])


def below_top(top: Raster, slope: Raster) -> Raster:
    """Depth between two rasters of heights on the cells of the upper one; nan where one of them has no data."""
    rows, columns = top.values.shape
    x, y = np.meshgrid(top.x + top.spacing * np.arange(columns), top.y + top.spacing * np.arange(rows))
    return Raster(top.path, top.x, top.y, top.spacing, top.values - slope.at(x, y))
