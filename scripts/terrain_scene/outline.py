# SPDX-License-Identifier: BSD-3-Clause
"""Polygons on the plan, with holes."""

from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path as Ring


@dataclass(frozen=True)
class Outline:
    """One polygon: its outer ring, then its holes, each n x 2 [m]. Whether a ring repeats its first corner at its end,
    and which way round it runs, does not matter.
    """

    rings: tuple[np.ndarray, ...]

    def moved(self, by: np.ndarray) -> "Outline":
        return Outline(tuple(ring + by for ring in self.rings))

    def area(self) -> float:
        """Area of the outer ring less its holes [m^2]. Places are near the origin: products of map coordinates lose
        digits."""
        outer, *holes = (abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2 for x,
                         y in (ring.T for ring in self.rings))
        return outer - sum(holes)

    def contains(self, places: np.ndarray) -> np.ndarray:
        """places: n x 2."""
        inside = Ring(self.rings[0]).contains_points(places)
        for hole in self.rings[1:]:
            inside &= ~Ring(hole).contains_points(places)
        return inside

    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest coordinates."""
        return self.rings[0].min(axis=0), self.rings[0].max(axis=0)


def limits_of(outlines: list[Outline]) -> tuple[np.ndarray, np.ndarray]:
    """Limits of all outlines together."""
    lows, highs = zip(*(outline.limits() for outline in outlines))
    return np.min(lows, axis=0), np.max(highs, axis=0)


def crossing_of(ring: np.ndarray) -> np.ndarray | None:
    """A place where two sides of a ring cross; None: there is none. Sides that touch, such as those of a slit, do
    not."""
    start = ring - ring[0]  # small numbers: products of map coordinates lose digits
    way = np.roll(start, -1, axis=0) - start

    def turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

    apart = start[None] - start[:, None]  # from the start of side i to that of side j
    across = turn(way[:, None], way[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        s = turn(apart, np.broadcast_to(way[None], apart.shape)) / across
        t = turn(apart, np.broadcast_to(way[:, None], apart.shape)) / across
    inner = (s > 1e-9) & (s < 1 - 1e-9) & (t > 1e-9) & (t < 1 - 1e-9)
    found = np.argwhere(inner)
    return ring[found[0][0]] + s[tuple(found[0])] * way[found[0][0]] if len(found) else None
