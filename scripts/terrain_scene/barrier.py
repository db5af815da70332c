# SPDX-License-Identifier: BSD-3-Clause
"""A wall along a line on the slope, as hexahedra."""

from dataclasses import dataclass

import numpy as np

from .raster import TerrainError
from .slope import Slope


@dataclass
class Wall:
    """Hexahedra with the facet groups `foot`, the part in the ground, and `faces`, which soil can reach."""

    nodes: np.ndarray
    cells: np.ndarray
    groups: dict[str, np.ndarray]
    crest: np.ndarray  # place [m] in the middle of the top: across exactly, along at the station nearest to it


LEAST_THROUGH = 2  # cells through the thickness
MOST_CELLS = 500_000


def mitred(line: np.ndarray, thickness: float) -> np.ndarray:
    """Vectors from the line to the left face at each of its corners, n x 2, half the thickness across each segment."""
    along = np.diff(line, axis=0)
    lengths = np.linalg.norm(along, axis=1)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / lengths[:, None]
    ways = [left[0]]
    for k, (before, after) in enumerate(zip(left[:-1], left[1:]), 1):
        if before @ after < 0.5:
            x, y = line[k]
            turn = np.degrees(np.arccos(before @ after))
            raise TerrainError(f"barrier/line/{k}: found a turn by {turn:.0f} degrees at ({x:.9g}, {y:.9g}), "
                               "allowed: up to 60 degrees; two corners make a sharper one")
        ways.append((before + after) / (1 + before @ after))
    return np.array([*ways, left[-1]]) * thickness / 2


def stations(line: np.ndarray, ways: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """The line and its vectors to the left in pieces of at most `spacing`."""
    places, asides = [line[0]], [ways[0]]
    for k in range(len(line) - 1):
        pieces = int(np.ceil(np.linalg.norm(line[k + 1] - line[k]) / spacing - 1e-9))
        for i in range(1, pieces + 1):
            places.append(line[k] + (line[k + 1] - line[k]) * i / pieces)
            asides.append(ways[k] + (ways[k + 1] - ways[k]) * i / pieces)
    return np.array(places), np.array(asides)


def build_wall(slope: Slope, line: np.ndarray, height: float, thickness: float) -> Wall:
    """Upright on the slope, `height` above its line, a cell deep in the ground; facets of half a cell at most.

    @raises TerrainError  it leaves the area, has too many cells, or a line that cannot be built on
    """
    h = slope.spacing
    slope.require_inside(line, "barrier/line")
    for k in range(len(line) - 1):
        if not np.linalg.norm(line[k + 1] - line[k]) > 0:
            raise TerrainError(f"barrier/line/{k + 1}: found the corner before it again, allowed: corners that differ")
    ways = mitred(line, thickness)
    fine = stations(line, ways, h / 8)[0]
    slope.require_known(slope.at(*fine.T), fine, "barrier/line")
    steep = np.abs(np.diff(slope.at(*fine.T)) / np.linalg.norm(np.diff(fine, axis=0), axis=1)).max()
    # Round a corner the outer face is longer than the line.
    lengths = [np.linalg.norm(np.diff(line + side * ways, axis=0), axis=1) for side in (0, -1, 1)]
    widened = max((length / lengths[0]).max() for length in lengths)
    places, asides = stations(line, ways, h / 2 / np.hypot(1, steep) / widened)
    rim = places[:, None, :] + np.array([-1, 1])[None, :, None] * asides[:, None, :]  # station, side, axis
    slope.require_inside(rim, "barrier/line")
    slope.require_known(slope.at(rim[..., 0], rim[..., 1]), rim, "barrier/line")
    fall = np.abs(np.diff(slope.at(rim[..., 0], rim[..., 1]))).max()
    through = max(LEAST_THROUGH, int(np.ceil(np.hypot(thickness, fall) / (h / 2) - 1e-9)))
    x = places[:, None, :] + np.linspace(-1, 1, through + 1)[None, :, None] * asides[:, None, :]
    ground = slope.at(x[..., 0], x[..., 1])
    # The wall meets the ground on both sides; its crest is level across.
    higher = 1 + (slope.at(*places.T)[:, None] - ground) / height
    layers = int(np.ceil(height * higher.max() / min(h / 2, thickness / 2) - 1e-9))
    count = (len(places) - 1) * through * (layers + 1)
    if count > MOST_CELLS:
        raise TerrainError(f"barrier: found height {height:g} m and thickness {thickness:g} m, whose cells are half as "
                           f"long, or half a cell of the grid: {count} cells, allowed: {MOST_CELLS}")
    levels = np.array([-h, *np.linspace(0, height, layers + 1)])
    nodes = np.empty((*ground.shape, len(levels), 3))
    nodes[..., :2] = x[:, :, None, :]
    nodes[..., 2] = ground[:, :, None] + np.where(levels > 0, levels * higher[:, :, None], levels)
    number = np.arange(ground.size * len(levels)).reshape(*ground.shape, len(levels))
    a = number[:-1, :-1, :-1], number[1:, :-1, :-1], number[1:, 1:, :-1], number[:-1, 1:, :-1]
    b = number[:-1, :-1, 1:], number[1:, :-1, 1:], number[1:, 1:, 1:], number[:-1, 1:, 1:]
    cells = np.stack([*a, *b], axis=-1).reshape(-1, 8)

    def quads(sheet: np.ndarray) -> np.ndarray:
        return np.stack([sheet[:-1, :-1], sheet[1:, :-1], sheet[1:, 1:], sheet[:-1, 1:]], axis=-1).reshape(-1, 4)

    sides = [number[0], number[-1], number[:, 0], number[:, -1]]
    groups = {"foot": np.vstack([quads(number[:, :, 0]), *(quads(side[:, :2]) for side in sides)]),
              "faces": np.vstack([quads(number[:, :, -1]), *(quads(side[:, 1:]) for side in sides)])}
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    middle = int(np.argmin(np.abs(way - way[-1] / 2)))
    crest = nodes[middle, [through // 2, (through + 1) // 2], -1].mean(axis=0)
    return Wall(nodes.reshape(-1, 3), cells, groups, crest)
