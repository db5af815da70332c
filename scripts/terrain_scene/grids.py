# SPDX-License-Identifier: BSD-3-Clause
"""Rasters on the cells of another one, written as ESRI ASCII grid and as GeoTIFF."""

from pathlib import Path

import numpy as np

from .projection import reference, text_of_prj
from .raster import Raster, TerrainError, load_gdal

NO_DATA = -9999.0
MOST_WHOLE = 4_000_000  # cells of a raster that is written whole, else only the part with values


def on_cells_of(raster: Raster, corner: np.ndarray, values: np.ndarray) -> Raster:
    """Values on cells of a raster, the rest of it without data; of a very large one only the part of the values.

    corner: of the first cell of the values on the map [m]; values: rows from south to north, nan: no data.

    @raises TerrainError  values beyond the raster
    """
    h = raster.spacing
    column, row = (int(round((corner[k] - (raster.x, raster.y)[k]) / h + 0.5)) for k in (0, 1))
    rows, columns = raster.values.shape
    if not (0 <= row and row + values.shape[0] <= rows and 0 <= column and column + values.shape[1] <= columns):
        raise TerrainError(f"{raster.path}: found soil beyond it, from ({corner[0]:.9g}, {corner[1]:.9g}) over "
                           f"{values.shape[1]} x {values.shape[0]} cells; {raster.reach()}")
    x, y = raster.x + column * h, raster.y + row * h
    if raster.values.size > MOST_WHOLE:
        return Raster(raster.path, x, y, h, values, raster.projection)
    whole = np.full(raster.values.shape, np.nan)
    whole[row:row + values.shape[0], column:column + values.shape[1]] = values
    return Raster(raster.path, raster.x, raster.y, h, whole, raster.projection)


def write_ascii(raster: Raster, path: Path) -> list[Path]:
    """Write a raster, with its projection in a file beside it."""
    rows, columns = raster.values.shape
    head = (f"ncols {columns}\nnrows {rows}\nxllcorner {float(raster.x - raster.spacing / 2)!r}\n"
            f"yllcorner {float(raster.y - raster.spacing / 2)!r}\ncellsize {float(raster.spacing)!r}\nNODATA_value "
            f"{NO_DATA:g}\n")
    values = np.where(np.isnan(raster.values), NO_DATA, raster.values)[::-1]
    path.write_text(head + "\n".join(" ".join(f"{v:.8g}" for v in row) for row in values) + "\n", encoding="ascii")
    if raster.projection is None:
        path.with_suffix(".prj").unlink(missing_ok=True)  # of a raster that is replaced
        return [path]
    path.with_suffix(".prj").write_text(text_of_prj(raster.projection) + "\n", encoding="utf-8")
    return [path, path.with_suffix(".prj")]


def write_geotiff(raster: Raster, path: Path, unit: str) -> Path:
    """Single precision, compressed. unit: of the values. @raises TerrainError  GDAL is missing or cannot write"""
    gdal, _, _ = load_gdal(str(path))
    rows, columns = raster.values.shape
    h = raster.spacing
    try:
        data = gdal.GetDriverByName("GTiff").Create(str(path), columns, rows, 1, gdal.GDT_Float32,
                                                    ["COMPRESS=DEFLATE", "PREDICTOR=3"])
        data.SetGeoTransform((raster.x - h / 2, h, 0, raster.y + (rows - 0.5) * h, 0, -h))
        if raster.projection is not None:
            data.SetProjection(reference(raster.projection, str(raster.path)).ExportToWkt())
        band = data.GetRasterBand(1)
        band.SetNoDataValue(NO_DATA)
        band.SetUnitType(unit)
        band.WriteArray(np.where(np.isnan(raster.values), NO_DATA, raster.values)[::-1].astype(np.float32))
        data.FlushCache()
    except RuntimeError as error:
        raise TerrainError(f"{path}: {error}") from error
    return path
