#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/terrain with files of maps: polygons, lines and points, rasters with a projection.

    test_maps.py

Skipped (code 77) where python3-gdal is missing.
"""

import json
import sys
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from script_case import ScriptCase

try:
    from osgeo import gdal, ogr, osr
except ImportError:
    print("not run: python3-gdal is not installed")
    sys.exit(77)

import made_up_results as made_up
from plotting.ground import coarse
from plotting.results import Results
from terrain_scene.changes import changed, read_changes
from terrain_scene.depths import Mass
from terrain_scene.grids import on_cells_of, write_ascii
from terrain_scene.on_map import read_place, write_maps
from terrain_scene.outline import Outline, crossing_of
from terrain_scene.plan import Plan, read_plan
from terrain_scene.raster import Raster, TerrainError, read_raster
from terrain_scene.reach import reach_of
from terrain_scene.scene import make, write_scene
from terrain_scene.slope import BULGE, Slope, lay_columns, write_ply

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
              kind: int = gdal.GDT_Float64) -> Path:
        """40 x 24 values on a plane that falls to the east."""
        path = self.folder / name
        x, y = np.meshgrid(np.arange(40), np.arange(24))
        data = gdal.GetDriverByName("GTiff").Create(str(path), 40, 24, bands, kind)
        data.SetGeoTransform((WEST, spacing, 0, SOUTH + 24 * spacing, 0, -spacing))
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


class Polygons(MapCase):
    def test_every_format_has_the_same_volume(self) -> None:
        """A square of 12 m with a hole of 4 m, and another square, in two features or one of two parts; turned from degrees."""
        holed = f"({square(10, 10, 12)}, {square(14, 14, 4, False)})"
        volume = 1.5 * (144 - 16 + 36)
        for name, number in (("a.shp", LAMBERT), ("a.gpkg", LAMBERT), ("b.gpkg", 4326), ("c.gpkg", 32633), ("a.geojson", 4326),
                             ("a.kml", 4326)):
            for parts in ([f"POLYGON {holed}", f"POLYGON ({square(30, 20, 6)})"],
                          [f"MULTIPOLYGON ({holed}, ({square(30, 20, 6, False)}))"]):
                self.vector(name, [(text, {}) for text in parts], number)
                plan = self.read(slide={"polygon": name, "depth": 1.5})
                made = make(plan)
                self.assertAlmostEqual(made.columns.asked, volume, delta=2e-3 * volume if number != LAMBERT else 1e-9, msg=name)
                # Sides turned from another projection do not follow the cells, whose samples count as a whole.
                self.assertAlmostEqual(made.columns.filled, volume, delta=0.02 * volume if number != LAMBERT else 1e-9, msg=name)
                self.assertEqual(any("turned from" in note for note in plan.notes), number != LAMBERT, plan.notes)
                self.remove(name)

    def test_depth_from_an_attribute(self) -> None:
        shapes = [f"POLYGON ({square(10, 10, 10)})", f"POLYGON ({square(20, 10, 10)})"]  # with one side in common
        depth = {"field": "THICKNESS"}
        for first, second in ((1.0, 2.0), ("1.0", "2")):
            self.vector("slide.shp", [(shapes[0], {"thickness": first}), (shapes[1], {"thickness": second})])
            self.assertAlmostEqual(make(self.read(slide={"polygon": "slide.shp", "depth": depth})).columns.asked, 300, delta=1e-9)
            self.remove("slide.shp")
        for wrong in (0.0, -1.0, "None", "", None):
            self.vector("slide.shp", [(shapes[0], {"thickness": "1" if isinstance(wrong, str) else 1.0}),
                                      (shapes[1], {"thickness": wrong} if wrong is not None else {})])
            self.refused("plan.json/slide/depth/field: ", "slide.shp: feature 1: thickness: found", "allowed: a number > 0",
                         slide={"polygon": "slide.shp", "depth": depth})
            self.remove("slide.shp")
        self.vector("slide.shp", [(shapes[0], {"d": 1.0})])
        self.refused("feature 0: no attribute THICKNESS, allowed: d", slide={"polygon": "slide.shp", "depth": depth})
        rows = [[WEST + 10, SOUTH + 10], [WEST + 20, SOUTH + 10], [WEST + 20, SOUTH + 20]]
        self.refused("needs polygons of a file", slide={"polygon": rows, "depth": depth})

    def test_shapes_that_cannot_be_are_named_with_their_place(self) -> None:
        good = (f"POLYGON ({square(10, 10, 10)})", {})
        bow = f"POLYGON (({WEST + 10} {SOUTH + 10}, {WEST + 20} {SOUTH + 20}, {WEST + 20} {SOUTH + 10}, {WEST + 10} {SOUTH + 20}, " \
              f"{WEST + 10} {SOUTH + 10}))"
        for words, features in (
                (("feature 2: found a polygon that is none", "Self-intersection", "400015 400015"), [good, (bow, {})]),
                (("feature 1: found a polygon that is none", "Hole lies outside"),
                 [(f"POLYGON ({square(10, 10, 10)}, {square(30, 30, 4)})", {})]),
                (("feature 2: overlaps feature 1 by 100 m^2 at (400015, 400015)",), [good, good]),
                (("feature 2: overlaps feature 1 by 25 m^2",), [good, (f"POLYGON ({square(15, 15, 10)})", {})]),
                (("feature 2: found no geometry",), [good, (None, {})]),
                (("feature 1: found a linestring, allowed: a polygon",), [(f"LINESTRING {square(10, 10, 9)}", {})]),
                (("found no feature",), []),
                (("polygon 2: found (400090, 400010) outside the area",), [good, (f"POLYGON ({square(90, 10, 5)})", {})])):
            self.vector("slide.gpkg", features)
            self.refused("slide.gpkg" if "polygon 2" not in words[0] else "plan.json/slide/polygon", *words,
                         slide={"polygon": "slide.gpkg", "depth": 1})
            self.remove("slide.gpkg")
        rows = [[WEST + x, SOUTH + y] for x, y in ((10, 10), (20, 20), (20, 10), (10, 20))]
        self.refused("plan.json/slide/polygon: found sides that cross at (400015, 400015)", slide={"polygon": rows, "depth": 1})

    def test_layers_and_files_that_are_not_there(self) -> None:
        self.vector("a.gpkg", [(f"POLYGON ({square(10, 10, 10)})", {})], layer="one")
        self.vector("a.gpkg", [(f"POLYGON ({square(10, 10, 5)})", {})], layer="two")
        self.refused("found the layers one, two, allowed: one", "a.gpkg|layername=NAME", slide={"polygon": "a.gpkg", "depth": 1})
        self.refused("found the layers one, two", slide={"polygon": "a.gpkg|layername=three", "depth": 1})
        made = make(self.read(slide={"polygon": "a.gpkg|layername=two", "depth": 1}))
        self.assertAlmostEqual(made.columns.asked, 25, delta=1e-9)
        self.refused("/slide/polygon: ", "none.shp: no such file", slide={"polygon": "none.shp", "depth": 1})
        self.write("text.shp", "nothing")
        self.refused("text.shp", slide={"polygon": "text.shp", "depth": 1})
        self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {})])
        (self.folder / "slide.shx").unlink()
        self.refused("slide.shx", slide={"polygon": "slide.shp", "depth": 1})

    def test_holes_and_crossings(self) -> None:
        ring = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], dtype=float)
        outline = Outline((ring, np.array([(1, 1), (3, 1), (3, 3), (1, 3), (1, 1)], dtype=float)))
        self.assertEqual(outline.area(), 12)
        places = np.array([(0.5, 0.5), (2, 2), (5, 5), (3.5, 2)])
        self.assertEqual(outline.contains(places).tolist(), [True, False, False, True])
        self.assertIsNone(crossing_of(ring))
        self.assertIsNone(crossing_of(np.vstack([ring, ring[:1]])))
        far = 5e6 + ring[[0, 2, 1, 3]]
        np.testing.assert_allclose(crossing_of(far), [5e6 + 2, 5e6 + 2], atol=1e-6)


class Projections(MapCase):
    def setUp(self) -> None:
        super().setUp()
        self.square = [(f"POLYGON ({square(10, 10, 10)})", {})]

    def test_a_file_or_a_slope_without_projection(self) -> None:
        self.vector("slide.shp", self.square, None)
        plan = self.read()
        self.assertTrue(any("names no projection: its coordinates are taken" in note for note in plan.notes))
        self.slope(number=None)
        self.assertIsNone(self.read().projection)
        self.vector("with.gpkg", self.square)
        plan = self.read(slide={"polygon": "with.gpkg", "depth": 1})
        self.assertTrue(any("the slope names no projection: taken as that of this file" in note for note in plan.notes))
        self.assertIn("Austria Lambert", plan.projection)
        self.vector("degrees.geojson", self.square, 4326)
        self.refused("in degrees, and a slope that names no projection", "\"projection\" in the plan",
                     slide={"polygon": "degrees.geojson", "depth": 1})
        made = make(self.read(slide={"polygon": "degrees.geojson", "depth": 1}, projection=f"EPSG:{LAMBERT}"))
        self.assertAlmostEqual(made.columns.asked, 100, delta=0.2)

    def test_a_projection_that_cannot_be(self) -> None:
        self.vector("slide.shp", self.square)
        self.refused("plan.json/projection: found MGI / Austria GK West", "names MGI / Austria Lambert", projection="EPSG:31254")
        self.refused("plan.json/projection: found the projection \"EPSG:0\"", projection="EPSG:0")
        self.refused("plan.json/projection: found 5", projection=5)
        self.read(projection=f"EPSG:{LAMBERT}")  # the same again
        self.slope(number=2225)  # US survey feet
        self.refused("/slope: ", "in US survey foot, allowed: one in metres")
        self.slope(number=4326, spacing=1e-4)
        self.refused("/slope: ", "WGS 84 in degrees, allowed: one in metres")
        self.slope(number=None, spacing=1e-4)
        self.refused("/slope: ", "heights that differ by", "look like degrees")

    def test_metres_in_a_file_that_says_degrees(self) -> None:
        """GeoJSON without "crs", whose numbers are those of the map, or in the other order."""
        corners = [[WEST + x, SOUTH + y] for x, y in ((10, 10), (20, 10), (20, 20), (10, 10))]
        self.write("a.geojson", json.dumps({"type": "Polygon", "coordinates": [corners]}))
        self.refused("found (400010, 400010), but its projection is WGS 84, in degrees", slide={"polygon": "a.geojson", "depth": 1})
        rows = [[SOUTH + 12, WEST + 55], [SOUTH + 20, WEST + 55]]
        self.vector("slide.shp", self.square)
        self.refused("with x and y exchanged they lie inside",
                     barrier={"line": rows, "height": 2, "thickness": 0.5})

    def test_rasters_in_another_projection_are_refused(self) -> None:
        self.vector("slide.shp", self.square)
        for key in ("depth", "top"):
            self.slope("other.tif", 31254)
            self.refused("other.tif: found the projection MGI / Austria GK West", "slope.tif, has MGI / Austria Lambert",
                         slide={key: "other.tif"})

    def test_prj_beside_a_grid(self) -> None:
        self.slope()
        gdal.Translate(str(self.folder / "slope.asc"), str(self.folder / "slope.tif"), format="AAIGrid")
        text, tiff = (read_raster(self.folder / f"slope.{end}") for end in ("asc", "tif"))
        np.testing.assert_allclose(text.values, tiff.values)
        self.assertEqual((text.x, text.y, text.spacing), (tiff.x, tiff.y, tiff.spacing))
        self.vector("slide.gpkg", self.square, 4326)
        plan = self.read(slope="slope.asc", slide={"polygon": "slide.gpkg", "depth": 1})
        self.assertAlmostEqual(make(plan).columns.asked, 100, delta=0.2)
        (self.folder / "slope.prj").write_text("PROJCS[\"broken\"")
        self.refused("slope.asc", "which GDAL does not know", slope="slope.asc")


class Rasters(MapCase):
    def test_geotiff(self) -> None:
        path = self.slope()
        raster = read_raster(path)
        self.assertEqual((raster.x, raster.y, raster.spacing), (WEST + 1, SOUTH + 1, 2))
        self.assertAlmostEqual(raster.values[0, 0], 700)  # in the south-west
        data = gdal.Open(str(path), gdal.GA_Update)
        band = data.GetRasterBand(1)
        band.SetNoDataValue(raster.values[3, 5])
        band.SetScale(0.5)
        band.SetOffset(100)
        band = data = None
        changed = read_raster(path)
        self.assertTrue(np.isnan(changed.values[3, 5]))
        self.assertAlmostEqual(changed.values[0, 0], 450)

    def test_what_is_no_raster_of_heights(self) -> None:
        with self.assertRaisesRegex(TerrainError, "found 3 bands, allowed: one"):
            read_raster(self.slope(bands=3))
        path = self.slope()
        data = gdal.Open(str(path), gdal.GA_Update)
        data.GetRasterBand(1).SetUnitType("ft")
        data = None
        with self.assertRaisesRegex(TerrainError, "found values in ft, allowed: metres"):
            read_raster(path)
        for turn in ((WEST, 2, 0.1, SOUTH, 0, -2), (WEST, 2, 0, SOUTH, 0, -3), (WEST, 2, 0, SOUTH, 0, 2)):
            path = self.slope()
            data = gdal.Open(str(path), gdal.GA_Update)
            data.SetGeoTransform(turn)
            data = None
            with self.assertRaisesRegex(TerrainError, "square cells along the axes"):
                read_raster(path)
        with self.assertRaisesRegex(TerrainError, "text.xyz"):
            read_raster(self.write("text.xyz", "no raster"))


class Lines(MapCase):
    def setUp(self) -> None:
        super().setUp()
        self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {})])

    def line(self, *corners: tuple[float, ...]) -> str:
        return "LINESTRING (" + ", ".join(" ".join(f"{a:.10g}" for a in (WEST + x, SOUTH + y, *z)) for x, y, *z in corners) + ")"

    def test_a_barrier_of_a_file(self) -> None:
        """A corner that is there twice is one; heights of a line are not looked at."""
        self.vector("dam.shp", [(self.line((50, 10, 9), (50, 20, 9), (50, 20, 9), (52, 30, 9)).replace("STRING", "STRING Z"), {})])
        barrier = {"height": 2, "thickness": 1}
        plan = self.read(barrier={"line": "dam.shp"} | barrier)
        np.testing.assert_allclose(plan.barrier.line, [[WEST + 50, SOUTH + 10], [WEST + 50, SOUTH + 20], [WEST + 52, SOUTH + 30]])
        self.assertIsNotNone(make(plan).wall)
        many = self.line((50, 10), (50, 20)), self.line((52, 10), (52, 20))
        self.vector("two.gpkg", [(text, {}) for text in many])
        self.refused("/barrier/line: ", "two.gpkg: found 2 lines, allowed: one", barrier={"line": "two.gpkg"} | barrier)
        parts = f"MULTILINESTRING ({', '.join(text.split(' ', 1)[1] for text in many)})"
        self.vector("parts.gpkg", [(parts, {})])
        self.refused("parts.gpkg: feature 1: found 2 lines that do not join", barrier={"line": "parts.gpkg"} | barrier)
        self.vector("dot.gpkg", [(self.line((50, 10), (50, 10)), {})])
        self.refused("dot.gpkg: feature 1: found a line without length at (400050, 400010)",
                     barrier={"line": "dot.gpkg"} | barrier)

    def test_gauges_and_probes_of_files(self) -> None:
        ends = [(self.line((30, 8), (30, 30)), {"name": "upper throat", "h": 3.0}), (self.line((40, 8), (40, 30)), {"name": "low", "h": 4.0})]
        self.vector("gauges.gpkg", ends)
        self.vector("probes.gpkg", [(f"POINT ({WEST + 15} {SOUTH + 15})", {"id": "middle"})], 4326)
        probes = {"points": "probes.gpkg", "name": "id"}
        made = make(self.read(gauges={"lines": "gauges.gpkg", "height": {"field": "h"}}, probes=probes))
        self.assertEqual([gauge["name"] for gauge in made.gauges], ["upper_throat", "low"])
        self.assertEqual([gauge.height for gauge in made.plan.gauges], [3, 4])
        (probe,) = made.probes
        np.testing.assert_allclose(probe["point"][:2], [13, 13], atol=1e-2)
        self.assertAlmostEqual(probe["point"][2], float(made.slope.at(13, 13)) + 0.75, delta=0.02)
        self.vector("bent.gpkg", [(self.line((30, 8), (31, 20), (30, 30)), {"name": "a"})])
        self.refused("bent.gpkg: feature 1: found 3 rows, allowed: 2", gauges={"lines": "bent.gpkg", "height": 3})
        self.vector("same.gpkg", [(text, {"name": "a"}) for text, _ in ends])
        self.refused("found the name a of gauges and probes twice", gauges={"lines": "same.gpkg", "height": 3})
        self.vector("none.gpkg", [(ends[0][0], {"name": ""})])
        self.refused("none.gpkg: feature 1: name: found ''", gauges={"lines": "none.gpkg", "height": 3})
        self.vector("off.gpkg", [(f"POINT ({WEST + 50} {SOUTH + 15})", {"name": "off"})])
        self.refused("probe off: found no mass at (400050, 400015)", probes={"points": "off.gpkg"})


class Gaps(MapCase):
    """A slope without data in one corner."""

    def setUp(self) -> None:
        super().setUp()
        self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {})])
        data = gdal.Open(str(self.slope()), gdal.GA_Update)
        band = data.GetRasterBand(1)
        values = band.ReadAsArray()
        values[:8, 30:] = -9999  # in the north-east
        band.SetNoDataValue(-9999)
        band.WriteArray(values)
        band = data = None

    def test_no_ground_where_there_is_no_data(self) -> None:
        self.refused("slope.tif: no data in row 8, column 31")
        self.refused("plan.json/gaps: found 'fill', allowed: refuse, open", gaps="fill")
        made = make(self.read(gaps="open"))
        said = write_scene(made, self.folder / "scene")
        self.assertTrue(any("nodes have no data: there is no ground" in line for line in said), said)
        facets = triangles_of(self.folder / "scene" / "terrain.ply")
        self.assertTrue(np.isfinite(facets).all())
        plan = facets.mean(axis=1)
        self.assertFalse(((plan[:, 0] > 57) & (plan[:, 1] > 29)).any())  # from the last values on
        sides = (facets[:, k, :2] - facets[:, 0, :2] for k in (1, 2))
        self.assertAlmostEqual(np.abs(np.cross(*sides)).sum() / 2, 60 * 40 - 3 * 11, delta=0.01)

    def test_nothing_may_stand_there(self) -> None:
        self.refused("barrier/line: found a part where the slope has no data", gaps="open",
                     barrier={"line": [[WEST + 55, SOUTH + 20], [WEST + 61, SOUTH + 40]], "height": 2, "thickness": 1})
        self.refused("gauge a: line: found a part where the slope has no data", gaps="open",
                     gauges=[{"name": "a", "line": [[WEST + 61, SOUTH + 20], [WEST + 61, SOUTH + 40]], "height": 2}])
        self.vector("there.gpkg", [(f"POLYGON ({square(54, 30, 7)})", {})])
        self.refused("slide: found a part where the slope has no data", gaps="open", slide={"polygon": "there.gpkg", "depth": 1})


class Depths(MapCase):
    def test_across_the_slope(self) -> None:
        """A plane of 0.4 to the east, 0.1 to the north: upright depth is larger by sqrt(1 + 0.17)."""
        self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {"thickness": 2.0})])
        for across, factor in ((False, 1.0), (True, np.sqrt(1.17))):
            depth = {"field": "thickness", "across_slope": across}
            made = make(self.read(slide={"polygon": "slide.shp", "depth": depth}))
            self.assertAlmostEqual(made.columns.asked, 200 * factor, delta=1e-6)
            self.assertAlmostEqual(made.columns.filled, 200 * factor, delta=1e-6)
        self.refused("depth/across_slope: found 1, allowed: true, false",
                     slide={"polygon": "slide.shp", "depth": {"field": "thickness", "across_slope": 1}})

    def test_facets_do_not_rise_into_thin_soil(self) -> None:
        """A warped cell under soil of a quarter of a cell: below points at quarters of a cell its facets are off by a share."""
        z = np.zeros((3, 3))
        z[1, 1] = -0.2
        slope, depth = Slope(1.0, z), np.full((2, 2), 0.25)
        for pieces in (2, 3, 4):
            fine = slope.cut(pieces)
            write_ply(fine, self.folder / "a.ply")
            corners = triangles_of(self.folder / "a.ply")
            off = [height_of(corners, x, y) - float(slope.at(x, y)) for x in (0.25, 0.75) for y in (0.25, 0.75)]
            self.assertAlmostEqual(slope.rise(pieces)[0, 0], max(0, *off), delta=1e-7)
        self.assertGreater(slope.bulge(2, depth).max(), BULGE)
        self.assertEqual(slope.bulge(4, depth).max(), 0)
        self.assertEqual(slope.facets(depth).spacing, 0.25)
        self.assertGreater(slope.facets(10 * depth).spacing, 0.25)
        self.assertGreater(slope.facets(0 * depth).spacing, 0.25)

    def test_soil_starts_on_facets_that_are_too_coarse(self) -> None:
        z = np.zeros((9, 9))
        z[4, 4] = -0.3
        slope = Slope(1.0, z)
        mass = Mass(None, [0.3], [Outline((np.array([(2, 2), (6, 2), (6, 6), (2, 6)], dtype=float),))])
        lift = slope.rise(2)
        self.assertGreater(lift.max(), 0.01)
        low, high = (lay_columns(slope, mass, each) for each in (None, lift))
        np.testing.assert_allclose((high.nodes - low.nodes)[:, :2], 0)
        self.assertEqual((high.nodes - low.nodes)[:, 2].max(), lift.max())
        self.assertEqual((low.filled, len(low.cells)), (high.filled, len(high.cells)))
        with mock.patch("terrain_scene.slope.MOST_FACETS", 0):
            self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {})])
            data = gdal.Open(str(self.slope()), gdal.GA_Update)
            rough = np.random.default_rng(1).uniform(0, 0.8, (24, 40))
            data.GetRasterBand(1).WriteArray(700 + rough)
            data = None
            made = make(self.read(cell_size=2, slide={"polygon": "slide.shp", "depth": 0.6}))
        self.assertEqual(made.facets.spacing, 1)
        self.assertTrue(any("columns start up to" in note for note in made.plan.notes))
        points = made.columns.nodes[made.columns.cells]
        for share in (0.25, 0.75):  # along x and y of each column; its lowest points lie a quarter of a layer above its bottom
            place = (1 - share) * points[:, 0, :2] + share * points[:, 2, :2]
            warped = np.array([made.slope.at(*each) for each in place])
            bottom = warped + points[:, 0, 2] - np.array([made.slope.at(*each) for each in points[:, 0, :2]])
            write_ply(made.facets, self.folder / "a.ply")
            self.assertLess((facet_heights(self.folder / "a.ply", place) - bottom)[:len(place)].max(), BULGE * 0.6 + 1e-6)


def triangles_of(path: Path) -> np.ndarray:
    head, body = path.read_bytes().split(b"end_header\n")
    count = int(head.split(b"element vertex ")[1].split()[0])
    nodes = np.frombuffer(body[:12 * count], "<f4").reshape(count, 3).astype(float)
    return nodes[np.frombuffer(body[12 * count:], [("size", "u1"), ("corners", "<i4", 3)])["corners"]]


def facet_heights(path: Path, places: np.ndarray) -> np.ndarray:
    triangles = triangles_of(path)
    return np.array([height_of(triangles, *place) for place in places])


def height_of(triangles: np.ndarray, x: float, y: float) -> float:
    """Of the triangle over a place, by its weights."""
    a, b, c = (triangles[:, k] for k in range(3))
    area = np.cross(b[:, :2] - a[:, :2], c[:, :2] - a[:, :2])
    place = np.array([x, y])
    second = np.cross(place - a[:, :2], c[:, :2] - a[:, :2]) / area
    third = np.cross(b[:, :2] - a[:, :2], place - a[:, :2]) / area
    k = int(np.argmax(np.minimum(np.minimum(second, third), 1 - second - third)))
    return float(a[k, 2] + second[k] * (b[k, 2] - a[k, 2]) + third[k] * (c[k, 2] - a[k, 2]))


class Layout(MapCase):
    """A folder laid out as that of AvaFrame."""

    def setUp(self) -> None:
        super().setUp()
        for name in ("REL", "DAM", "ENT"):
            (self.folder / "Inputs" / name).mkdir(parents=True)
        self.slope("Inputs/dem.tif")
        self.vector("Inputs/REL/rel.shp", [(f"POLYGON ({square(8, 14, 10)})", {"thickness": 1.0})])
        line = f"LINESTRING ({WEST + 40} {SOUTH + 12}, {WEST + 40} {SOUTH + 30})"
        self.vector("Inputs/DAM/dam.shp", [(line, {"slope": 60.0})])
        self.scene = self.folder / "scene"
        self.asked = ("--set", "friction=0.6", "--set", "barrier/height=3", "--set", "barrier/thickness=1")

    def terrain(self, *options: object) -> tuple[int, str]:
        ended = self.python_script("terrain", self.folder, self.scene, *options)
        return ended.returncode, ended.stdout + ended.stderr

    def test_one_command(self) -> None:
        self.vector("Inputs/ENT/ent.shp", [(f"POLYGON ({square(20, 14, 10)})", {})])
        code, said = self.terrain(*self.asked)
        self.assertEqual(code, 0, said)
        self.assertIn("ent.shp: entrainment: not computed, left out", said)
        self.assertIn("heights of the line and slope of its faces are not used", said)
        plan = json.loads((self.scene / "plan.json").read_text())
        self.assertEqual(plan["slide"]["depth"], {"field": "thickness", "across_slope": True})
        self.assertLess(plan["cell_size"], 4)
        again = self.python_script("terrain", self.scene / "plan.json", self.folder / "again")
        self.assertEqual(again.returncode, 0, again.stderr)
        for name in ("mpm.json", "slide.msh", "terrain.ply", "barrier.msh"):
            self.assertEqual((self.scene / name).read_bytes(), (self.folder / "again" / name).read_bytes(), name)
        (self.scene / "mpm.json").unlink()
        self.assertIn("has a scene already, with plan.json", self.terrain(*self.asked)[1])

    def test_what_the_folder_does_not_say(self) -> None:
        code, said = self.terrain()
        self.assertEqual(code, 2)
        self.assertIn("--set friction=NUMBER --set barrier/height=NUMBER --set barrier/thickness=NUMBER; without the barrier: "
                      "--set barrier=null", said)
        self.assertIn("says nothing of friction", self.terrain("--set", "barrier=null")[1])
        code, said = self.terrain("--set", "barrier=null", "--set", "friction=0.6", "--set", "cell_size=2")
        self.assertEqual(code, 0, said)
        plan = json.loads((self.scene / "plan.json").read_text())
        self.assertEqual((plan["cell_size"], "barrier" in plan), (2, False))
        self.assertIn("fricton: unknown", self.terrain(*self.asked, "--set", "fricton=1", "--replace")[1])

    def test_doubled_missing_and_empty_files(self) -> None:
        self.slope("Inputs/other.tif")
        self.assertIn("found as slope: dem.tif, other.tif, allowed: one, or the choice: --set slope=FILE", self.terrain(*self.asked)[1])
        code, said = self.terrain(*self.asked, "--set", f"slope={self.folder}/Inputs/other.tif")
        self.assertEqual(code, 0, said)
        (self.folder / "Inputs" / "other.tif").unlink()
        self.remove("Inputs/REL/rel.shp")
        for path in (self.folder / "Inputs" / "REL").iterdir():
            path.unlink()
        self.assertIn("found as release: none, allowed: one", self.terrain(*self.asked, "--replace")[1])
        self.vector("Inputs/REL/rel.gpkg", [(f"POLYGON ({square(8, 14, 10)})", {"thickness": "None"})])
        self.assertIn("thickness: found 'None', allowed: a number > 0", self.terrain(*self.asked, "--replace")[1])
        code, said = self.terrain(*self.asked, "--replace", "--set", "slide/depth=1.5")
        self.assertEqual(code, 0, said)

    def test_blocks_on_a_plane(self) -> None:
        """From rest down a plane of slope 1 and then level ground: friction times the level way is the height lost."""
        x = np.arange(200.0)
        ground = np.maximum(0, 50 - x)
        raster = Raster(Path("a"), 0.0, 0.0, 1.0, np.tile(ground, (20, 1)))
        found = reach_of(raster, np.array([[10.0, 10.0]]), 0.5, 0.5)
        self.assertAlmostEqual(found.places[:, 0].max(), 10 + 40.5 / 0.5, delta=1)
        np.testing.assert_allclose(found.places[:, 1], 10, atol=1e-6)
        self.assertAlmostEqual(found.fastest, np.sqrt(2 * 9.81 * (40.5 - 0.5 * 40)), delta=0.3)
        self.assertEqual(found.left, 0)
        self.assertEqual(reach_of(raster, np.array([[10.0, 10.0]]), 0.5, 0.05).left, 1)

    def test_changes(self) -> None:
        self.assertEqual(read_changes(["a/b=1", "a/c=x y", "d=[1, 2]", "e=null"]), {"a": {"b": 1, "c": "x y"}, "d": [1, 2], "e": None})
        for wrong in ("a", "=1", "a//b=1", "a/=2"):
            with self.assertRaisesRegex(TerrainError, "allowed: KEY=VALUE"):
                read_changes([wrong])
        with self.assertRaisesRegex(TerrainError, "a has a value already"):
            read_changes(["a=1", "a/b=2"])
        self.assertEqual(changed({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"b": 4}, "e": 5}), {"a": {"b": 4, "c": 2}, "d": 3, "e": 5})


class ResultsOnTheMap(MapCase):
    def setUp(self) -> None:
        """A scene, and made-up results: a box of soil that moves 6 m to the east, at rest at the end."""
        super().setUp()
        self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {})])
        line = [[WEST + 40, SOUTH + 10], [WEST + 40, SOUTH + 20]]
        self.made = make(self.read(gauges=[{"name": "g", "line": line, "height": 2}],
                                   barrier={"line": [[WEST + 50, SOUTH + 10], [WEST + 50, SOUTH + 20]], "height": 2, "thickness": 1}))
        write_scene(self.made, self.folder / "scene")
        self.run = self.folder / "run"
        ticks = [np.arange(0.25, length, 0.5) for length in (4, 4, 1)]
        box = np.column_stack([axis.ravel() for axis in np.meshgrid(*ticks)]) + [8, 8, 5]  # from (10, 10) on the map on
        frames = []
        for time, way, speed in ((0.0, 0, 0.0), (1.0, 2, 3.0), (2.0, 6, 0.0)):
            velocity = np.tile([speed, 0, 0], (len(box), 1))
            frames.append((time, box + [way, 0, 0], None, {"velocity": velocity, "volume": np.full(len(box), 0.125 * 1.25),
                                                           "volume_ratio": np.full(len(box), 1.25)}))
        made_up.write_series(self.run / "mpm", "soil", frames)
        made_up.write_table(self.run / "probes.csv", ["time", "soil.A.uz"], [[0, 0]])
        self.write("run/mpm/resolved_config.json", json.dumps({"mpm.json": {
            "gravity": [0, 0, -9.81], "origin": self.made.origin.tolist(), "bodies": [{"material": {"density": 1800}}]}}))

    def test_rasters_lie_on_the_cells_of_the_slope(self) -> None:
        ended = self.python_script("map", self.run, self.folder / "scene")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertNotIn("warning", ended.stdout)
        self.assertIn("2 s: 16 m³ of soil at rest on 4 cells of 2 m; largest: 1 m, 3 m/s, 1.296e+04 Pa", ended.stdout)
        slope = gdal.Open(str(self.folder / "slope.tif"))
        expected = {"depth": {16: 1.0, 18: 1.0}, "max_depth": {k: 1.0 for k in (10, 12, 14, 16, 18)},
                    "max_speed": {10: 0, 12: 3, 14: 3, 16: 0, 18: 0}, "arrival": {10: 0, 12: 0, 14: 1, 16: 2, 18: 2},
                    "max_dynamic_pressure": {10: 0, 12: 12960, 14: 12960, 16: 0, 18: 0}}
        for name, columns in expected.items():
            data = gdal.Open(str(self.run / "map" / f"{name}.tif"))
            self.assertEqual((data.RasterXSize, data.RasterYSize, data.GetGeoTransform()), (40, 24, slope.GetGeoTransform()))
            self.assertTrue(data.GetSpatialRef().IsSame(slope.GetSpatialRef()))
            values = np.full((24, 40), -9999.0)
            for x, value in columns.items():
                values[24 - 7:24 - 5, x // 2] = value  # from 10 to 14 m to the north
            np.testing.assert_allclose(data.ReadAsArray(), values, rtol=1e-6, err_msg=name)
            text = read_raster(self.run / "map" / f"{name}.asc")
            np.testing.assert_allclose(np.nan_to_num(text.values, nan=-9999)[::-1], values, rtol=1e-6)
            self.assertEqual((text.x, text.y, text.spacing), (WEST + 1, SOUTH + 1, 2))
            self.assertTrue((self.run / "map" / f"{name}.prj").exists())
            self.assertGreater((self.run / "map" / f"{name}.png").stat().st_size, 5000)

    def test_any_offset_of_the_scene_on_the_raster_keeps_the_volume(self) -> None:
        place = read_place(self.folder / "scene", [])
        for off, spacing in ((0.3, 2.0), (1.99, 2.0), (0.0, 3.7), (0.7, 0.4)):
            shape = (int(48 / spacing), int(80 / spacing))
            place.slope = Raster(self.folder / "a.asc", WEST + off, SOUTH + off, spacing, np.zeros(shape))
            out = self.folder / f"out_{off}_{spacing}"
            out.mkdir()
            self.assertIn("16 m³ of soil at rest", write_maps(Results(self.run), place, None, out)[-1])
        place.slope = Raster(self.folder / "a.asc", WEST + 15, SOUTH, 2.0, np.zeros((30, 30)))
        with self.assertRaisesRegex(TerrainError, "found soil beyond it, from .400010, 400009."):
            write_maps(Results(self.run), place, None, out)

    def test_frames_far_apart_are_said(self) -> None:
        place = read_place(self.folder / "scene", [])
        place.slope = Raster(self.folder / "a.asc", WEST, SOUTH, 0.5, np.zeros((90, 150)))
        said = write_maps(Results(self.run), place, None, self.folder)
        self.assertIn("every 1 s: the fastest soil comes on by up to 6 cells between two of them", said[-2])

    def test_sections(self) -> None:
        self.vector("lines.gpkg", [(f"LINESTRING ({WEST + 8} {SOUTH + 12}, {WEST + 24} {SOUTH + 12})", {"name": "down the slope"})], 4326)
        ended = self.python_script("map", self.run, self.folder / "scene", "--section", self.folder / "lines.gpkg")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        table = np.genfromtxt(self.run / "map" / "section_down_the_slope.csv", delimiter=",", names=True)
        np.testing.assert_allclose(table["way"][[0, -1]], [0, 16], atol=1e-2)
        np.testing.assert_allclose(table["ground"], 700 - 0.4 * (table["x"] - WEST - 1) + 0.1 * (table["y"] - SOUTH - 1), atol=1e-4)
        wet = table["x"][np.isfinite(table["max_depth"])]
        self.assertTrue(9.9 < wet.min() - WEST < 11.1 and 19 < wet.max() - WEST < 20.1)
        self.assertTrue((self.run / "map" / "section_down_the_slope.png").exists())

    def test_what_does_not_belong_together(self) -> None:
        settings = json.loads((self.folder / "scene" / "map.json").read_text())
        for text, words in (("{}", "map.json"), (json.dumps(settings | {"origin": [0, 0, 0]}), "allowed: results of that scene"),
                            (json.dumps(settings | {"slope": "gone.tif"}), "no such raster")):
            self.write("scene/map.json", text)
            ended = self.python_script("map", self.run, self.folder / "scene")
            self.assertEqual(ended.returncode, 2)
            self.assertIn(words, ended.stderr)

    def test_a_very_large_raster_is_cut(self) -> None:
        large = Raster(Path("a"), 0.5, 0.5, 1.0, np.broadcast_to(0.0, (3000, 3000)), "text")
        part = on_cells_of(large, np.array([10.0, 20.0]), np.ones((2, 3)))
        self.assertEqual((part.x, part.y, part.values.shape), (10.5, 20.5, (2, 3)))
        paths = write_ascii(part, self.folder / "a.asc")
        self.assertEqual([path.name for path in paths], ["a.asc", "a.prj"])

    def test_ground_of_pictures(self) -> None:
        x, y = np.meshgrid(np.arange(60.0), np.arange(60.0))
        points = np.column_stack([x.ravel(), y.ravel(), 0.3 * x.ravel()])
        number = np.arange(3600).reshape(60, 60)
        a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
        triangles = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        np.testing.assert_array_equal(coarse(points, triangles, 10_000), points[triangles])
        few = coarse(points, triangles, 500)
        self.assertTrue(0 < len(few) <= 500)
        np.testing.assert_allclose(few[..., 2], 0.3 * few[..., 0], atol=1e-9)  # on the plane
        normals = np.cross(few[:, 1] - few[:, 0], few[:, 2] - few[:, 0])
        self.assertTrue((normals[:, 2] > -1e-9).all())
        self.assertGreater(normals[:, 2].sum() / 2, 0.8 * 59**2)


if __name__ == "__main__":
    unittest.main()
