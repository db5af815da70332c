# SPDX-License-Identifier: BSD-3-Clause
"""The plane in which a scene is drawn, and the faces of a mesh that are seen there."""

from dataclasses import dataclass

import numpy as np

AXES = "xyz"

# Faces of a cell in space, anticlockwise from outside, by the number of its nodes: tetrahedron, hexahedron.
FACES = {
    4: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    8: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}


def up_axis(dim: int, gravity: list[float] | None) -> int:
    """The axis along which gravity is strongest; the last one without gravity, and y in 2D."""
    if dim == 2:
        return 1
    return int(np.argmax(np.abs(gravity))) if gravity and np.any(gravity) else dim - 1


@dataclass(frozen=True)
class View:
    """The axes that are drawn to the right and upwards.

    across, up: axes 0 to 2; inverted: gravity points along +up, so that axis is drawn downwards;
    dim: of the scene.
    """

    across: int = 0
    up: int = 1
    inverted: bool = False
    dim: int = 2

    @property
    def labels(self) -> tuple[str, str]:
        return f"{AXES[self.across]} [m]", f"{AXES[self.up]} [m]"

    def project(self, points: np.ndarray) -> np.ndarray:
        """Any shape x (2 or 3) -> the same shape x 2."""
        return points[..., [self.across, self.up]]

    def order(self, points: np.ndarray) -> np.ndarray:
        """Order in which points (num_points x 3) are drawn: those nearest to the eye last."""
        if self.dim == 2:
            return np.arange(len(points))
        towards_eye = 1 if (self.up - self.across) % 3 == 1 else -1
        depth = points[:, 3 - self.across - self.up] * (-towards_eye if self.inverted else towards_eye)
        return np.argsort(depth, kind="stable")

    def faces(self, points: np.ndarray, cells: np.ndarray) -> np.ndarray:
        """The faces of a mesh that are drawn, num_faces x corners.

        In 2D its cells, in space the outer faces that are turned to the eye.
        """
        if self.dim == 2 or cells.shape[1] not in FACES:
            return cells
        faces = outer_faces(cells)
        x, y = np.moveaxis(self.project(points[faces]), -1, 0)
        area = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
        area = -area if self.inverted else area
        faces = faces[area > 1e-6 * np.max(np.abs(area))]  # not those seen edgewise
        return faces[self.order(points[faces].mean(axis=1))]


def view_of(dim: int, gravity: list[float] | None, extent: np.ndarray) -> View:
    """The plane that holds gravity and, as far as that leaves a choice, the longest horizontal extent.

    gravity: dim components [m/s^2] or None; extent: of the scene along each axis [m].
    """
    if dim == 2:
        return View()
    up = up_axis(dim, gravity)
    g = np.array(gravity if gravity and np.any(gravity) else [0.0, 0.0, -1.0])
    level = [axis for axis in range(3) if axis != up]
    inclined = np.abs(g[level]) > 1e-9 * abs(g[up])
    across = level[int(np.argmax(np.abs(g[level]) if inclined.any() else np.asarray(extent)[level]))]
    return View(across, up, bool(g[up] > 0), dim)


def plane_view(dim: int, plane: str) -> View:
    """The plane of two axes, to the right and upwards, such as "xy": seen from above where z is the vertical."""
    return View(AXES.index(plane[0]), AXES.index(plane[1]), False, dim)


def outer_faces(cells: np.ndarray) -> np.ndarray:
    """Faces of cells in space that belong to one cell only, num_faces x corners."""
    return once(_faces(cells))


def cells_of_outer_faces(cells: np.ndarray) -> np.ndarray:
    """Number of the cell of each of `outer_faces`."""
    return _which_are_once(_faces(cells)) % len(cells)


def _faces(cells: np.ndarray) -> np.ndarray:
    """First faces of all cells, then second ones, and so on."""
    return np.concatenate([cells[:, corners] for corners in FACES[cells.shape[1]]])


def once(facets: np.ndarray) -> np.ndarray:
    """Rows of node numbers that are there once, whatever the order of their nodes."""
    return facets[_which_are_once(facets)]


def _which_are_once(facets: np.ndarray) -> np.ndarray:
    _, index, count = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    return index[count == 1]
