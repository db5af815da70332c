# SPDX-License-Identifier: BSD-3-Clause
"""Rigid walls of triangles, such as terrain, for pictures of scenes in space: coarse enough to be drawn."""

import numpy as np

from plotting.contact import contact_series
from plotting.results import Results

MOST = 20_000  # triangles of a picture
FLOOR = np.array([0.80, 0.77, 0.72])


def ground_of(results: Results, most: int = MOST) -> np.ndarray:
    """Triangles at their place at the start, n x 3 x 3 [m], anticlockwise as seen from the soil; none in 2D."""
    walls = results.settings("mpm.json").get("rigid_walls", []) if results.dim == 3 else []
    names = [wall["name"] for wall in walls if "triangles" in wall.get("surface", {})]
    series = contact_series(results) if names else {}
    found = [np.zeros((0, 3, 3))]
    for name in names:
        if name in series:
            frame = series[name].frame(0)
            if frame.cells is not None and frame.cells.shape[1] == 3:
                found.append(coarse(frame.points, frame.cells, most))
    return np.concatenate(found)


def coarse(points: np.ndarray, triangles: np.ndarray, most: int) -> np.ndarray:
    """Corners of the triangles, or of fewer: vertices of one cell of a lattice in space become one, in their mean."""
    span = np.ptp(points, axis=0).max()
    size = span / 2048
    corners = points[triangles]
    while len(corners) > most:
        cell = np.floor((points - points.min(axis=0)) / size).astype(int)
        _, number = np.unique(cell, axis=0, return_inverse=True)
        number = number.ravel()
        count = np.bincount(number)
        mean = np.column_stack([np.bincount(number, weights=points[:, k]) / count for k in range(3)])
        left = number[triangles]
        apart = (left[:, 0] != left[:, 1]) & (left[:, 1] != left[:, 2]) & (left[:, 2] != left[:, 0])
        corners = mean[left[apart]]
        size *= 1.3
    return corners
