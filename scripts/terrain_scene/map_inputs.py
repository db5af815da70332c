# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of a plan from files of maps: each key has rows of numbers or the name of a file."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .features import Feature, Features, lines_of, outlines_of, read_features
from .outline import Outline, crossing_of
from .projection import name_of, reference, require_metres, turned
from .raster import Raster, TerrainError, load_gdal
from .reader import Reader


@dataclass
class MapInputs:
    """folder: of the plan; projection: of the slope, or of the first file that names one; notes: what was assumed."""

    folder: Path
    projection: str | None
    notes: list[str] = field(default_factory=list)

    def features(self, reader: Reader, key: str, kind: str) -> Features:
        try:
            found = read_features(reader.values[key], self.folder, kind, self.projection)
        except TerrainError as error:
            raise TerrainError(f"{reader.where}/{key}: {error}") from error
        if self.projection is None and found.projection is not None:
            require_metres(found.projection, found.place(), f"{reader.where}/{key}: {found.path}")
            self.projection = found.projection
        self.notes += found.notes
        return found

    def outlines(self, reader: Reader, key: str) -> tuple[list[Outline], list[Feature]]:
        """One polygon of rows, or all of a file with the feature of each."""
        if isinstance(reader.values[key], str):
            found = self.features(reader, key, "polygon")
            try:
                return outlines_of(found)
            except TerrainError as error:
                raise TerrainError(f"{reader.where}/{key}: {error}") from error
        rows = reader.rows(key, 3)
        place = crossing_of(rows)
        if place is not None:
            raise TerrainError(f"{reader.where}/{key}: found sides that cross at ({place[0]:.9g}, {place[1]:.9g}), "
                               "allowed: a polygon whose sides meet at its corners alone")
        return [Outline((rows,))], []

    def line(self, reader: Reader, key: str) -> np.ndarray:
        """Rows, or the only line of a file; n x 2."""
        if not isinstance(reader.values.get(key), str):
            return reader.rows(key, 2)
        found = self.features(reader, key, "line")
        lines = self.lines(reader, key, found)
        if len(lines) > 1:
            raise TerrainError(f"{reader.where}/{key}: {found.path}: found {len(lines)} lines, allowed: one")
        return lines[0][0]

    def lines(self, reader: Reader, key: str, found: Features) -> list[tuple[np.ndarray, Feature]]:
        try:
            return lines_of(found)
        except TerrainError as error:
            raise TerrainError(f"{reader.where}/{key}: {error}") from error


def settle_projection(reader: Reader, slope: Raster) -> str | None:
    """The projection of the slope, named by its file or by the plan; None: by neither.

    @raises TerrainError  not in metres, or two
    """
    if "projection" in reader.values:
        text = reader.text("projection", "a projection, such as EPSG:31287")
        where = f"{reader.where}/projection"
        named = reference(text, where).ExportToWkt()
        low_x, low_y, high_x, high_y = slope.limits()
        corners = np.array([(low_x, low_y), (high_x, high_y)])
        if slope.projection is not None and turned(corners, named, slope.projection, where) is not corners:
            raise TerrainError(f"{where}: found {name_of(named)}, {slope.path} names {name_of(slope.projection)}, "
                               "allowed: one of them")
        slope.projection = named
    require_ground(slope, f"{reader.where}/slope")
    return slope.projection


def require_ground(slope: Raster, where: str) -> None:
    """@raises TerrainError  a raster that cannot be heights over sides, both in metres"""
    if slope.projection is not None and has_gdal():
        middle = np.reshape(slope.limits(), (2, 2)).mean(axis=0)
        require_metres(slope.projection, middle, f"{where}: {slope.path}")
    require_named_gaps(slope, where)
    require_gentle(slope, where)


def has_gdal() -> bool:
    try:
        load_gdal("")
    except TerrainError:
        return False
    return True


STEEPEST = 10  # heights over the longer side of a raster: no ground is as steep over all of a map


NO_DATA = (-9999, -99999, -32768, -32767)  # as other programs write it; no ground is as low


def require_named_gaps(slope: Raster, where: str) -> None:
    """@raises TerrainError  heights that stand for no data, which the raster does not call so"""
    for value in NO_DATA:
        count = int(np.sum(slope.values == value))
        if count:
            raise TerrainError(f"{where}: {slope.path}: found {count} heights of {value} m, which stand for no data, "
                               "allowed: a raster that says so, as after gdal_edit.py (package gdal-bin) -a_nodata "
                               f"{value} (.asc: NODATA_value {value})")


def require_gentle(slope: Raster, where: str) -> None:
    """@raises TerrainError  heights in metres over sides that cannot be: sides in degrees, heights in centimetres"""
    low_x, low_y, high_x, high_y = slope.limits()
    rise, side = np.nanmax(slope.values) - np.nanmin(slope.values), max(high_x - low_x, high_y - low_y)
    if rise > STEEPEST * side:
        raise TerrainError(f"{where}: {slope.path}: found heights that differ by {rise:.4g} m over {side:.4g}, "
                           "allowed: both in metres; the sides look like degrees, or the heights like centimetres")
