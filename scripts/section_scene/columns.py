# SPDX-License-Identifier: BSD-3-Clause
"""The soil of a section as upright columns of quadrilaterals, whose area is that of the plan."""

from dataclasses import dataclass

import numpy as np
from terrain_scene.raster import TerrainError

from .lines import Line, crossings, level
from .plan import Plan

NEAR = 0.25  # of a cell: a column of the grid is not cut so near to a point of a line
ZERO = 1e-9  # of a cell: a thickness that is round-off
TIP = 1e-3  # of the other side: how high a side of a column is where the soil ends in a tip
MOST_CELLS = 1_000_000


@dataclass
class Mass:
    """Quadrilaterals of one material: nodes n x 2 [m], cells m x 4; area [m^2] of the plan, and deepest column [m]."""

    name: str
    nodes: np.ndarray
    cells: np.ndarray
    area: float
    deepest: float

    def cell_area(self) -> float:
        """Sum over the cells [m^2]."""
        x, z = np.moveaxis(self.nodes[self.cells], -1, 0)
        return float(sum((x[:, k] * z[:, (k + 1) % 4] - x[:, (k + 1) % 4] * z[:, k]).sum() for k in range(4)) / 2)


def boundaries(plan: Plan) -> list[Line]:
    """The ground and the bottom of each layer as the plan has it."""
    return [plan.ground, *(layer.bottom for layer in plan.layers)]


def holes(plan: Plan) -> list[tuple[float, float, float, float]]:
    """Rectangles of the wall and its footing: left, right, underside, top [m]."""
    wall = plan.wall
    if wall is None:
        return []
    bottom, right = underside(plan), wall.at + wall.thickness
    stem = (wall.at, right, bottom, lowest_ground(plan) + wall.height)
    if wall.footing is None:
        return [stem]
    top = bottom + wall.footing.thickness
    low, high = wall.reach()
    sides = [(low, wall.at, bottom, top), stem, (right, high, bottom, top)]
    return [each for each in sides if each[0] < each[1]]


def lowest_ground(plan: Plan) -> float:
    """Lowest ground under the wall and its footing [m]."""
    left, right = plan.wall.reach()
    inner = plan.ground.x[(plan.ground.x > left) & (plan.ground.x < right)]
    return float(plan.ground.at(np.array([left, *inner, right])).min())


def underside(plan: Plan) -> float:
    return lowest_ground(plan) - plan.wall.depth


def column_sides(plan: Plan) -> np.ndarray:
    """Places between which every line is straight, no two cross and the wall has no face; columns at most a cell
    wide."""
    h, ends = plan.cell_size, plan.ends()
    lines = boundaries(plan)
    rims = [[v for left, right, _, _ in holes(plan) for v in (left, right)]]
    if plan.slide is not None:
        lines.append(plan.slide.top)
    for bottom, top in {(bottom, top) for _, _, bottom, top in holes(plan)}:
        lines += [level(bottom, ends), level(top, ends)]
    needed = np.unique(np.concatenate([line.x for line in lines] + rims))
    needed = np.unique(np.concatenate([needed, crossings(lines, needed)]))
    needed = needed[np.concatenate([[True], np.diff(needed) > ZERO * h])]
    raster = ends[0] + h * np.arange(1, int(np.ceil((ends[1] - ends[0]) / h - ZERO)))
    gap = np.abs(raster[:, None] - needed[None, :]).min(axis=1)
    sides = np.sort(np.concatenate([needed, raster[gap > NEAR * h]]))
    pieces = [np.linspace(a, b, int(np.ceil((b - a) / h - 1e-6)) + 1)[:-1] for a, b in zip(sides[:-1], sides[1:])]
    return np.concatenate([*pieces, sides[-1:]])


def bounds_in(plan: Plan, x: np.ndarray) -> np.ndarray:
    """Heights of the boundaries on both sides of each column, boundary x column x 2: no layer reaches into the one
    above it."""
    both = np.stack([x[:-1], x[1:]], axis=-1)
    return np.minimum.accumulate(np.array([line.at(both) for line in boundaries(plan)]), axis=0)


def pieces_of(low: np.ndarray, high: np.ndarray,
              inside: list[tuple[float, float]]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Bottom and top, on both sides, of the parts of a column without those between two heights."""
    parts = [(low, high)]
    for bottom, top in inside:
        parts = [cut for a, b in parts for cut in ((a, np.minimum(b, bottom)), (np.maximum(a, top), b))]
    return parts


def fill(name: str, columns: list[tuple[float, float, np.ndarray, np.ndarray]], h: float) -> Mass:
    """columns: left and right side, bottom and top on both of them. @raises TerrainError"""
    nodes: list[np.ndarray] = []
    cells: list[np.ndarray] = []
    first, area, deepest = 0, 0.0, 0.0
    for left, right, low, high in columns:
        thick = high - low
        thick = np.where(np.abs(thick) <= ZERO * h, 0, thick)
        if not thick.max() > 0:
            continue
        area += (right - left) * thick.mean()
        deepest = max(deepest, float(thick.max()))
        if thick.min() == 0:  # a triangle becomes a quadrilateral of the same area
            thick = np.where(thick == 0, TIP * thick.max(), (1 - TIP) * thick)
        high = low + thick
        count = max(1, int(np.ceil((high - low).max() / h - 1e-9)))
        share = np.arange(count + 1)[:, None] / count
        z = low + share * (high - low)
        nodes.append(np.stack([np.tile([left, right], (count + 1, 1)), z], axis=-1).reshape(-1, 2))
        row = first + 2 * np.arange(count)[:, None]
        cells.append(row + np.array([0, 1, 3, 2]))
        first += 2 * (count + 1)
        if first > 2 * MOST_CELLS:
            raise TerrainError(f"{name}: found more than {MOST_CELLS} cells, allowed: a larger cell_size, {h:g} m is "
                               "given")
    if not cells:
        raise TerrainError(f"{name}: found no part of it between the lines around it, allowed: a mass with an area")
    return Mass(name, np.concatenate(nodes), np.concatenate(cells), float(area), deepest)


def lay_soil(plan: Plan) -> tuple[list[Mass], Line]:
    """The layers from the ground down, then the slide; and the rigid base below all of them. @raises TerrainError"""
    h, x = plan.cell_size, column_sides(plan)
    middle = (x[:-1] + x[1:]) / 2
    bounds = bounds_in(plan, x)
    cut = [[(bottom, top) for left, right, bottom, top in holes(plan) if left < place < right] for place in middle]
    masses = []
    for k, layer in enumerate(plan.layers):
        columns = [(x[c], x[c + 1], low, high) for c in range(len(middle))
                   for low, high in pieces_of(bounds[k + 1, c], bounds[k, c], cut[c])]
        masses.append(fill(layer.name, columns, h))
    if plan.slide is not None:
        top = plan.slide.top
        within = np.flatnonzero((middle > top.x[0]) & (middle < top.x[-1]))
        columns = [(x[c], x[c + 1], low, high) for c in within
                   for low, high in pieces_of(bounds[0, c], top.at(x[[c, c + 1]]), cut[c])]
        masses.append(fill("slide", columns, h))
    return masses, Line(x, np.append(bounds[-1, :, 0], bounds[-1, -1, 1]))


def simplified(line: Line) -> Line:
    """A line without the points in its straight parts."""
    slopes = line.slopes()
    bends = np.abs(np.diff(slopes)) > 1e-9
    keep = np.concatenate([[True], bends, [True]])
    return Line(line.x[keep], line.z[keep])
