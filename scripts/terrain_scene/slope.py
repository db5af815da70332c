# SPDX-License-Identifier: BSD-3-Clause
"""The slope on the lattice of the grid, and the soil on it as columns; all in local coordinates [m]."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .depths import Mass
from .raster import TerrainError

# Columns with less than this share of a cell are left out: their points would be a sixteenth of a cell.
THINNEST = 0.25
MOST_PIECES = 4  # of a side of a cell, for facets: cliffs would ask for more without end
BULGE = 0.0125  # of a layer of cells, how far facets may rise above the ground of the lowest points: a run allows more
# where they would be cut finer than halves of a cell: a run looks at all that are near its points
MOST_FACETS = 1_000_000
MOST_CELLS = 10_000_000  # of the mass: 100 times what a run on a workstation has
NUDGE = 1e-6  # of a cell: how far inside its corners the depth is looked up


@dataclass
class Slope:
    """Heights at the nodes of a lattice from (0, 0), rows along x first: z[j, i]; bilinear between them, nan:
    unknown."""

    spacing: float
    z: np.ndarray

    def size(self) -> tuple[float, float]:
        return (self.z.shape[1] - 1) * self.spacing, (self.z.shape[0] - 1) * self.spacing

    def require_inside(self, places: np.ndarray, where: str) -> None:
        """places: any shape x 2. @raises TerrainError"""
        if (places < 0).any() or (places > self.size()).any():
            flat = places.reshape(-1, 2)
            x, y = flat[((flat < 0) | (flat > self.size())).any(axis=1)][0]
            wide, long = self.size()
            raise TerrainError(f"{where}: found a part outside the area, at ({x:.9g}, {y:.9g}) m from its south-west "
                               f"corner, allowed: (0, 0) to ({wide:g}, {long:g}) m")

    def require_known(self, heights: np.ndarray, places: np.ndarray, where: str) -> None:
        """heights: at places n x 2. @raises TerrainError"""
        if np.isnan(heights).any():
            x, y = places[np.isnan(heights)][0]
            raise TerrainError(f"{where}: found a part where the slope has no data, at ({x:.9g}, {y:.9g}) m from the "
                               "south-west corner of the area, allowed: places with data")

    def _in_cell(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Column and row of the cell that has a place, and the shares of a cell beyond its south-west corner."""
        rows, columns = self.z.shape
        s, t = np.asarray(x) / self.spacing, np.asarray(y) / self.spacing
        i, j = np.clip(np.floor(s), 0, columns - 2).astype(int), np.clip(np.floor(t), 0, rows - 2).astype(int)
        return i, j, s - i, t - j

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """nan where a node that counts is unknown."""
        i, j, a, b = self._in_cell(x, y)
        z = self.z
        parts = (((1 - a) * (1 - b), z[j, i]), (a * (1 - b), z[j, i + 1]), ((1 - a) * b, z[j + 1, i]),
                 (a * b, z[j + 1, i + 1]))
        first, *rest = (np.where(weight == 0, 0, weight * value) for weight, value in parts)
        return first + rest[0] + rest[1] + rest[2]

    def stretch(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Area of the surface over that in the plan: upright depth over that across the slope."""
        i, j, a, b = self._in_cell(x, y)
        z = self.z
        east = (1 - b) * (z[j, i + 1] - z[j, i]) + b * (z[j + 1, i + 1] - z[j + 1, i])
        north = (1 - a) * (z[j + 1, i] - z[j, i]) + a * (z[j + 1, i + 1] - z[j, i + 1])
        return np.sqrt(1 + (east**2 + north**2) / self.spacing**2)

    def cut(self, pieces: int) -> "Slope":
        """This surface on a finer lattice: its facets follow warped cells more closely."""
        rows, columns = self.z.shape
        x = np.arange(pieces * (columns - 1) + 1) * (self.spacing / pieces)
        y = np.arange(pieces * (rows - 1) + 1) * (self.spacing / pieces)
        return Slope(self.spacing / pieces, self.at(x[None, :], y[:, None]))

    def longest_edge(self) -> float:
        """Longest edge of the facets [m]."""
        z, h = self.z, self.spacing
        along = max(np.nanmax(np.abs(np.diff(z, axis=0))), np.nanmax(np.abs(np.diff(z, axis=1))))
        across = np.nanmax(np.minimum(np.abs(z[:-1, :-1] - z[1:, 1:]), np.abs(z[:-1, 1:] - z[1:, :-1])))
        return float(max(np.hypot(h, along), np.hypot(np.sqrt(2) * h, across)))

    def facets(self, depth: np.ndarray) -> "Slope":
        """Cut so often that no facet is longer than the diagonal of half a cell, as the soil asks of curved surfaces,
        and that none rises into the lowest points of the mass, up to four times, which a slope of 70 degrees takes, as
        long as there are not too many of them.

        At least in two: a fold along the diagonal of a whole cell would be felt by points a quarter of a cell deep. In
        four the facets meet the warped cells exactly below the points, whose places are quarters of a cell.

        depth: of the mass over each cell [m].
        """
        pieces = 2
        most = min(MOST_PIECES, int(np.sqrt(MOST_FACETS / (2 * self.z.size))))
        while pieces < most and (self.cut(pieces).longest_edge() > np.sqrt(0.5) * self.spacing
                                 or self.bulge(pieces, depth).max() > BULGE):
            pieces += 1
        return self.cut(pieces)

    def bulge(self, pieces: int, depth: np.ndarray) -> np.ndarray:
        """How far facets of cells in `pieces` rise above the warped cells below points at quarters of a cell, over the
        height of a layer of the mass of this depth [m] over each cell; 0 without mass.
        """
        within = depth >= THINNEST * self.spacing * (1 - 1e-9)
        layers = np.maximum(1, np.ceil(depth / self.spacing - 1e-9))
        return np.where(within, self.rise(pieces) / np.where(within, depth / layers, 1), 0)

    def rise(self, pieces: int) -> np.ndarray:
        """Rise of the facets in metres, for each cell the largest of its four points, at least 0."""
        fine = self.cut(pieces).z
        x = np.arange(self.z.shape[1] - 1)[None, :]
        y = np.arange(self.z.shape[0] - 1)[:, None]
        highest = np.zeros(np.broadcast(x, y).shape)
        for first in (0.25, 0.75):
            for second in (0.25, 0.75):
                (i, u), (j, v) = ((int(share * pieces), share * pieces % 1) for share in (first, second))
                a, b, c, d = (fine[y * pieces + j + dj, x * pieces + i + di] for dj,
                              di in ((0, 0), (0, 1), (1, 1), (1, 0)))
                along = a + u * (b - a) + v * (c - b) if u >= v else a + v * (d - a) + u * (c - d)
                across = a + u * (b - a) + v * (d - a) if u + v <= 1 else c + (1 - u) * (d - c) + (1 - v) * (b - c)
                facet = np.where(rising(a, b, c, d), along, across)
                warped = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
                highest = np.fmax(highest, facet - warped)
        return highest


def rising(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Whether a quadrangle is cut from a to c: along its shorter diagonal. Heights of its corners in turn."""
    return np.abs(a - c) <= np.abs(b - d)


def write_ply(slope: Slope, path: Path) -> int:
    """Two triangles a cell, which look up, as bytes in single precision, enough for local coordinates; returns their
    number. Cells with an unknown corner have none.
    """
    rows, columns = slope.z.shape
    x, y = np.meshgrid(np.arange(columns) * slope.spacing, np.arange(rows) * slope.spacing)
    number = np.arange(rows * columns).reshape(rows, columns)
    known = ~np.isnan(slope.z)
    within = known[:-1, :-1] & known[:-1, 1:] & known[1:, 1:] & known[1:, :-1]
    a, b, c, d = (each[within] for each in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    height = slope.z.ravel()
    upwards = rising(*(height[each] for each in (a, b, c, d)))[..., None, None]
    corners = np.where(upwards, np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2),
                       np.stack([np.stack([a, b, d], -1), np.stack([b, c, d], -1)], -2)).reshape(-1, 3)
    used = known.ravel()
    corners = (np.cumsum(used) - 1)[corners]
    faces = np.empty(len(corners), dtype=[("size", "u1"), ("corners", "<i4", 3)])
    faces["size"], faces["corners"] = 3, corners
    head = ("ply\nformat binary_little_endian 1.0\ncomment terrain in local coordinates\n"
            f"element vertex {used.sum()}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    nodes = np.empty(used.sum(), dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4")])
    nodes["x"], nodes["y"], nodes["z"] = x.ravel()[used], y.ravel()[used], slope.z.ravel()[used]
    path.write_bytes(head.encode("ascii") + nodes.tobytes() + faces.tobytes())
    return len(corners)


