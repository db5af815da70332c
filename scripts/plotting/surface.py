# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a cloud of points in space, by marching tetrahedra on their smoothed density."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np

MARGIN = 4  # voxels around the points
SMOOTHING = 2  # times [1/4, 1/2, 1/4] along each axis: some 0.7 of the distance of points
LEVEL = 0.4  # of the density inside: edges of bodies belong to the surface
MAX_VOXELS = 8_000_000

# A voxel as six tetrahedra around its diagonal (Kuhn), by the numbers x + 2 y + 4 z of its corners.
TETRAHEDRA = [[0, 1 << a, (1 << a) | (1 << b), 7] for a, b, _ in permutations(range(3))]


@dataclass
class Surface:
    """Triangles of a surface.

    triangles: num_triangles x 3 corners x 3 [m]; normals: unit, outwards, at their centres; values: there;
    loose: numbers of the points that lie outside of it, such as single ones.
    """

    triangles: np.ndarray
    normals: np.ndarray
    values: np.ndarray
    loose: np.ndarray


def surface_of(points: np.ndarray, values: np.ndarray, size: float) -> Surface:
    """Surface on which the density of the points has fallen to LEVEL of that of a lattice with this distance `size`
    [m].

    values: one a point.
    """
    low = points.min(axis=0) - MARGIN * size
    shape = np.ceil((points.max(axis=0) + MARGIN * size - low) / size).astype(int) + 1
    if np.prod(shape) > MAX_VOXELS:  # a few points that have flown far off
        size *= (np.prod(shape) / MAX_VOXELS) ** (1 / 3) * 1.05
        shape = np.ceil((points.max(axis=0) + MARGIN * size - low) / size).astype(int) + 1
    density, weighted = (_smooth(_deposit((points - low) / size, weights, shape))
                         for weights in (np.ones(len(points)), values))
    triangles = _march(density, LEVEL)
    centres = triangles.mean(axis=1)
    gradient = np.stack([_sample(g, centres) for g in np.gradient(density)], axis=1)
    normals = -gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-300)
    mean = _sample(weighted, centres) / np.maximum(_sample(density, centres), 1e-300)
    loose = np.flatnonzero(_sample(density, (points - low) / size) < LEVEL)
    return Surface(low + size * triangles, normals, mean, loose)


def _corners(places: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Indices of the 8 voxel corners around each place, and their weights for linear interpolation."""
    base = np.floor(places).astype(int)
    part = places - base
    found = []
    for corner in range(8):
        step = np.array([corner & 1, corner >> 1 & 1, corner >> 2 & 1])
        found.append((base + step, np.prod(np.where(step, part, 1 - part), axis=1)))
    return found


def _deposit(places: np.ndarray, weights: np.ndarray, shape: np.ndarray) -> np.ndarray:
    field = np.zeros(shape)
    for index, share in _corners(places):
        np.add.at(field, tuple(index.T), share * weights)
    return field


def _sample(field: np.ndarray, places: np.ndarray) -> np.ndarray:
    return sum(share * field[tuple(index.T)] for index, share in _corners(places))


def _smooth(field: np.ndarray) -> np.ndarray:
    for _ in range(SMOOTHING):
        for axis in range(3):
            field = 0.5 * field + 0.25 * (np.roll(field, 1, axis) + np.roll(field, -1, axis))
    return field


def _march(field: np.ndarray, level: float) -> np.ndarray:
    """Triangles of field = level in units of voxels, num_triangles x 3 x 3."""
    inside = field > level
    n = np.array(field.shape) - 1
    cells = np.zeros(n, dtype=int)
    for corner in range(8):
        x, y, z = corner & 1, corner >> 1 & 1, corner >> 2 & 1
        cells += inside[x:x + n[0], y:y + n[1], z:z + n[2]]
    cut = np.argwhere((cells > 0) & (cells < 8))
    steps = np.array([[c & 1, c >> 1 & 1, c >> 2 & 1] for c in range(8)])
    found = [np.zeros((0, 3, 3))]
    for tetrahedron in TETRAHEDRA:
        corners = cut[:, None] + steps[tetrahedron][None]
        values = field[tuple(np.moveaxis(corners, -1, 0))] - level
        found += _cut_tetrahedra(corners.astype(float), values)
    return np.concatenate(found)


def _cut_tetrahedra(corners: np.ndarray, values: np.ndarray) -> list[np.ndarray]:
    """Triangles where linear values on tetrahedra vanish. corners: n x 4 x 3, values: n x 4"""
    found = []
    codes = (values > 0) @ np.array([1, 2, 4, 8])
    for code in range(1, 15):
        rows = codes == code
        x, v = corners[rows], values[rows]
        plus = [k for k in range(4) if code >> k & 1]
        minus = [k for k in range(4) if not code >> k & 1]

        def crossing(a: int, b: int) -> np.ndarray:
            part = v[:, a] / (v[:, a] - v[:, b])
            return x[:, a] + part[:, None] * (x[:, b] - x[:, a])

        if len(plus) == 2:
            a, b, c, d = (crossing(p, m) for p, m in ((plus[0], minus[0]), (plus[0], minus[1]), (plus[1], minus[1]),
                                                      (plus[1], minus[0])))
            found += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
        else:
            alone, others = (plus[0], minus) if len(plus) == 1 else (minus[0], plus)
            found.append(np.stack([crossing(alone, other) for other in others], axis=1))
    return found
