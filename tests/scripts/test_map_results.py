#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/terrain on a folder laid out as that of AvaFrame, and scripts/map: results on the map.

    test_map_results.py
"""

import base64
import fcntl
import json
import os
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from map_case import SOUTH, WEST, MapCase, gdal, square

import made_up_results as made_up
from plotting.ground import FLOOR, coarse, ground_of
from plotting.results import Results
from plotting.scene import ScenePlot
from plotting.space import SpacePlot
from plotting.style import plt
from reporting.frames import Packer
from reporting.maps import map_section
from reporting.page import page
from terrain_scene.changes import changed, read_changes
from terrain_scene.grids import on_cells_of, write_ascii
from terrain_scene.map_inputs import require_named_gaps
from terrain_scene.on_map import read_place, write_maps
from terrain_scene.raster import Raster, TerrainError, read_raster
from terrain_scene.reach import reach_of
from terrain_scene.scene import make, write_scene


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

    def test_places_on_the_command_line(self) -> None:
        """Rows of numbers instead of files: the scene is that of the files with these numbers."""
        self.assertEqual(self.terrain(*self.asked, "--set", "slide/depth=1")[0], 0)
        of_files = json.loads((self.scene / "plan.json").read_text())
        self.vector("Inputs/DAM/dam.shp", [(f"LINESTRING ({WEST + 70} {SOUTH + 2}, {WEST + 70} {SOUTH + 40})", {})])
        self.vector("Inputs/DAM/other.shp", [(f"LINESTRING ({WEST + 60} {SOUTH + 2}, {WEST + 60} {SOUTH + 40})", {})])
        self.vector("Inputs/REL/other.shp", [(f"POLYGON ({square(50, 5, 10)})", {})])
        rows = [[float(x) for x in corner.split()] for corner in square(8, 14, 10).strip("()").split(",")][:-1]
        line = [[WEST + 40, SOUTH + 12], [WEST + 40, SOUTH + 30]]
        set_rows = (*self.asked, "--set", f"barrier/line={line}", "--set", f"slide/polygon={rows}", "--replace")
        code, said = self.terrain(*set_rows, "--set", "slide/depth=1")
        self.assertEqual(code, 0, said)
        self.assertNotIn("heights of the line", said)
        plan = json.loads((self.scene / "plan.json").read_text())
        self.assertEqual((plan["barrier"]["line"], plan["slide"]["polygon"]), (line, rows))
        for key in ("area", "time", "clear_height", "cell_size"):
            self.assertEqual(plan[key], of_files[key], key)
        self.assertIn("a polygon of numbers, which have no depth", self.terrain(*set_rows)[1])

    def test_a_folder_that_another_process_writes(self) -> None:
        """Of two at once one is refused, and leaves the other's files alone."""
        self.scene.mkdir()
        handle = os.open(self.scene, os.O_RDONLY)
        self.addCleanup(os.close, handle)
        fcntl.flock(handle, fcntl.LOCK_EX)
        code, said = self.terrain(*self.asked, "--replace")
        self.assertEqual(code, 2)
        self.assertIn("another process writes a scene there now", said)
        self.assertEqual(list(self.scene.iterdir()), [])

    def test_what_the_folder_does_not_say(self) -> None:
        code, said = self.terrain()
        self.assertEqual(code, 2)
        self.assertFalse(self.scene.exists())  # nothing is left of what was refused
        self.assertIn("--set friction=NUMBER --set barrier/height=NUMBER --set barrier/thickness=NUMBER; without the "
                      "barrier: --set barrier=null", said)
        self.assertIn("says nothing of friction", self.terrain("--set", "barrier=null")[1])
        code, said = self.terrain("--set", "barrier=null", "--set", "friction=0.6", "--set", "cell_size=2")
        self.assertEqual(code, 0, said)
        plan = json.loads((self.scene / "plan.json").read_text())
        self.assertEqual((plan["cell_size"], "barrier" in plan), (2, False))
        self.assertIn("fricton: unknown", self.terrain(*self.asked, "--set", "fricton=1", "--replace")[1])

    def test_a_material_without_law_is_the_default_with_changes(self) -> None:
        code, said = self.terrain(*self.asked, "--set", "slide/material/density=300")
        self.assertEqual(code, 0, said)
        self.assertIn("material: has no law, taken: ", said)
        body, = json.loads((self.scene / "mpm.json").read_text())["bodies"]
        self.assertEqual((body["material"]["density"], body["material"]["law"]), (300, "mohr_coulomb"))

    def test_changes_that_cannot_be(self) -> None:
        for change, words in (("slide=5", "--set/slide: found 5, allowed: an object"),
                              ("time=3", "--set/time: found 3"),
                              ("cell_size=abc", "--set/cell_size: found 'abc'"),
                              ("area=[1, 2]", "--set/area: found [1, 2]"),
                              ("area=none.shp", "none.shp: no such file"),
                              ("slide/depth=-1", "/slide/depth: found -1"), ("gaps=maybe", "/gaps: found 'maybe'"),
                              ("friction=-1", "--set/friction: found -1"), ("gauges=1", "/gauges: found 1")):
            code, said = self.terrain(*self.asked, "--set", change)
            self.assertEqual(code, 2, said)
            self.assertIn(words, said)
        self.assertIn("--set barrier=5: allowed: null", self.terrain("--set", "friction=1", "--set", "barrier=5")[1])
        self.vector("area.gpkg", [(f"POLYGON ({square(2, 2, 42)})", {})], 4326)
        code, said = self.terrain(*self.asked, "--set", f"area={self.folder}/area.gpkg")
        self.assertEqual(code, 0, said)

    def test_doubled_missing_and_empty_files(self) -> None:
        self.slope("Inputs/other.tif")
        self.assertRegex(self.terrain(*self.asked)[1],  # paths as --set takes them
                         r"found as slope: \S+/Inputs/dem.tif, \S+/Inputs/other.tif, allowed: one, or the choice: "
                         "--set slope=FILE")
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
        """Blocks slide from rest down a slope of 1 and on level ground: the height lost is friction times the level
        distance."""
        x = np.arange(200.0)
        ground = np.maximum(0, 50 - x)
        raster = Raster(Path("a"), 0.0, 0.0, 1.0, np.tile(ground, (20, 1)))
        found = reach_of(raster, np.array([[10.0, 10.0]]), 0.5, 0.5)
        self.assertAlmostEqual(found.places[:, 0].max(), 10 + 40.5 / 0.5, delta=1)
        np.testing.assert_allclose(found.places[:, 1], 10, atol=1e-6)
        self.assertAlmostEqual(found.fastest, np.sqrt(2 * 9.81 * (40.5 - 0.5 * 40)), delta=0.3)
        self.assertEqual(found.left, 0)
        self.assertEqual(reach_of(raster, np.array([[10.0, 10.0]]), 0.5, 0.05).left, 1)

    def test_heights_that_stand_for_no_data(self) -> None:
        heights = np.tile(np.arange(5.0), (4, 1))
        require_named_gaps(Raster(Path("a.tif"), 0.0, 0.0, 1.0, heights), "plan/slope")
        heights[1, 2:4] = -9999
        with self.assertRaisesRegex(TerrainError, "plan/slope: a.tif: found 2 heights of -9999 m, .*a_nodata -9999"):
            require_named_gaps(Raster(Path("a.tif"), 0.0, 0.0, 1.0, heights), "plan/slope")

    def test_changes(self) -> None:
        self.assertEqual(read_changes(["a/b=1", "a/c=x y", "d=[1, 2]", "e=null"]),
                         {"a": {"b": 1, "c": "x y"}, "d": [1, 2], "e": None})
        for wrong in ("a", "=1", "a//b=1", "a/=2"):
            with self.assertRaisesRegex(TerrainError, "allowed: KEY=VALUE"):
                read_changes([wrong])
        with self.assertRaisesRegex(TerrainError, "a has a value already"):
            read_changes(["a=1", "a/b=2"])
        self.assertEqual(changed({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"b": 4}, "e": 5}),
                         {"a": {"b": 4, "c": 2}, "d": 3, "e": 5})


