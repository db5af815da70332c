# SPDX-License-Identifier: BSD-3-Clause
"""The slope on the lattice of the grid, and the soil on it as columns; all in local coordinates [m]."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .raster import TerrainError

# Columns with less than this share of a cell are left out: their points would be a sixteenth of a cell.
THINNEST = 0.25
MOST_PIECES = 4  # of a side of a cell, for facets: cliffs would ask for more without end
MOST_CELLS = 10_000_000  # of the mass: 100 times what a run on a workstation has
SAMPLES = 8  # of a column along each side, for its mean depth


@dataclass
class Slope:
    """Heights at the nodes of a lattice from (0, 0), rows along x first: z[j, i]; bilinear between them."""

    spacing: float
    z: np.ndarray

    def size(self) -> tuple[float, float]:
        return (self.z.shape[1] - 1) * self.spacing, (self.z.shape[0] - 1) * self.spacing

    def require_inside(self, places: np.ndarray, where: str) -> None:
        """places: any shape x 2. @raises TerrainError"""
        if (places < 0).any() or (places > self.size()).any():
            raise TerrainError(f"{where}: found a part outside the area, allowed: the area of the grid")

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        rows, columns = self.z.shape
        s, t = np.asarray(x) / self.spacing, np.asarray(y) / self.spacing
        i, j = np.clip(np.floor(s), 0, columns - 2).astype(int), np.clip(np.floor(t), 0, rows - 2).astype(int)
        a, b = s - i, t - j
        z = self.z
        return ((1 - a) * (1 - b) * z[j, i] + a * (1 - b) * z[j, i + 1] + (1 - a) * b * z[j + 1, i]
                + a * b * z[j + 1, i + 1])

    def cut(self, pieces: int) -> "Slope":
        """The same surface on a finer lattice: its facets follow warped cells more closely."""
        rows, columns = self.z.shape
        x = np.arange(pieces * (columns - 1) + 1) * (self.spacing / pieces)
        y = np.arange(pieces * (rows - 1) + 1) * (self.spacing / pieces)
        return Slope(self.spacing / pieces, self.at(x[None, :], y[:, None]))

    def longest_edge(self) -> float:
        """Of its facets [m]."""
        z, h = self.z, self.spacing
        along = max(np.abs(np.diff(z, axis=0)).max(), np.abs(np.diff(z, axis=1)).max())
        across = np.minimum(np.abs(z[:-1, :-1] - z[1:, 1:]), np.abs(z[:-1, 1:] - z[1:, :-1])).max()
        return float(max(np.hypot(h, along), np.hypot(np.sqrt(2) * h, across)))

    def facets(self) -> "Slope":
        """Cut so often that no facet is longer than the diagonal of half a cell, as the soil asks of curved surfaces, up to
        four times, which a slope of 70 degrees takes.

        At least in two: a fold along the diagonal of a whole cell would be felt by points a quarter of a cell deep.
        """
        pieces = 2
        while pieces < MOST_PIECES and self.cut(pieces).longest_edge() > np.sqrt(0.5) * self.spacing:
            pieces += 1
        return self.cut(pieces)


def write_ply(slope: Slope, path: Path) -> int:
    """Two triangles a cell, which look up, as bytes in single precision, enough for local coordinates; returns their number."""
    rows, columns = slope.z.shape
    x, y = np.meshgrid(np.arange(columns) * slope.spacing, np.arange(rows) * slope.spacing)
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    height = slope.z.ravel()
    rising = (np.abs(height[a] - height[c]) <= np.abs(height[b] - height[d]))[..., None, None]  # shorter diagonal
    corners = np.where(rising, np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2),
                       np.stack([np.stack([a, b, d], -1), np.stack([b, c, d], -1)], -2)).reshape(-1, 3)
    faces = np.empty(len(corners), dtype=[("size", "u1"), ("corners", "<i4", 3)])
    faces["size"], faces["corners"] = 3, corners
    head = ("ply\nformat binary_little_endian 1.0\ncomment terrain in local coordinates\n"
            f"element vertex {number.size}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    nodes = np.empty(number.size, dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4")])
    nodes["x"], nodes["y"], nodes["z"] = x.ravel(), y.ravel(), slope.z.ravel()
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


Depth = Callable[[np.ndarray, np.ndarray], np.ndarray]  # of the soil at places, 0: none [m]


def mean_depths(slope: Slope, depth: Depth) -> tuple[np.ndarray, np.ndarray]:
    """Mean of each cell of the lattice, and whether soil covers all of it."""
    rows, columns = slope.z.shape[0] - 1, slope.z.shape[1] - 1
    x = (np.arange(columns * SAMPLES) + 0.5) * slope.spacing / SAMPLES
    y = (np.arange(rows * SAMPLES) + 0.5) * slope.spacing / SAMPLES
    samples = depth(*np.meshgrid(x, y)).reshape(rows, SAMPLES, columns, SAMPLES)
    return samples.mean(axis=(1, 3)), (samples > 0).all(axis=(1, 3))


def lay_columns(slope: Slope, depth: Depth) -> Columns:
    """A column a cell of the lattice, cut into layers of at most a cell: its volume is that of the soil above the cell.

    The bottom is the slope. The top follows the soil where it covers the cell, and is parallel to the slope at its rim.
    """
    h = slope.spacing
    mean, covered = mean_depths(slope, depth)
    if not np.ceil(mean / h).sum() <= MOST_CELLS:
        row, column = np.unravel_index(np.argmax(mean), mean.shape)
        raise TerrainError(f"the mass is {mean.max():.6g} m deep at ({(column + 0.5) * h:.9g}, {(row + 0.5) * h:.9g}) "
                           f"of the scene: its columns need {np.ceil(mean / h).sum():.3g} cells of {h:g} m, allowed: "
                           f"{MOST_CELLS:.0e}")
    rows, columns = slope.z.shape
    grid = np.meshgrid(np.arange(columns) * h, np.arange(rows) * h)
    at_nodes = depth(*grid)
    nodes: list[np.ndarray] = []
    cells: list[np.ndarray] = []
    for j, i in np.argwhere(mean >= THINNEST * h):
        corners = np.array([(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)])
        bottom = slope.z[corners[:, 0], corners[:, 1]]
        high = at_nodes[corners[:, 0], corners[:, 1]]
        # A bilinear top has the mean of its corners: scaled, it has the volume of the soil.
        whole = covered[j, i] and high.min() >= THINNEST * h
        high = high * (mean[j, i] / high.mean()) if whole else np.full(4, mean[j, i])
        layers = max(1, int(np.ceil(high.max() / h - 1e-9)))
        first = len(nodes)
        for k in range(layers + 1):
            for corner in range(4):
                nodes.append(np.array([corners[corner, 1] * h, corners[corner, 0] * h,
                                       bottom[corner] + high[corner] * k / layers]))
        for k in range(layers):
            cells.append(first + 4 * k + np.arange(8))
    filled = mean[mean >= THINNEST * h].sum() * h * h
    return Columns(np.array(nodes), np.array(cells), float(mean.sum() * h * h), float(filled), mean)


def write_hexahedra(nodes: np.ndarray, cells: np.ndarray, path: Path, groups: dict[str, np.ndarray] | None = None) -> None:
    """Gmsh 4.1 as text. groups: facets m x 4 by the name of their group."""
    groups = groups or {}
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat"]
    if groups:
        lines += ["$PhysicalNames", str(len(groups)), *(f'2 {k + 1} "{name}"' for k, name in enumerate(groups)),
                  "$EndPhysicalNames", "$Entities", f"0 0 {len(groups)} 1"]
        box = " ".join(f"{v:.9g}" for v in (*nodes.min(axis=0), *nodes.max(axis=0)))
        lines += [f"{k + 1} {box} 1 {k + 1} 0" for k in range(len(groups))] + [f"1 {box} 0 0", "$EndEntities"]
    lines += ["$Nodes", f"1 {len(nodes)} 1 {len(nodes)}", f"3 1 0 {len(nodes)}",
              *(str(k + 1) for k in range(len(nodes))), *(f"{x:.12g} {y:.12g} {z:.12g}" for x, y, z in nodes), "$EndNodes"]
    total = len(cells) + sum(len(facets) for facets in groups.values())
    lines += ["$Elements", f"{1 + len(groups)} {total} 1 {total}"]
    tag = 0
    for kind, dimension, entity, rows in [(3, 2, k + 1, facets) for k, facets in enumerate(groups.values())] + [
            (5, 3, 1, cells)]:
        lines.append(f"{dimension} {entity} {kind} {len(rows)}")
        for row in rows:
            tag += 1
            lines.append(f"{tag} " + " ".join(str(v + 1) for v in row))
    path.write_text("\n".join([*lines, "$EndElements", ""]), encoding="ascii")
