# SPDX-License-Identifier: BSD-3-Clause
"""Lines of a section: heights over the distance along it, straight between points."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from terrain_scene.map_inputs import require_ground
from terrain_scene.raster import TerrainError
from terrain_scene.reader import Reader

LINE = ("slope", "line")  # of a ground line that is cut from a raster
ALLOWED = "at least 2 rows [x, z]"


@dataclass
class Line:
    """Points with x that grows [m]."""

    x: np.ndarray
    z: np.ndarray

    def at(self, x: np.ndarray) -> np.ndarray:
        """Height [m] at places; beyond its ends that of the end."""
        return np.interp(x, self.x, self.z)

    def moved(self, way: np.ndarray) -> "Line":
        return Line(self.x + way[0], self.z + way[1])

    def slopes(self) -> np.ndarray:
        """Slopes of the pieces of the line [-]."""
        return np.diff(self.z) / np.diff(self.x)


def level(height: float, ends: tuple[float, float]) -> Line:
    return Line(np.array(ends), np.array([height, height]))


def line_of(rows: np.ndarray, where: str) -> Line:
    """@raises TerrainError  a doubled point, an upright step, or a line that folds back"""
    for k, (x, z) in enumerate(np.diff(rows, axis=0), 1):
        found = f"{where}/{k}: found ({rows[k, 0]:.9g}, {rows[k, 1]:.9g})"
        if x == 0 and z == 0:
            raise TerrainError(f"{found}, the point before it again, allowed: points that differ")
        if x == 0:
            raise TerrainError(f"{found}, upright above or below the point before it, allowed: x that grows; give a "
                               "step a width, such as a tenth of a cell")
        if x < 0:
            raise TerrainError(f"{found}: the line folds back there, allowed: x that grows from point to point; the "
                               "flow may go either way")
    return Line(rows[:, 0], rows[:, 1])


def require_across(line: Line, ends: tuple[float, float], where: str) -> Line:
    """@raises TerrainError  a gap between its ends and those of the ground"""
    for low, high in ((ends[0], line.x[0]), (line.x[-1], ends[1])):
        if low < high:
            raise TerrainError(f"{where}: found a gap from x = {low:.9g} to {high:.9g}, allowed: a line along all of "
                               f"the ground, from {ends[0]:.9g} to {ends[1]:.9g}; it ends a layer where it rises above "
                               "the ground")
    return line


def read_line(reader: Reader, key: str, ground: Line) -> Line:
    """A number (level), rows [x, z], or {"depth": D} below the ground."""
    where, ends = f"{reader.where}/{key}", (ground.x[0], ground.x[-1])
    value = reader.values.get(key)
    if isinstance(value, list):
        return require_across(line_of(reader.rows(key, 2), where), ends, where)
    if isinstance(value, dict):
        return Line(ground.x, ground.z - reader.child(key, ("depth",)).number("depth"))
    return level(reader.real(key, 'a height [m], rows [x, z], or {"depth": D}'), ends)


def read_ground(reader: Reader, folder: Path) -> Line:
    """Rows [x, z], or cut from a raster of heights along a line on the map."""
    if isinstance(reader.values.get("ground"), dict):
        return cut_ground(reader.child("ground", LINE), folder)
    return line_of(reader.rows("ground", 2), f"{reader.where}/ground")


def cut_ground(reader: Reader, folder: Path) -> Line:
    """Heights along the line, at its corners and between them no farther apart than the cells of the raster.

    x is the distance along the line from its first point.
    """
    raster, rows = reader.raster("slope", folder), reader.rows("line", 2)
    require_ground(raster, f"{reader.where}/slope")
    lengths = np.linalg.norm(np.diff(rows, axis=0), axis=1)
    if not (lengths > 0).all():
        k = int(np.argmin(lengths)) + 1
        raise TerrainError(f"{reader.where}/line/{k}: found the point before it again, allowed: points that differ")
    places, ways, before = [rows[:1]], [np.zeros(1)], 0.0
    for k, length in enumerate(lengths):
        pieces = int(np.ceil(length / raster.spacing - 1e-9))
        share = np.arange(1, pieces + 1) / pieces
        places.append(rows[k] + share[:, None] * (rows[k + 1] - rows[k]))
        ways.append(before + share * length)
        before += length
    x, y = np.concatenate(places).T
    try:
        return Line(np.concatenate(ways), raster.needed_at(x, y))
    except TerrainError as error:
        raise TerrainError(f"{reader.where}/line: {error}") from error


def crossings(lines: list[Line], x: np.ndarray) -> np.ndarray:
    """Places [m] between those of `x` where two of the lines cross; between places of `x` each line is straight."""
    heights = np.array([line.at(x) for line in lines])
    found = [np.empty(0)]
    for i, first in enumerate(heights):
        for second in heights[i + 1:]:
            gap = first - second
            k = np.flatnonzero(gap[:-1] * gap[1:] < 0)
            found.append(x[k] + (x[k + 1] - x[k]) * gap[k] / (gap[k] - gap[k + 1]))
    return np.concatenate(found)