@dataclass
class Columns:
    """Hexahedra on the slope: nodes n x 3 [m], cells m x 8; volume [m^3] of the depth asked for and of the cells."""

    nodes: np.ndarray
    cells: np.ndarray
    asked: float
    filled: float
    depth: np.ndarray  # mean of each cell of the lattice [m], before thin ones are left out
    top: np.ndarray  # above the slope at the corners of each cell, rows x columns x 4 [m]; 0 where there is no soil

    def heights(self, x: np.ndarray, y: np.ndarray, spacing: float) -> np.ndarray:
        """The surface of the soil above the slope at places on the lattice [m]; 0 where there is no soil."""
        rows, count = self.depth.shape
        row = np.minimum((y / spacing).astype(int), rows - 1)
        column = np.minimum((x / spacing).astype(int), count - 1)
        v, u = y / spacing - row, x / spacing - column
        shares = np.stack([(1 - v) * (1 - u), (1 - v) * u, v * u, v * (1 - u)], axis=-1)
        return (shares * self.top[row, column]).sum(axis=-1)


def corner_depths(mass: Mass, slope: Slope, within: np.ndarray) -> np.ndarray:
    """Depths just inside the four corners of cells of the lattice, n x 4 [m]; within: row and column of each, n x 2."""
    inside = np.array([(NUDGE, NUDGE), (NUDGE, 1 - NUDGE), (1 - NUDGE, 1 - NUDGE), (1 - NUDGE, NUDGE)])
    places = (within[:, None, :] + inside) * slope.spacing
    return mass.at(places[..., 1], places[..., 0])