class ResultsOnTheMap(MapCase):
    def setUp(self) -> None:
        """A scene, and made-up results: a box of soil that moves 6 m to the east, at rest at the end."""
        super().setUp()
        self.vector("slide.shp", [(f"POLYGON ({square(10, 10, 10)})", {})])
        line = [[WEST + 40, SOUTH + 10], [WEST + 40, SOUTH + 20]]
        self.made = make(self.read(gauges=[{"name": "g", "line": line, "height": 2}],
                                   barrier={"line": [[WEST + 50, SOUTH + 10], [WEST + 50, SOUTH + 20]], "height": 2,
                                            "thickness": 1}))
        write_scene(self.made, self.folder / "scene")
        self.run = self.folder / "run"
        ticks = [np.arange(0.25, length, 0.5) for length in (4, 4, 1)]
        box = np.column_stack([axis.ravel() for axis in np.meshgrid(*ticks)]) + [8, 8, 5]  # from (10, 10) on the map on
        frames = []
        for time, way, speed in ((0.0, 0, 0.0), (1.0, 2, 3.0), (2.0, 6, 0.0)):
            velocity = np.tile([speed, 0, 0], (len(box), 1))
            frames.append((time, box + [way, 0, 0], None,
                           {"velocity": velocity, "volume": np.full(len(box), 0.125 * 1.25),
                                                           "volume_ratio": np.full(len(box), 1.25)}))
        made_up.write_series(self.run / "mpm", "soil", frames)
        made_up.write_table(self.run / "probes.csv", ["time", "soil.A.uz"], [[0, 0]])
        self.write("run/mpm/resolved_config.json", json.dumps({"mpm.json": {
            "gravity": [0, 0, -9.81], "origin": self.made.origin.tolist(),
            "bodies": [{"material": {"density": 1800}}]}}))

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
            self.assertEqual((data.RasterXSize, data.RasterYSize, data.GetGeoTransform()),
                             (40, 24, slope.GetGeoTransform()))
            self.assertTrue(data.GetSpatialRef().IsSame(slope.GetSpatialRef()))
            values = np.full((24, 40), -9999.0)
            for x, value in columns.items():
                values[24 - 7:24 - 5, x // 2] = value  # from 10 to 14 m to the north
            np.testing.assert_allclose(data.ReadAsArray(), values, rtol=1e-6, err_msg=name)
            text = read_raster(self.run / "map" / f"{name}.asc")
            np.testing.assert_allclose(np.nan_to_num(text.values, nan=-9999)[::-1], values, rtol=1e-6)
            self.assertEqual((text.x, text.y, text.spacing), (WEST + 1, SOUTH + 1, 2))
            words = (self.run / "map" / f"{name}.prj").read_text()
            self.assertIn("D_MGI", words)  # as ESRI calls the datum
            self.assertNotIn("AUTHORITY", words)
            self.assertGreater((self.run / "map" / f"{name}.png").stat().st_size, 5000)

    def test_any_offset_of_the_scene_on_the_raster_keeps_the_volume(self) -> None:
        place = read_place(self.folder / "scene", [])
        self.enterContext(mock.patch("terrain_scene.on_map.draw_map"))  # pictures take time
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
        self.enterContext(mock.patch("terrain_scene.on_map.draw_map"))
        place.slope = Raster(self.folder / "a.asc", WEST, SOUTH, 0.5, np.zeros((90, 150)))
        said = write_maps(Results(self.run), place, None, self.folder)
        self.assertIn("every 1 s: the fastest soil moves by up to 6 cells between two of them", said[-2])

    def test_sections(self) -> None:
        self.enterContext(mock.patch("terrain_scene.on_map.draw_map"))
        self.vector("lines.gpkg", [(f"LINESTRING ({WEST + 8} {SOUTH + 12}, {WEST + 24} {SOUTH + 12})",
                                    {"name": "down the slope"})], 4326)
        ended = self.python_script("map", self.run, self.folder / "scene", "--section", self.folder / "lines.gpkg")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        table = np.genfromtxt(self.run / "map" / "section_down_the_slope.csv", delimiter=",", names=True)
        np.testing.assert_allclose(table["way"][[0, -1]], [0, 16], atol=1e-2)
        np.testing.assert_allclose(table["ground"],
                                   700 - 0.4 * (table["x"] - WEST - 1) + 0.1 * (table["y"] - SOUTH - 1), atol=1e-4)
        wet = table["x"][np.isfinite(table["max_depth"])]
        self.assertTrue(9.9 < wet.min() - WEST < 11.1 and 19 < wet.max() - WEST < 20.1)
        self.assertTrue((self.run / "map" / "section_down_the_slope.png").exists())

    def test_what_does_not_belong_together(self) -> None:
        settings = json.loads((self.folder / "scene" / "map.json").read_text())
        for text, words in (("{}", "map.json"),
                            (json.dumps(settings | {"origin": [0, 0, 0]}), "allowed: results of that scene"),
                            (json.dumps(settings | {"slope": "gone.tif"}), "no such raster")):
            self.write("scene/map.json", text)
            ended = self.python_script("map", self.run, self.folder / "scene")
            self.assertEqual(ended.returncode, 2)
            self.assertIn(words, ended.stderr)
        missing = self.python_script("map", self.run, self.folder)
        self.assertEqual(missing.returncode, 2)
        self.assertIn("map.json: No such file or directory, allowed", missing.stderr)

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
    def test_every_picture_of_a_scene_in_space_shows_the_ground(self) -> None:
        settings = json.loads((self.run / "mpm" / "resolved_config.json").read_text())
        settings["mpm.json"]["rigid_walls"] = [{"name": "terrain",
                                                "surface": {"triangles": "terrain.ply", "normals": "up"}}]
        self.write("run/mpm/resolved_config.json", json.dumps(settings))
        points = np.array([(0, 0, 8), (20, 0, 0), (20, 20, 0), (0, 20, 8)], dtype=float)
        cells = np.array([(0, 1, 2), (0, 2, 3)])
        made_up.write_series(self.run / "mpm", "contact_terrain", [(0.0, points, cells, {"pressure": np.zeros(2)})])
        results = Results(self.run)
        np.testing.assert_array_equal(ground_of(results), points[cells])
        side, space = ScenePlot(results), SpacePlot(results, None, (30.0, 25.0))
        np.testing.assert_array_equal(side.ground[0].max(axis=(0, 1)), [20, 8])  # x to the right, z upwards
        self.assertTrue((side.high > [19, 7]).all())  # wider than the soil
        self.assertEqual(len(space.ground), 2)
        figure, axes = plt.subplots(1, 2)
        for view, each in zip((side, space), axes):
            view.draw(each, 0.0)
            faces = sum(len(part.get_paths()) for part in each.collections)
            self.assertGreater(faces, 2)
            drawn = np.vstack([part.get_facecolor()[:, :3] for part in each.collections])
            self.assertTrue(np.isclose(drawn / drawn.max(axis=1, keepdims=True).clip(1e-9), FLOOR / FLOOR[0],
                                       atol=0.01).all(axis=1).any())
        plt.close(figure)
        packed = Packer(results).pack()["ground"]
        corners = np.frombuffer(base64.b64decode(packed["corners"]), "<i4").reshape(2, 3, 2)
        self.assertEqual(len(base64.b64decode(packed["bright"])), 2)
        window = side.high - side.low
        np.testing.assert_allclose(side.low + corners / 65535 * window, side.ground[0], atol=1e-3)

    def test_the_page_of_a_run_has_the_maps(self) -> None:
        self.python_script("map", self.run, self.folder / "scene")
        problems: list[str] = []
        text = map_section(self.run, problems)
        self.assertEqual((text.count("<img alt="), problems), (2, []))
        self.assertIn('<section id="map">', page(Results(self.run)))
        self.assertEqual(map_section(self.folder, problems), "")
        os.utime(self.run / "map" / "depth.png", (0, 1e9))
        self.assertEqual(map_section(self.run, problems), "")
        self.assertIn("the maps are older than the last frame", problems[0])


if __name__ == "__main__":
    unittest.main()
