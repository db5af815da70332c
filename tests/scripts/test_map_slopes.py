#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/terrain on slopes of maps: without data in places, depths across the slope, facets below thin soil.

    test_map_slopes.py
"""

import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from map_case import SOUTH, WEST, MapCase, gdal, square
from terrain_scene.depths import Mass
from terrain_scene.outline import Outline
from terrain_scene.scene import make, write_scene
from terrain_scene.slope import BULGE, Slope, lay_columns, write_ply


def triangles_of(path: Path) -> np.ndarray:
    head, body = path.read_bytes().split(b"end_header\n")
    count = int(head.split(b"element vertex ")[1].split()[0])
    nodes = np.frombuffer(body[:12 * count], "<f4").reshape(count, 3).astype(float)
    return nodes[np.frombuffer(body[12 * count:], [("size", "u1"), ("corners", "<i4", 3)])["corners"]]


def facet_heights(path: Path, places: np.ndarray) -> np.ndarray:
    triangles = triangles_of(path)
    return np.array([height_of(triangles, *place) for place in places])


def height_of(triangles: np.ndarray, x: float, y: float) -> float:
    """Height of the triangle over a place, by its weights."""
    a, b, c = (triangles[:, k] for k in range(3))
    area = np.cross(b[:, :2] - a[:, :2], c[:, :2] - a[:, :2])
    place = np.array([x, y])
    second = np.cross(place - a[:, :2], c[:, :2] - a[:, :2]) / area
    third = np.cross(b[:, :2] - a[:, :2], place - a[:, :2]) / area
    k = int(np.argmax(np.minimum(np.minimum(second, third), 1 - second - third)))
    return float(a[k, 2] + second[k] * (b[k, 2] - a[k, 2]) + third[k] * (c[k, 2] - a[k, 2]))


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
        self.refused("slide: found a part where the slope has no data", gaps="open",
                     slide={"polygon": "there.gpkg", "depth": 1})


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
        """A warped cell under soil of a quarter of a cell: below points at quarters of a cell its facets are off by a
        share."""
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
        # along x and y of each column; its lowest points lie a quarter of a layer above its bottom
        for share in (0.25, 0.75):
            place = (1 - share) * points[:, 0, :2] + share * points[:, 2, :2]
            warped = np.array([made.slope.at(*each) for each in place])
            bottom = warped + points[:, 0, 2] - np.array([made.slope.at(*each) for each in points[:, 0, :2]])
            write_ply(made.facets, self.folder / "a.ply")
            self.assertLess((facet_heights(self.folder / "a.ply", place) - bottom)[:len(place)].max(),
                            BULGE * 0.6 + 1e-6)

if __name__ == "__main__":
    unittest.main()
