# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies, boulders and rigid walls, in few bytes: a surface, and its pose in each frame."""

import base64
from collections.abc import Iterable
from typing import Any

import numpy as np

from plotting.contact import chain
from plotting.ground import coarse
from plotting.results import Results, ResultsError, Series
from plotting.space import rigid_walls
from plotting.walls import dropped_at

POSE_BYTES = 4 * 12
RIGID = 1e-3  # change of shape, over the size of the surface, that the digits of the frames explain


def text_of(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


def in_space(points: np.ndarray) -> np.ndarray:
    """num_points x 2 or 3 -> num_points x 3."""
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def pose(reference: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation R (3 x 3) and place c of the points' mean [m]: points = R reference + c (Kabsch 1976).

    reference: num_points x 3 with its mean at the origin.
    @raises ResultsError  another number of points, or another shape
    """
    if points.shape != reference.shape:
        raise ResultsError(f"a rigid surface with {len(reference)} nodes in one frame and {len(points)} in another")
    centre = points.mean(axis=0)
    left, _, right = np.linalg.svd(reference.T @ (points - centre))
    turn = right.T @ np.diag([1, 1, np.sign(np.linalg.det(right.T @ left.T))]) @ left.T
    off = np.abs(reference @ turn.T + centre - points).max()
    if off > RIGID * np.abs(reference).max() + 1e-6 * np.abs(points).max():
        raise ResultsError(f"a rigid surface changes its shape by {off:g} m")
    return turn, centre


def packed_poses(reference: np.ndarray, frames: Iterable[np.ndarray]) -> str:
    """Rows of R, then c of each frame, 12 numbers a frame."""
    found = [np.concatenate([turn.ravel(), centre]) for turn, centre in (pose(reference, in_space(points))
                                                                         for points in frames)]
    return text_of(np.array(found, dtype="<f4"))


def wide(points: np.ndarray) -> bool:
    """Whether numbers of these nodes need 32 bits."""
    return len(points) > 65535


def packed_boulder(name: str, series: Series, times: np.ndarray) -> dict[str, Any]:
    """Faces of a boulder, in 2D one, its outline; nodes about their mean as 16-bit parts of "radius" [m]; its pose in
    each frame."""
    first = series.frame(0)
    flat = first.points.shape[1] == 2 or first.cells.shape[1] == 2
    faces = first.cells[chain(first.cells)][:, 0][None] if flat else first.cells
    points = in_space(first.points)
    reference = points - points.mean(axis=0)
    radius = float(np.abs(reference).max())
    return {"name": name, "corners": faces.shape[1], "faces": text_of(faces.astype("<u4" if wide(points) else "<u2")),
            "wide": wide(points), "radius": radius,
            "points": text_of(np.round(32767 * reference / radius).astype("<i2")),
            "poses": packed_poses(reference, (series.frame(series.nearest(time)).points for time in times))}


def packed_boulders(results: Results, times: np.ndarray) -> list[dict[str, Any]]:
    names = results.boulders
    series = results.contacts if names else {}
    return [packed_boulder(name, series[name], times) for name in names]


def boulder_bytes(results: Results) -> tuple[int, int]:
    """Bytes of the shapes of all boulders, and of their poses in one frame."""
    names = results.boulders
    series = results.contacts if names else {}
    firsts = [series[name].frame(0) for name in names]
    shapes = sum(6 * len(first.points) + (2 + 2 * wide(first.points)) * first.cells.size for first in firsts)
    return shapes, POSE_BYTES * len(names)


def triangles_of(faces: np.ndarray) -> np.ndarray:
    """Faces of three or more corners, as fans."""
    return np.concatenate([faces[:, [0, k, k + 1]] for k in range(1, faces.shape[1] - 1)])


def packed_walls(results: Results, times: np.ndarray, most: int) -> list[dict[str, Any]]:
    """Rigid walls of a scene in space as triangles, anticlockwise as seen from the soil: corners as 16-bit numbers
    of a box of their own, poses of those that move, until when [s] those act that a phase drops, and whether each is
    ground.

    most: triangles of all walls.
    """
    settings = results.settings("mpm.json")
    names = [wall["name"] for wall in settings.get("rigid_walls", [])]
    series = results.contacts if names else {}
    dropped = dropped_at(names, settings.get("phases", []))
    present = [name for name in names if name in series and series[name].frame(0).cells is not None]
    if not present:
        tiles = rigid_walls(results)
        corners = [tile[triangles_of(np.arange(4)[None]).ravel()].reshape(-1, 3, 3) for wall in tiles for tile in wall]
        return [_wall(np.concatenate(corners)) | {"poses": None, "until": None, "ground": False}] if corners else []
    ground = {wall["name"] for wall in settings["rigid_walls"] if "triangles" in wall.get("surface", {})}
    packed = []
    for name in present:
        first = series[name].frame(0)
        triangles = coarse(first.points, triangles_of(first.cells), max(200, most // len(present)))
        frames = [series[name].frame(series[name].nearest(time)).points for time in times]
        at_rest = all(points.shape == first.points.shape and np.allclose(points, first.points, rtol=0, atol=1e-9)
                      for points in frames)
        centre = first.points.mean(axis=0)
        poses = None if at_rest else packed_poses(first.points - centre, frames)
        packed.append(_wall(triangles - (0 if at_rest else centre)) | {"poses": poses, "until": dropped.get(name),
                                                                       "ground": name in ground})
    return packed


def _wall(triangles: np.ndarray) -> dict[str, Any]:
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    share = (triangles - low) / np.maximum(high - low, 1e-300)
    return {"low": low.tolist(), "high": high.tolist(), "corners": text_of(np.round(65535 * share).astype("<u2"))}
