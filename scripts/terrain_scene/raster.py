# SPDX-License-Identifier: BSD-3-Clause
"""Rasters of heights or depths: ESRI ASCII grids, and what GDAL reads where it is installed."""

from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np


class TerrainError(Exception):
    """An input that cannot become a scene; the text says what was found, where, and what is allowed."""


@dataclass
class Raster:
    """Values at the centres of square cells.

    x, y: centre of the cell in the south-west [m]; values: rows from south to north, nan: no data; projection: WKT or
    what the .prj file beside it says, None: it names none.
    """

    path: Path
    x: float
    y: float
    spacing: float
    values: np.ndarray
    projection: str | None = None

    def limits(self) -> tuple[float, float, float, float]:
        """Lowest x and y, highest x and y between which values are known [m]."""
        rows, columns = self.values.shape
        return self.x, self.y, self.x + (columns - 1) * self.spacing, self.y + (rows - 1) * self.spacing

    def reach(self) -> str:
        low_x, low_y, high_x, high_y = self.limits()
        return f"the raster reaches from ({low_x:.9g}, {low_y:.9g}) to ({high_x:.9g}, {high_y:.9g})"

    def place(self, row: int, column: int) -> str:
        """Row and column of a value in the file, whose first row is that in the north."""
        return f"row {self.values.shape[0] - row}, column {column + 1}"

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Bilinear between the centres of the cells; nan where a neighbour has no data or there is none."""
        rows, columns = self.values.shape
        s, t = (np.asarray(x) - self.x) / self.spacing, (np.asarray(y) - self.y) / self.spacing
        inside = (s >= -1e-9) & (s <= columns - 1 + 1e-9) & (t >= -1e-9) & (t <= rows - 1 + 1e-9)
        i = np.clip(np.floor(s), 0, columns - 2).astype(int)
        j = np.clip(np.floor(t), 0, rows - 2).astype(int)
        a, b = s - i, t - j
        # A neighbour that does not count may have no data.
        z = sum(np.where(weight > 1e-9, weight * self.values[j + dj, i + di], 0)
                for di, dj, weight in ((0, 0, (1 - a) * (1 - b)), (1, 0, a * (1 - b)), (0, 1, (1 - a) * b),
                                       (1, 1, a * b)))
        return np.where(inside, z, np.nan)

    def needed_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Values at places, like `at`, where every value has to be known."""
        z = self.at(x, y)
        if not np.isnan(z).any():
            return z
        k = int(np.flatnonzero(np.isnan(z.ravel()))[0])
        at_x, at_y = float(np.ravel(x)[k]), float(np.ravel(y)[k])
        low_x, low_y, high_x, high_y = self.limits()
        if not (low_x <= at_x <= high_x and low_y <= at_y <= high_y):
            raise TerrainError(f"{self.path}: the area needs a height at ({at_x:.9g}, {at_y:.9g}); {self.reach()}")
        near = (np.abs(self.x + np.arange(self.values.shape[1])[None, :] * self.spacing - at_x) <= self.spacing) & (
            np.abs(self.y + np.arange(self.values.shape[0])[:, None] * self.spacing - at_y) <= self.spacing)
        row, column = np.argwhere(near & np.isnan(self.values))[0]
        raise TerrainError(f"{self.path}: no data in {self.place(row, column)}, which the area needs at "
                           f"({at_x:.9g}, {at_y:.9g})")


FARTHEST = 1e5  # [m]: no height or depth on Earth is larger
DIGITS = 1e-5  # relative, of a number for no data: files of single precision and rounded texts differ in the last ones


def without_data(values: np.ndarray, number: float | None) -> np.ndarray:
    """nan where a value is the number for no data (None: there is none), which other programs write with fewer
    digits."""
    if number is None or np.isnan(number):
        return values
    same = (values == number) | (np.abs(values - number) <= DIGITS * abs(number))
    return np.where(same, np.nan, values)


def checked(raster: Raster) -> Raster:
    """@raises TerrainError  a value that is no height or depth, such as a number for no data that the file does not
    name"""
    wrong = np.argwhere(np.abs(raster.values) > FARTHEST)
    if len(wrong):
        row, column = wrong[0]
        raise TerrainError(f"{raster.path}: found {raster.values[row, column]:g} in {raster.place(row, column)} and "
                           f"{len(wrong) - 1} other values beyond {FARTHEST:g} m, allowed: metres; if it stands for no "
                           "data, name it in the file (NODATA_value)")
    return raster


