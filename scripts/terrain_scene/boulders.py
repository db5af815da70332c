# SPDX-License-Identifier: BSD-3-Clause
"""Boulders of a scene on terrain, laid on the slope or on the soil."""

from dataclasses import dataclass

import numpy as np

from .raster import TerrainError
from .reader import Reader
from .slope import Columns, Slope

SHAPES = ("radius", "box", "ellipsoid")
SAMPLES = 24  # along the radius, where the ground under a boulder is looked at
ROOM = 0.01  # of the radius, above the ground: facets of the slope lie between its samples


@dataclass
class Boulder:
    """A boulder of the plan.

    place: on the map [m]; radius: of a sphere around it [m]; settings: those of `boulders` in mpm.json, but its place.
    """

    place: np.ndarray
    radius: float
    settings: dict


def read_boulders(reader: Reader) -> list[Boulder]:
    """Keys are those of mpm.json, with `place` for the centre; the programs check what is not read here."""
    boulders = []
    for each in reader.children("boulders", None):
        each.text("name", "a name")
        each.number("density")
        if "centre" in each.values:
            raise each.fail("centre", "place, on the map; the height is that of the ground")
        place = each.place("place")
        settings = {key: value for key, value in each.values.items() if key != "place"}
        boulders.append(Boulder(place, radius_around(each.child("shape", SHAPES)), settings))
    return boulders


def radius_around(shape: Reader) -> float:
    """@raises TerrainError"""
    if len(shape.values) != 1:
        raise TerrainError(f"{shape.where}: found {len(shape.values)} keys, allowed: one of {', '.join(SHAPES)}")
    if "radius" in shape.values:
        return shape.number("radius")
    key = next(iter(shape.values))
    try:
        lengths = np.array(shape.values[key], dtype=float)
    except (TypeError, ValueError) as error:
        raise shape.fail(key, "three lengths > 0") from error
    if lengths.shape != (3,) or not (lengths > 0).all():
        raise shape.fail(key, "three lengths > 0")
    return float(np.linalg.norm(lengths) / 2 if key == "box" else lengths.max())


def boulder_settings(boulder: Boulder, slope: Slope, columns: Columns, origin: np.ndarray) -> dict:
    """Place of a boulder whose sphere nearly rests on the ground, or on the soil there. @raises TerrainError  there is
    no ground"""
    x, y = boulder.place - origin[:2]
    steps = boulder.radius * np.arange(-SAMPLES, SAMPLES + 1) / SAMPLES
    dx, dy = np.meshgrid(steps, steps)
    wide, long = slope.size()
    on_map = (np.abs(x + dx - wide / 2) <= wide / 2) & (np.abs(y + dy - long / 2) <= long / 2)
    near = (dx**2 + dy**2 <= boulder.radius**2) & on_map
    dx, dy = dx[near], dy[near]
    ground = slope.at(x + dx, y + dy) + columns.heights(x + dx, y + dy, slope.spacing)
    heights = ground + np.sqrt(np.maximum(boulder.radius**2 - dx**2 - dy**2, 0))
    if not len(heights) or np.isnan(heights).all():
        raise TerrainError(f"boulder {boulder.settings['name']}: found no ground at ({boulder.place[0]:.9g}, "
                           f"{boulder.place[1]:.9g}), allowed: places on the slope")
    centre = [float(x), float(y), float(np.nanmax(heights) + ROOM * boulder.radius)]
    return {"name": boulder.settings["name"], "centre": centre} | boulder.settings
