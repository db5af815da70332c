# SPDX-License-Identifier: BSD-3-Clause
"""Files of maps for tests, made by GDAL. Without python3-gdal the test that imports this ends with 77: skipped."""

import json
import sys
from pathlib import Path

import numpy as np
from script_case import ScriptCase

try:
    from osgeo import gdal, ogr, osr
except ImportError:
    print("not run: python3-gdal is not installed")
    sys.exit(77)

from terrain_scene.plan import Plan, read_plan
from terrain_scene.raster import TerrainError
from terrain_scene.scene import make

LAMBERT = 31287  # MGI / Austria Lambert, in metres
WEST, SOUTH = 400000.0, 400000.0
DRIVERS = {".shp": "ESRI Shapefile", ".gpkg": "GPKG", ".geojson": "GeoJSON", ".kml": "KML", ".tif": "GTiff"}


def system(number: int | None) -> osr.SpatialReference | None:
    if number is None:
        return None
    found = osr.SpatialReference()
    found.ImportFromEPSG(number)
    found.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return found


def square(x: float, y: float, side: float, around: bool = True) -> str:
    """Corners in WKT from the south-west, against the clock or with it; relative to (WEST, SOUTH)."""
    corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side), (x, y)]
    return "(" + ", ".join(f"{WEST + a:.10g} {SOUTH + b:.10g}" for a, b in (corners if around else corners[::-1])) + ")"


class MapCase(ScriptCase):
    def vector(self, name: str, features: list[tuple[str | None, dict]], number: int | None = LAMBERT,
               layer: str = "shapes") -> Path:
        """features: WKT in Austria Lambert, attributes; number: EPSG of the file, into which they are turned."""
        path = self.folder / name
        driver = ogr.GetDriverByName(DRIVERS[path.suffix])
        data = driver.Open(str(path), 1) if path.exists() else driver.CreateDataSource(str(path))
        kind = next((ogr.CreateGeometryFromWkt(text).GetGeometryType() for text, _ in features if text), ogr.wkbPolygon)
        single = {ogr.wkbMultiPolygon: ogr.wkbPolygon, ogr.wkbMultiLineString: ogr.wkbLineString}
        kind = single.get(kind, kind) if path.suffix == ".shp" else ogr.wkbUnknown
        into = data.CreateLayer(layer, system(number), kind)
        fields = {key: value for _, values in features for key, value in values.items()}
        for key, value in fields.items():
            into.CreateField(ogr.FieldDefn(key, ogr.OFTString if isinstance(value, str) else ogr.OFTReal))
        way = None if number in (None, LAMBERT) else osr.CoordinateTransformation(system(LAMBERT), system(number))
        for text, values in features:
            feature = ogr.Feature(into.GetLayerDefn())
            if text:
                geometry = ogr.CreateGeometryFromWkt(text)
                if way is not None:
                    geometry.Transform(way)
                feature.SetGeometry(geometry)
            for key, value in values.items():
                feature[key] = value
            into.CreateFeature(feature)
        return path

    def slope(self, name: str = "slope.tif", number: int | None = LAMBERT, spacing: float = 2.0, bands: int = 1,
              kind: int = gdal.GDT_Float64, south: float = SOUTH) -> Path:
        """40 x 24 values on a plane that falls to the east."""
        path = self.folder / name
        x, y = np.meshgrid(np.arange(40), np.arange(24))
        data = gdal.GetDriverByName("GTiff").Create(str(path), 40, 24, bands, kind)
        data.SetGeoTransform((WEST, spacing, 0, south + 24 * spacing, 0, -spacing))
        if number is not None:
            data.SetProjection(system(number).ExportToWkt())
        data.GetRasterBand(1).WriteArray((700 - 0.8 * x + 0.2 * y)[::-1])
        return path

    def plan(self, **changes: object) -> Path:
        """A slide of the polygons in slide.shp, without barrier."""
        if not (self.folder / "slope.tif").exists():
            self.slope()
        plan = {"slope": "slope.tif", "area": [[WEST + 2, SOUTH + 2], [WEST + 62, SOUTH + 42]], "cell_size": 1,
                "clear_height": 3, "friction": 0.3, "slide": {"polygon": "slide.shp", "depth": 1.5},
                "time": {"end": 1, "dt": 0.01}} | changes
        return self.write("plan.json", json.dumps(plan))

    def read(self, **changes: object) -> Plan:
        return read_plan(self.plan(**changes))

    def refused(self, *words: str, **changes: object) -> None:
        with self.assertRaises(TerrainError) as found:
            make(self.read(**changes))
        for word in words:
            self.assertIn(word, str(found.exception))

    def remove(self, name: str) -> None:
        for path in self.folder.glob(f"{Path(name).stem}.*"):
            path.unlink()
