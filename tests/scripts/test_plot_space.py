#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scenes in space as one sees them: the surface of a cloud, the camera, the file that ParaView opens."""

import json
import re
import shutil
import unittest
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np
from script_case import ScriptCase

import made_up_results as made_up
from plotting.collection import write_collection
from plotting.results import Results, ResultsError
from plotting.space import SpacePlot, box_side, camera_of, normals_of, rigid_walls, shade
from plotting.surface import surface_of

RADIUS = 10.0


def lattice() -> np.ndarray:
    """Points of a cubic lattice of distance 1 in a sphere, off its centre."""
    axis = np.arange(-12, 13) + 0.3
    points = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3)
    return points[np.linalg.norm(points, axis=1) < RADIUS]


class SurfaceOfASphere(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        points = lattice()
        cls.points = points
        cls.surface = surface_of(0.05 * points, 3 * points[:, 2] + 40, 0.05)
        cls.centres = cls.surface.triangles.mean(axis=1) / 0.05

    def areas(self) -> np.ndarray:
        corners = self.surface.triangles / 0.05
        return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)

    def test_it_is_where_the_points_end(self) -> None:
        radii = np.linalg.norm(self.centres, axis=1)
        self.assertAlmostEqual(np.average(radii, weights=self.areas()), RADIUS, delta=0.2)
        self.assertLess(np.ptp(radii), 1.2)

    def test_it_is_closed(self) -> None:
        """Each edge belongs to two triangles, and the volume by Gauss's theorem is that of the points."""
        corners = np.round(self.surface.triangles.reshape(-1, 3) / 0.05, 6)
        _, number = np.unique(corners, axis=0, return_inverse=True)
        triangles = number.reshape(-1, 3)
        triangles = triangles[[len(set(t)) == 3 for t in triangles.tolist()]]  # those cut at a corner have no area
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        _, count = np.unique(edges, axis=0, return_counts=True)
        self.assertEqual(set(count.tolist()), {2})
        normals = normals_of(self.surface.triangles)
        turned = np.sign(np.sum(normals * self.surface.normals, axis=1))
        volume = np.sum(turned * np.sum(self.centres * normals, axis=1) * self.areas()) / 3
        self.assertAlmostEqual(volume, len(self.points), delta=0.05 * len(self.points))

    def test_normals_point_outwards(self) -> None:
        outwards = self.centres / np.linalg.norm(self.centres, axis=1, keepdims=True)
        self.assertGreater(np.sum(outwards * self.surface.normals, axis=1).min(), 0.9)

    def test_values_are_those_of_the_points_there(self) -> None:
        """The outermost points lie up to a distance further inside than the surface."""
        np.testing.assert_allclose(self.surface.values, 3 * self.centres[:, 2] + 40, atol=3 * 1.2)

    def test_a_point_far_off_does_not_take_all_memory(self) -> None:
        points = np.vstack([lattice(), [[4000.0, 4000, 4000]]])
        self.assertGreater(len(surface_of(points, np.ones(len(points)), 1.0).triangles), 0)

    def test_single_points_are_named(self) -> None:
        points = np.vstack([[[20.0, 0, 0]], lattice(), [[0, 20.0, 0]]])
        loose = surface_of(points, np.ones(len(points)), 1.0).loose
        self.assertEqual(loose[[0, -1]].tolist(), [0, len(points) - 1])
        self.assertTrue(np.all(np.linalg.norm(points[loose], axis=1) > RADIUS - 1.2))