def count_layers(high: np.ndarray, within: np.ndarray, h: float) -> np.ndarray:
    """Layers of at most a cell in each column. @raises TerrainError  more cells than a scene can have"""
    layers = np.maximum(1, np.ceil(high.max(axis=1) / h - 1e-9))
    if layers.sum() > MOST_CELLS:
        k = int(np.argmax(layers))
        x, y = (within[k][::-1] + 0.5) * h
        raise TerrainError(f"slide: found a mass of {layers.sum():.3g} cells, the deepest column {high[k].max():.6g} m "
                           f"at ({x:g}, {y:g}) of the area, allowed: {MOST_CELLS} cells")
    return layers.astype(int)


def lay_columns(slope: Slope, mass: Mass, lift: np.ndarray | None = None) -> Columns:
    """A column a cell of the lattice, cut into layers of at most a cell: its volume is that of the soil above the cell.

    The bottom is the slope, or lies above it by `lift` of each cell [m]. The top follows the soil where it covers the
    cell, and is parallel to the slope at its rim.

    @raises TerrainError  more cells than a scene can have
    """
    h = slope.spacing
    rows, columns = slope.z.shape
    mean, covered = mass.means(h, (rows - 1, columns - 1))
    thinnest = THINNEST * h * (1 - 1e-9)
    within = np.argwhere(mean >= thinnest)
    filled = mean[mean >= thinnest].sum() * h * h
    if not len(within):
        return Columns(np.empty((0, 3)), np.empty((0, 8), dtype=int), mass.asked(), 0.0, mean,
                       np.zeros((*mean.shape, 4)))
    means = mean[within[:, 0], within[:, 1]]
    ground = np.stack([slope.z[within[:, 0] + dj, within[:, 1] + di] for dj in (0, 1) for di in (0, 1)]).sum(axis=0)
    slope.require_known(ground, (within[:, ::-1] + 0.5) * h, "slide")
    high = corner_depths(mass, slope, within)
    # A bilinear top has the mean of its corners: scaled, it has the volume of the soil.
    whole = covered[within[:, 0], within[:, 1]] & (high.min(axis=1) >= thinnest)
    high = np.where(whole[:, None], high * (means / np.where(whole, high.mean(axis=1), 1))[:, None], means[:, None])
    layers = count_layers(high, within, h)
    nodes: list[np.ndarray] = []
    cells: list[np.ndarray] = []
    first = 0
    for (j, i), top, count in zip(within, high, layers):
        corners = np.array([(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)])
        ground = np.column_stack([corners[:, ::-1] * h, slope.z[corners[:, 0], corners[:, 1]]])
        rise = np.zeros((count + 1, 4, 3))
        rise[..., 2] = top * np.arange(count + 1)[:, None] / count + (0 if lift is None else lift[j, i])
        nodes.append((ground + rise).reshape(-1, 3))
        cells.append(first + 4 * np.arange(count)[:, None] + np.arange(8))
        first += 4 * (count + 1)
    asked = mass.asked() if mass.stretch is None else float(mean.sum()) * h * h
    surface = np.zeros((*mean.shape, 4))
    surface[tuple(within.T)] = high + (0 if lift is None else lift[tuple(within.T)][:, None])
    return Columns(np.concatenate(nodes), np.concatenate(cells), asked, float(filled), mean, surface)
