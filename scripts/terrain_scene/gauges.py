# SPDX-License-Identifier: BSD-3-Clause
"""Upright pieces of planes on the slope, through which the soil is watched."""

import numpy as np

from .plan import Gauge
from .raster import TerrainError
from .slope import Slope

SAMPLES = 8  # a cell of the slope along the line


def gauge_settings(gauge: Gauge, slope: Slope, origin: np.ndarray) -> dict:
    """A gauge from the lowest ground within a cell of its line, where the slab of its section still has soil, to
    `height` above the highest under the line; flow to the right of the line counts positive.

    gauge: its line lies in the area, as the reader of the plan sees to.

    @raises TerrainError  the line has no length
    """
    line = gauge.line - origin[:2]
    length = np.linalg.norm(line[1] - line[0])
    if not length > 0:
        raise TerrainError(f"gauge {gauge.name}: line: found no length, allowed: two places that differ")
    count = int(np.ceil(SAMPLES * length / slope.spacing)) + 1
    places = np.linspace(line[0], line[1], count)
    ground = slope.at(*places.T)
    slope.require_known(ground, places, f"gauge {gauge.name}: line")
    along = (line[1] - line[0]) / length
    across = slope.spacing * np.array([along[1], -along[0]])
    beside = (np.clip(places + side * across, 0, slope.size()) for side in (-1, 1))
    lowest = min(ground.min(), *(np.nanmin([*slope.at(*each.T), ground.min()]) for each in beside))
    foot = [[*map(float, place), float(lowest)] for place in line]
    return {"name": gauge.name, "corners": [*foot, [*foot[0][:2], float(ground.max() + gauge.height)]]}
