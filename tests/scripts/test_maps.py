#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/terrain with files of maps: polygons, lines and points, rasters with a projection.

    test_maps.py
"""

import json
import unittest

import numpy as np
from map_case import LAMBERT, SOUTH, WEST, MapCase, gdal, square
from terrain_scene.outline import Outline, crossing_of
from terrain_scene.raster import TerrainError, read_raster
from terrain_scene.scene import make


class Polygons(MapCase):
    def test_every_format_has_the_same_volume(self) -> None:
        """A square of 12 m with a hole of 4 m, and another square, in two features or one of two parts; turned from
        degrees."""
        holed = f"({square(10, 10, 12)}, {square(14, 14, 4, False)})"
        volume = 1.5 * (144 - 16 + 36)
        for name, number in (("a.shp", LAMBERT), ("a.gpkg", LAMBERT), ("b.gpkg", 4326), ("c.gpkg", 32633),
                             ("a.geojson", 4326),
                             ("a.kml", 4326)):
            for parts in ([f"POLYGON {holed}", f"POLYGON ({square(30, 20, 6)})"],
                          [f"MULTIPOLYGON ({holed}, ({square(30, 20, 6, False)}))"]):
                self.vector(name, [(text, {}) for text in parts], number)
                plan = self.read(slide={"polygon": name, "depth": 1.5})
                made = make(plan)
                self.assertAlmostEqual(made.columns.asked, volume, delta=2e-3 * volume if number != LAMBERT else 1e-9,
                                       msg=name)
                # Sides turned from another projection do not follow the cells, whose samples count as a whole.
                self.assertAlmostEqual(made.columns.filled, volume, delta=0.02 * volume if number != LAMBERT else 1e-9,
                                       msg=name)
                self.assertEqual(any("turned from" in note for note in plan.notes), number != LAMBERT, plan.notes)
                self.remove(name)

    def test_depth_from_an_attribute(self) -> None:
        shapes = [f"POLYGON ({square(10, 10, 10)})", f"POLYGON ({square(20, 10, 10)})"]  # with one side in common
        depth = {"field": "THICKNESS"}
        for first, second in ((1.0, 2.0), ("1.0", "2")):
            self.vector("slide.shp", [(shapes[0], {"thickness": first}), (shapes[1], {"thickness": second})])
            self.assertAlmostEqual(make(self.read(slide={"polygon": "slide.shp", "depth": depth})).columns.asked, 300,
                                   delta=1e-9)
            self.remove("slide.shp")
        for wrong in (0.0, -1.0, "None", "", None):
            self.vector("slide.shp", [(shapes[0], {"thickness": "1" if isinstance(wrong, str) else 1.0}),
                                      (shapes[1], {"thickness": wrong} if wrong is not None else {})])
            self.refused("plan.json/slide/depth/field: ", "slide.shp: feature 1: thickness: found",
                         "allowed: a number > 0",
                         slide={"polygon": "slide.shp", "depth": depth})
            self.remove("slide.shp")
        self.vector("slide.shp", [(shapes[0], {"d": 1.0})])
        self.refused("feature 0: no attribute THICKNESS, allowed: d", slide={"polygon": "slide.shp", "depth": depth})
        rows = [[WEST + 10, SOUTH + 10], [WEST + 20, SOUTH + 10], [WEST + 20, SOUTH + 20]]
        self.refused("needs polygons of a file", slide={"polygon": rows, "depth": depth})

    def test_shapes_that_cannot_be_are_named_with_their_place(self) -> None:
        good = (f"POLYGON ({square(10, 10, 10)})", {})
        bow = f"POLYGON (({WEST + 10} {SOUTH + 10}, {WEST + 20} {SOUTH + 20}, {WEST + 20} {SOUTH + 10}, " \
              f"{WEST + 10} {SOUTH + 20}, {WEST + 10} {SOUTH + 10}))"
        for words, features in (
                (("feature 2: found a polygon that is none", "Self-intersection", "400015 400015"), [good, (bow, {})]),
                (("feature 1: found a polygon that is none", "Hole lies outside"),
                 [(f"POLYGON ({square(10, 10, 10)}, {square(30, 30, 4)})", {})]),
                (("feature 2: overlaps feature 1 by 100 m^2 at (400015, 400015)",), [good, good]),
                (("feature 2: overlaps feature 1 by 25 m^2",), [good, (f"POLYGON ({square(15, 15, 10)})", {})]),
                (("feature 2: found no geometry",), [good, (None, {})]),
                (("feature 1: found a linestring, allowed: a polygon",), [(f"LINESTRING {square(10, 10, 9)}", {})]),
                (("found no feature",), []),
                (("polygon 2: found (400090, 400010) outside the area",),
                 [good, (f"POLYGON ({square(90, 10, 5)})", {})])):
            self.vector("slide.gpkg", features)
            self.refused("slide.gpkg" if "polygon 2" not in words[0] else "plan.json/slide/polygon", *words,
                         slide={"polygon": "slide.gpkg", "depth": 1})
            self.remove("slide.gpkg")
        rows = [[WEST + x, SOUTH + y] for x, y in ((10, 10), (20, 20), (20, 10), (10, 20))]
        self.refused("plan.json/slide/polygon: found sides that cross at (400015, 400015)",
                     slide={"polygon": rows, "depth": 1})

    def test_layers_and_files_that_are_not_there(self) -> None:
        self.vector("a.gpkg", [(f"POLYGON ({square(10, 10, 10)})", {})], layer="one")
        self.vector("a.gpkg", [(f"POLYGON ({square(10, 10, 5)})", {})], layer="two")
        self.refused("found the layers one, two, allowed: one", "a.gpkg|layername=NAME",
                     slide={"polygon": "a.gpkg", "depth": 1})
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
        self.refused("plan.json/projection: found MGI / Austria GK West", "names MGI / Austria Lambert",
                     projection="EPSG:31254")
        self.refused("plan.json/projection: found the projection \"EPSG:0\"", projection="EPSG:0")
        self.refused("plan.json/projection: found 5", projection=5)
        self.read(projection=f"EPSG:{LAMBERT}")  # the same again
        self.slope(number=2225)  # US survey feet
        self.refused("/slope: ", "in US survey foot, allowed: one in metres")
        self.slope(number=4326, spacing=1e-4)
        self.refused("/slope: ", "WGS 84 in degrees, allowed: one in metres")
        for number in (3857, 3395):  # of web maps, and Mercator's own: metres are long, away from the equator
            self.slope(number=number, south=6e6)
            self.refused("/slope: ", "Mercator whose metre is 0.6", "allowed: one in metres on the ground")
        self.slope(number=4978)
        self.refused("/slope: ", "WGS 84 from the centre of the earth")
        self.slope(number=None, spacing=1e-4)
        self.refused("/slope: ", "heights that differ by", "look like degrees")

    def test_metres_in_a_file_that_says_degrees(self) -> None:
        """GeoJSON without "crs", whose numbers are those of the map, or in the other order."""
        corners = [[WEST + x, SOUTH + y] for x, y in ((10, 10), (20, 10), (20, 20), (10, 10))]
        self.write("a.geojson", json.dumps({"type": "Polygon", "coordinates": [corners]}))
        self.refused("found (400010, 400010), but its projection is WGS 84, in degrees",
                     slide={"polygon": "a.geojson", "depth": 1})
        rows = [[SOUTH + 12, WEST + 55], [SOUTH + 20, WEST + 55]]
        self.vector("slide.shp", self.square)
        self.refused("with x and y exchanged they lie inside",
                     barrier={"line": rows, "height": 2, "thickness": 0.5})

    def test_rasters_in_another_projection_are_refused(self) -> None:
        self.vector("slide.shp", self.square)
        for key in ("depth", "top"):
            self.slope("other.tif", 31254)
            self.refused("other.tif: found the projection MGI / Austria GK West",
                         "slope.tif, has MGI / Austria Lambert",
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

    def test_a_mask_says_where_there_is_no_data(self) -> None:
        for inside in ("YES", "NO"):  # in the file, or beside it
            with self.subTest(inside=inside):
                gdal.SetConfigOption("GDAL_TIFF_INTERNAL_MASK", inside)
                self.addCleanup(gdal.SetConfigOption, "GDAL_TIFF_INTERNAL_MASK", None)
                path = self.slope()
                heights = read_raster(path).values
                data = gdal.Open(str(path), gdal.GA_Update)
                data.CreateMaskBand(gdal.GMF_PER_DATASET)
                mask = np.full(heights.shape, 255, dtype=np.uint8)
                mask[4, 7] = 0  # of rows from the north
                data.GetRasterBand(1).GetMaskBand().WriteArray(mask)
                data = None
                heights[-5, 7] = np.nan
                np.testing.assert_array_equal(read_raster(path).values, heights)

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
        return "LINESTRING (" + ", ".join(" ".join(f"{a:.10g}" for a in (WEST + x, SOUTH + y, *z)) for x, y,
                                          *z in corners) + ")"

    def test_a_barrier_of_a_file(self) -> None:
        """A corner that is there twice is one; heights of a line are not looked at."""
        self.vector("dam.shp",
                    [(self.line((50, 10, 9), (50, 20, 9), (50, 20, 9), (52, 30, 9)).replace("STRING", "STRING Z"), {})])
        barrier = {"height": 2, "thickness": 1}
        plan = self.read(barrier={"line": "dam.shp"} | barrier)
        np.testing.assert_allclose(plan.barrier.line,
                                   [[WEST + 50, SOUTH + 10], [WEST + 50, SOUTH + 20], [WEST + 52, SOUTH + 30]])
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
        ends = [(self.line((30, 8), (30, 30)), {"name": "upper throat", "h": 3.0}),
                (self.line((40, 8), (40, 30)), {"name": "low", "h": 4.0})]
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

if __name__ == "__main__":
    unittest.main()