UNITS = ("", "m", "M", "metre", "meter", "metres", "meters")  # of the values, as files write them
HEADER = {"ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "nodata_value"}


def read_ascii(path: Path) -> Raster:
    """An ESRI ASCII grid, its corner or the centre of its first cell given. @raises TerrainError"""
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise TerrainError(f"{path}: cannot be read as an ESRI ASCII grid: {error}") from error
    head: dict[str, float] = {}
    first = 0
    for first, line in enumerate(lines):
        words = line.split()
        if not words or not words[0][0].isalpha() or words[0].lower() == "nan":
            break
        if words[0].lower() not in HEADER:
            raise TerrainError(f"{path}: line {first + 1}: found \"{line}\", allowed: {', '.join(sorted(HEADER))}; "
                               "cells have to be square and lie along the axes")
        try:
            head[words[0].lower()], = map(float, words[1:])
        except ValueError as error:
            raise TerrainError(f"{path}: line {first + 1}: found \"{line}\", expected a name and a number") from error
    for name in ("ncols", "nrows", "cellsize"):
        value = head.get(name, 0)
        if not 0 < value < np.inf or (name != "cellsize" and value % 1):
            allowed = "a number > 0" if name == "cellsize" else "a whole number > 0"
            raise TerrainError(f"{path}: header: {name}: found {head.get(name, 'none')}, allowed: {allowed}")
    columns, rows, spacing = int(head["ncols"]), int(head["nrows"]), head["cellsize"]
    if rows < 2 or columns < 2:
        raise TerrainError(f"{path}: found {rows} x {columns} values, allowed: at least 2 x 2")
    corner = []
    for axis in "xy":
        if (f"{axis}llcorner" in head) == (f"{axis}llcenter" in head):
            raise TerrainError(f"{path}: header: allowed: exactly one of {axis}llcorner and {axis}llcenter")
        corner.append(head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", 0) + spacing / 2))
    words = [(k, word) for k, line in enumerate(lines[first:], first) for word in line.split()]
    if len(words) != rows * columns:
        raise TerrainError(f"{path}: found {len(words)} values, expected {rows} rows of {columns}")
    values = np.empty(rows * columns)
    for n, (k, word) in enumerate(words):
        try:
            values[n] = float(word)
        except ValueError as error:
            raise TerrainError(f"{path}: line {k + 1}: found \"{word}\", expected a number") from error
    values = without_data(values, head.get("nodata_value", -9999))
    return checked(Raster(path, corner[0], corner[1], spacing, values.reshape(rows, columns)[::-1],
                          projection_beside(path)))


def load_gdal(what: str) -> tuple[ModuleType, ModuleType, ModuleType]:
    """gdal, ogr and osr. what: needs them, for the message. @raises TerrainError  they are not installed"""
    try:
        from osgeo import gdal, ogr, osr
    except ImportError as error:
        raise TerrainError(f"{what}: needs GDAL: install python3-gdal, which reads rasters other than ESRI ASCII "
                           "grids, shapefiles, GeoPackage, GeoJSON and KML, and turns one projection into "
                           "another") from error
    for module in (gdal, ogr, osr):
        module.UseExceptions()
    return gdal, ogr, osr


def projection_beside(path: Path) -> str | None:
    """Text of the .prj file of a raster; None: there is none."""
    beside = next((p for p in (path.with_suffix(".prj"), path.with_suffix(".PRJ")) if p.is_file()), None)
    try:
        return None if beside is None else beside.read_text(encoding="utf-8").strip() or None
    except (OSError, UnicodeDecodeError) as error:
        raise TerrainError(f"{beside}: cannot be read: {error}") from error


def read_with_gdal(path: Path) -> Raster:
    """The only band of what GDAL reads, cells square and along the axes, in metres. @raises TerrainError"""
    gdal, _, _ = load_gdal(str(path))
    try:
        data = gdal.Open(str(path))
    except RuntimeError as error:
        raise TerrainError(f"{path}: {error}") from error
    left, width, row_turn, top, column_turn, height = data.GetGeoTransform()
    if row_turn or column_turn or not width > 0 or abs(width + height) > 1e-9 * width:
        raise TerrainError(f"{path}: found the transform {data.GetGeoTransform()}, allowed: square cells along the "
                           "axes, north up")
    if data.RasterCount != 1:
        raise TerrainError(f"{path}: found {data.RasterCount} bands, allowed: one; gdal_translate -b NUMBER takes one "
                           "out")
    band = data.GetRasterBand(1)
    if band.GetUnitType() not in UNITS:
        raise TerrainError(f"{path}: found values in {band.GetUnitType()}, allowed: metres")
    values = without_data(np.array(band.ReadAsArray(), dtype=float), band.GetNoDataValue())
    if band.GetMaskFlags() & gdal.GMF_PER_DATASET:  # a mask inside the file or beside it says where there is data
        values[np.asarray(band.GetMaskBand().ReadAsArray()) == 0] = np.nan
    # The number for no data is one of the stored values, before the band's scale and offset.
    scale, offset = band.GetScale(), band.GetOffset()
    values = values * (1.0 if scale is None else scale) + (0.0 if offset is None else offset)
    rows = values.shape[0]
    if min(values.shape) < 2:
        raise TerrainError(f"{path}: found {rows} x {values.shape[1]} values, allowed: at least 2 x 2")
    return checked(Raster(path, left + width / 2, top - (rows - 0.5) * width, width, values[::-1],
                          data.GetProjection() or projection_beside(path)))


def read_raster(path: Path) -> Raster:
    """An ESRI ASCII grid by its ending .asc, all else by GDAL."""
    if not path.is_file():
        raise TerrainError(f"{path}: no such raster")
    return read_ascii(path) if path.suffix.lower() == ".asc" else read_with_gdal(path)
