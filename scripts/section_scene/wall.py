# SPDX-License-Identifier: BSD-3-Clause
"""The wall of a section with its footing, as one mesh of quadrilaterals."""

from dataclasses import dataclass

import numpy as np
from terrain_scene.raster import TerrainError

from .columns import holes, lowest_ground, underside
from .lines import Line
from .plan import Plan

LEAST_THROUGH = 2  # cells through the thickness
MOST_CELLS = 500_000


@dataclass
class WallMesh:
    """Quadrilaterals that share their nodes, with the facet groups `foot`, which is held, and `faces`.

    crest: middle of the top; middle: of the underside, for moments [m].
    """

    nodes: np.ndarray
    cells: np.ndarray
    groups: dict[str, np.ndarray]
    crest: np.ndarray
    middle: np.ndarray


def pieces_between(places: list[float], size: float) -> list[tuple[float, float, int]]:
    """Pairs of neighbouring places, and the number of pieces of at most `size` between them."""
    cuts = sorted(set(places))
    return [(a, b, max(1, int(np.ceil((b - a) / size - 1e-9)))) for a, b in zip(cuts[:-1], cuts[1:])]


def ticks(pieces: list[tuple[float, float, int]]) -> np.ndarray:
    """The ends of all pieces."""
    return np.concatenate([*(np.linspace(a, b, number + 1)[:-1] for a, b, number in pieces), [pieces[-1][1]]])


def build_wall(plan: Plan, base: Line) -> WallMesh:
    """Facets of half a cell at most. Held: the underside, and what lies below the rigid base. @raises TerrainError"""
    size = min(plan.cell_size / 2, plan.wall.thickness / LEAST_THROUGH)
    parts = holes(plan)
    along = pieces_between([v for left, right, _, _ in parts for v in (left, right)], size)
    # The wall gets a row of nodes at the ground beside it, since its surface in contact with soil begins there where
    # the base is the ground.
    heights = [v for _, _, bottom, top in parts for v in (bottom, top)] + [lowest_ground(plan)]
    up = pieces_between(heights, size)
    count = sum(number for *_, number in along) * sum(number for *_, number in up)
    if count > MOST_CELLS:
        raise TerrainError(f"wall: found {count} cells of {size:.3g} m around it, allowed: {MOST_CELLS}")
    x, z = ticks(along), ticks(up)
    middles = (x[:-1] + x[1:]) / 2, (z[:-1] + z[1:]) / 2
    inside = np.zeros((len(x) + 1, len(z) + 1), dtype=bool)  # a row of cells outside on each side
    for left, right, bottom, top in parts:
        inside[1:-1, 1:-1] |= (((middles[0] > left) & (middles[0] < right))[:, None]
                               & ((middles[1] > bottom) & (middles[1] < top))[None, :])
    number = np.arange(len(x) * len(z)).reshape(len(x), len(z))
    i, j = np.nonzero(inside[1:-1, 1:-1])
    cells = np.stack([number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]], axis=-1)
    upright = np.argwhere(inside[:-1, 1:-1] != inside[1:, 1:-1])
    flat = np.argwhere(inside[1:-1, :-1] != inside[1:-1, 1:])
    facets = np.concatenate([np.stack([number[upright[:, 0], upright[:, 1]], number[upright[:, 0], upright[:, 1] + 1]],
                                      axis=-1),
                             np.stack([number[flat[:, 0], flat[:, 1]], number[flat[:, 0] + 1, flat[:, 1]]], axis=-1)])
    nodes = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    buried = nodes[:, 1] <= base.at(nodes[:, 0]) + 1e-9 * plan.cell_size
    low = nodes[:, 1] <= underside(plan) + 1e-9 * plan.cell_size
    foot = low[facets].all(axis=1) | buried[facets].all(axis=1)
    used, place = np.unique(cells, return_inverse=True)
    place_of = np.full(len(nodes), -1)
    place_of[used] = np.arange(len(used))
    wall, (left, right) = plan.wall, plan.wall.reach()
    return WallMesh(nodes[used], place.reshape(cells.shape),
                    {"foot": place_of[facets[foot]], "faces": place_of[facets[~foot]]},
                    np.array([wall.at + wall.thickness / 2, z[-1]]), np.array([(left + right) / 2, underside(plan)]))