class Seen(ScriptCase):
    def test_gravity_points_down_and_the_slope_runs_to_the_right(self) -> None:
        gravity = [4.905, 0, -8.496]
        camera = camera_of(gravity, np.ones(3), 0, 0)
        np.testing.assert_allclose(camera.project(np.array(gravity)), [0, -np.linalg.norm(gravity)], atol=1e-12)
        self.assertGreater(camera.project(np.array([1.0, 0, 0]))[0], 0.8)
        for azimuth, elevation in ((0, 0), (30, 25), (-120, 60)):
            camera = camera_of(gravity, np.ones(3), azimuth, elevation)
            frame = np.stack([camera.right, camera.up, camera.eye])
            np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
            self.assertAlmostEqual(np.linalg.det(frame), 1)
        downhill = camera_of(gravity, np.ones(3), 90, 0)
        self.assertGreater(downhill.depth(np.array([1.0, 0, 0])), 0.8)

    def test_longest_level_extent_without_a_slope(self) -> None:
        camera = camera_of([0, 0, -9.81], np.array([1, 5, 9]), 0, 0)
        np.testing.assert_allclose(np.abs(camera.right), [0, 1, 0], atol=1e-12)

    def test_light_from_above(self) -> None:
        camera = camera_of(None, np.ones(3), 0, 30)
        above, below = shade(np.ones(3), np.array([[0, 0, 1.0], [0, 0, -1.0]]), camera)
        self.assertGreater(above[0], 1.5 * below[0])

    def test_sides_of_boxes_point_outwards(self) -> None:
        for side, normal in (("left", [-1, 0, 0]), ("right", [1, 0, 0]), ("front", [0, -1, 0]), ("back", [0, 1, 0]),
                             ("bottom", [0, 0, -1]), ("top", [0, 0, 1])):
            tiles = box_side([0, 0, 0], [2, 3, 4], side)
            np.testing.assert_allclose(normals_of(tiles), np.tile(normal, (len(tiles), 1)), err_msg=side)
            centre = tiles.mean(axis=(0, 1)) - [1, 1.5, 2]
            np.testing.assert_allclose(centre, np.array(normal) * [1, 1.5, 2], atol=1e-12)

    def settings(self, mpm: dict) -> Results:
        folder = made_up.write_space_results(self.folder / "a")
        (folder / "mpm" / "resolved_config.json").write_text(json.dumps({"mpm.json": {"gravity": [0, 0, -9.81],
                                                                                      **mpm}}))
        return Results(folder)

    def test_rigid_walls_else_the_floor_of_the_grid(self) -> None:
        box = {"box": {"low": [0, 0, -1], "high": [1, 1, 0]}}
        walls = [{"group": "bottom", "condition": "fixed"}]
        (floor,) = rigid_walls(self.settings({"grid": box, "walls": walls}))
        np.testing.assert_allclose(normals_of(floor)[0], [0, 0, 1])
        self.assertEqual(np.unique(floor[..., 2]).tolist(), [-1])
        wall = {"name": "bed", "surface": {"mesh": box, "groups": ["top"]}}
        (bed,) = rigid_walls(self.settings({"grid": box, "walls": walls, "rigid_walls": [wall]}))
        self.assertEqual(np.unique(bed[..., 2]).tolist(), [0])
        self.assertEqual(rigid_walls(self.settings({"grid": box, "walls": []})), [])

    def test_pictures(self) -> None:
        folder = made_up.write_space_results(self.folder / "a")
        result = self.python_script("plot", folder, "--space", 20, 30, "--times", 0, 0.2, 0.4, "--animate")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([line.rsplit("/", 1)[1] for line in result.stdout.splitlines()], ["space.png", "space.gif"])
        for name in ("space.png", "space.gif"):
            self.assertGreater((folder / "plots" / name).stat().st_size, 5000)

    def test_beams_are_drawn_by_the_surface_around_them(self) -> None:
        folder = made_up.write_beams(self.folder / "beams")
        (posts,) = Results(folder).beam_surfaces
        np.testing.assert_allclose(posts.frame(5).points, posts.frame(0).points + [made_up.END, 0, 0])
        for options in (("--space", 20, 30), ()):
            result = self.python_script("plot", folder, *options, "--times", 0, 0.4)
            self.assertEqual(result.returncode, 0, result.stderr)

    def test_lines_alone(self) -> None:
        folder = made_up.write_beams(self.folder / "beams")
        shutil.rmtree(folder / "mpm")
        for command in (("plot", folder, "--space", 20, 30), ("plot", folder), ("report", folder)):
            result = self.python_script(*command)
            self.assertEqual(result.returncode, 0, result.stderr)
        text = (folder / "report.html").read_text()
        scene = json.loads(re.search(r'<script type="application/json" id="scene-data">(.*?)</script>', text)[1])
        self.assertEqual([each["corners"] for each in scene["structures"]], [2])

    def test_what_cannot_be_drawn_is_said(self) -> None:
        with self.assertRaisesRegex(ResultsError, "a scene in 2D has no view in space"):
            SpacePlot(Results(made_up.write_results(self.folder / "flat")), None, (0, 0))
        result = self.python_script("plot", made_up.write_space_results(self.folder / "a"), "--space", 20)
        self.assertEqual(result.returncode, 2)
        self.assertIn("--space: found 1 numbers", result.stderr)


class Collection(ScriptCase):
    def test_every_dataset_is_there_in_its_shape(self) -> None:
        results = Results(made_up.write_space_results(self.folder / "a"))
        path = write_collection(results)
        tree = ElementTree.parse(path)
        steps = tree.findall("Domain/Grid/Grid")
        self.assertEqual([float(step.find("Time").get("Value")) for step in steps], results.soil.times.tolist())
        for step in steps:
            self.assertEqual([grid.get("Name") for grid in step.findall("Grid")], ["mpm", "fem"])
            self.assertEqual(len(list(step.iter("Time"))), 1)
        items = list(tree.iter("DataItem"))
        self.assertGreater(len(items), 4 * len(steps))
        for item in items:
            file, _, dataset = item.text.partition(":")
            with h5py.File(path.parent / file) as data:
                size = [int(n) for n in item.get("Dimensions").split()]
                self.assertEqual(data[dataset].size, np.prod(size), item.text)

    def test_one_series_needs_none(self) -> None:
        folder = made_up.write_space_results(self.folder / "a")
        (folder / "fem" / "structure.xdmf").unlink()
        self.assertIsNone(write_collection(Results(folder)))
        self.assertFalse((folder / "scene.xdmf").exists())


if __name__ == "__main__":
    unittest.main()
