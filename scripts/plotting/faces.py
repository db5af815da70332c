# SPDX-License-Identifier: BSD-3-Clause
"""Upright faces of a surface in contact with soil, and the pressure over their height."""

from dataclasses import dataclass

import numpy as np

from plotting.results import Frame, Series
from plotting.view import AXES

UPRIGHT = 0.5  # largest vertical part of the unit normal of a facet of an upright face
SAME = 0.87  # cosine between normals of one face
HEIGHTS = 60  # at most, over which the pressure on a face is given


def facet_vectors(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Area vectors of facets in space, normal times area; of segments their direction times length."""
    corners = points[cells]
    if cells.shape[1] == 2:
        return corners[:, 1] - corners[:, 0]
    fans = [np.cross(corners[:, k] - corners[:, 0], corners[:, k + 1] - corners[:, 0])
            for k in range(1, cells.shape[1] - 1)]
    return 0.5 * np.sum(fans, axis=0)


@dataclass(frozen=True)
class Face:
    """Pressure on an upright face: mean over the facets at each height, frame x height [Pa].

    side: the axis to which it looks; height: above the lowest point of the surface [m]; ends:
    lowest and highest point of the face, likewise [m]; times: of the frames [s].
    """

    surface: str
    side: str
    height: np.ndarray
    times: np.ndarray
    pressure: np.ndarray
    ends: tuple[float, float]

    @property
    def edges(self) -> np.ndarray:
        """Borders of the heights [m]: the ends of the face, between them the middles of neighbours."""
        return np.concatenate([self.ends[:1], (self.height[1:] + self.height[:-1]) / 2, self.ends[1:]])


def normals_of(frame: Frame, dim: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals into the soil and sizes of facets [m] or [m^2]."""
    vectors = facet_vectors(frame.points, frame.cells)
    if dim == 2:  # the soil lies to the right of a line
        vectors = np.column_stack([vectors[:, 1], -vectors[:, 0], np.zeros(len(vectors))])
    size = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(size > 0, size, 1)[:, None], size


def faces_of(name: str, series: Series, dim: int, up: int) -> list[Face]:
    """Upright faces of a surface, by the side to which they look."""
    first = series.frame(0)
    normals, size = normals_of(first, dim)
    centres = first.points[first.cells].mean(axis=1)[:, up] - first.points[:, up].min()
    left = np.flatnonzero((np.abs(normals[:, up]) <= UPRIGHT) & (size > 0))
    values = np.array([series.frame(k).fields["pressure"] for k in range(len(series))])
    found = []
    while len(left):
        like = normals[left] @ normals[left[0]] > SAME
        face, left = left[like], left[~like]
        heights = np.unique(centres[face].round(9))
        if len(heights) > HEIGHTS:
            edges = np.linspace(heights[0], heights[-1], HEIGHTS + 1)
            heights = (edges[1:] + edges[:-1]) / 2
            row = np.clip(np.searchsorted(edges, centres[face], side="right") - 1, 0, HEIGHTS - 1)
        else:
            row = np.argmin(np.abs(centres[face][:, None] - heights[None, :]), axis=1)
        area = np.bincount(row, size[face], len(heights))
        total = np.array([np.bincount(row, size[face] * each[face], len(heights)) for each in values])
        kept = area > 0
        axis = int(np.argmax(np.abs(normals[face[0]])))
        side = ("-" if normals[face[0], axis] < 0 else "+") + AXES[axis]
        reach = first.points[first.cells[face]][..., up] - first.points[:, up].min()
        found.append(Face(name, side, heights[kept], series.times, total[:, kept] / area[kept],
                          (float(reach.min()), float(reach.max()))))
    return found


def upright_share(frame: Frame, dim: int, up: int) -> float:
    """Part of the area of a surface that is upright."""
    normals, size = normals_of(frame, dim)
    return float(size[np.abs(normals[:, up]) <= UPRIGHT].sum() / size.sum())
