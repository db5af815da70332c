# SPDX-License-Identifier: BSD-3-Clause
"""How far a mass comes on a slope, for the size of a scene: blocks with friction that slide down from it, each for
itself."""

from dataclasses import dataclass

import numpy as np

from .plan import GRAVITY
from .raster import Raster

STEP = 0.5  # of a cell of the raster
LONGEST = 20  # sides of the raster: no path is longer


@dataclass
class Reach:
    """places: on the map, all through which blocks come, n x 2 [m]; the time after which nine of ten are at rest or
    gone [s], the largest speed [m/s]; left: how many blocks come to the rim of the data.
    """

    places: np.ndarray
    time: float
    fastest: float
    left: int


def reach_of(slope: Raster, start: np.ndarray, depth: float, friction: float) -> Reach:
    """Blocks that start at rest at places n x 2, from the top of a mass of this depth [m].

    A block loses friction times its horizontal distance of its energy head (height and v^2 / 2g); gravity turns it
    towards the fall line, the more the slower it is. Soil loses energy by its own friction too, but is pushed from
    behind.
    """
    fields = [Raster(slope.path, slope.x, slope.y, slope.spacing, values)
              for values in (slope.values, *np.gradient(slope.values, slope.spacing)[::-1])]
    place = np.array(start, dtype=float)
    head = fields[0].at(*place.T) + depth
    way = np.zeros_like(place)
    time = np.zeros(len(place))
    visited, stopped, fastest, left = [place], [], 0.0, 0
    step = STEP * slope.spacing
    for _ in range(int(LONGEST * max(slope.values.shape) / STEP)):
        z, east, north = (each.at(*place.T) for each in fields)
        off, slow = np.isnan(z + east + north), head <= z
        left += int(off.sum())
        stopped += list(time[off | slow])
        going = ~(off | slow)
        place, head, way, time, z = (each[going] for each in (place, head, way, time, z))
        if not len(place):
            break
        rise = np.column_stack([east, north])[going]
        speed = np.sqrt(2 * GRAVITY * (head - z))
        fastest = max(fastest, float(speed.max()))
        level = speed / np.hypot(1, (way * rise).sum(axis=1))
        way = way * level[:, None] - GRAVITY * rise / (1 + (rise**2).sum(axis=1))[:, None] * (step / level)[:, None]
        length = np.linalg.norm(way, axis=1)
        way = np.where(length[:, None] > 0, way / np.where(length > 0, length, 1)[:, None], [1.0, 0.0])
        place = place + step * way
        head = head - friction * step
        time = time + step / level
        visited.append(place)
    return Reach(np.concatenate(visited), float(np.percentile([*stopped, *time], 90)), fastest, left)
