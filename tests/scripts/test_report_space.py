#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/report: how scenes in space, boulders and rigid walls are packed, and the library that draws them."""

import base64
import unittest
from collections.abc import Iterable
from pathlib import Path
from unittest import mock

import numpy as np
from made_up_results import (
    boulder_frames, soil_frames, space_frames, write_beams, write_boulder, write_results, write_series,
    write_space_results,
)
from script_case import ScriptCase


def numbers(text: str, kind: str, columns: int) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind).reshape(-1, columns)


def emptied(frames: list[tuple], which: Iterable[int]) -> list[tuple]:
    """Frames of soil, without points in some of them."""
    return [(time, points[:0], cells, {name: values[:0] for name, values in fields.items()}) if k in which else
            (time, points, cells, fields) for k, (time, points, cells, fields) in enumerate(frames)]


class Space(ScriptCase):
    def packed(self, folder: Path) -> dict:
        from plotting.results import Results  # noqa: PLC0415
        from reporting.frames import scene_frames  # noqa: PLC0415
        return scene_frames(Results(folder))

    def boulder_at(self, packed: dict, frame: int) -> np.ndarray:
        points = numbers(packed["points"], "<i2", 3) / 32767 * packed["radius"]
        pose = numbers(packed["poses"], "<f4", 12)[frame]
        return points @ pose[:9].reshape(3, 3).T + pose[9:]

    def test_places_come_back(self) -> None:
        scene = self.packed(write_boulder(write_space_results(self.folder), 3))
        low, high = map(np.array, scene["box"])
        span = (high - low).max()
        soil, wall = space_frames(2)
        for packed, (_, points, _, _) in zip(scene["soil"], soil, strict=True):
            places = low + numbers(packed["points"], "<u2", 3) / 65535 * (high - low)
            back = points[np.lexsort(points.T.round(6))]
            np.testing.assert_allclose(places[np.lexsort(places.T.round(6))][:, 2], back[:, 2], atol=1e-4 * span)
            far = np.abs(places[:, None] - points[None, ::40]).max(axis=2).min(axis=0)
            self.assertLess(far.max(), 1e-4 * span)
        structure, = scene["structures"]
        faces = numbers(structure["faces"], "<u4", 4)
        self.assertEqual(len(faces), 2 * 20 + 2 * (2 + 10))  # both sides and the rim of 2 x 10 cells
        for packed, (_, points, _, _) in zip(structure["frames"], wall, strict=True):
            places = low + numbers(packed, "<u2", 3) / 65535 * (high - low)
            np.testing.assert_allclose(places, points, atol=1e-4 * span)

    def test_the_flat_view_draws_the_faces_in_front(self) -> None:
        structure, = self.packed(write_space_results(self.folder))["structures"]
        front = numbers(structure["front"], "<u4", 1).ravel()
        faces = numbers(structure["faces"], "<u4", 4)
        self.assertEqual(len(front), 20)
        points = space_frames(2)[1][0][1]
        np.testing.assert_allclose(points[faces[front]][..., 1], 0)  # the eye looks along +y

    def test_beams_are_the_surface_around_them(self) -> None:
        packed = self.packed(write_beams(self.folder / "beams"))
        posts, line = packed["structures"]
        self.assertEqual((posts["corners"], line["corners"]), (4, 2))
        self.assertEqual(len(posts["frames"]), len(packed["times"]))

    def test_boulders(self) -> None:
        for dim, write in ((2, write_results), (3, write_space_results)):
            scene = self.packed(write_boulder(write(self.folder / str(dim)), dim))
            boulder, = scene["boulders"]
            faces = numbers(boulder["faces"], "<u2", boulder["corners"])
            self.assertEqual(faces.shape, (1, 4) if dim == 2 else (6, 4))
            if dim == 2:
                self.assertEqual(np.roll(faces[0], -list(faces[0]).index(0)).tolist(), [0, 1, 2, 3])
            for k, (_, points, _, _) in enumerate(boulder_frames(dim)):
                np.testing.assert_allclose(self.boulder_at(boulder, k), points, atol=1e-6)

    def test_what_is_not_rigid_is_no_boulder(self) -> None:
        from plotting.results import ResultsError  # noqa: PLC0415
        from reporting.rigid import pose  # noqa: PLC0415
        points = boulder_frames(3)[0][1]
        reference = points - points.mean(axis=0)
        with self.assertRaisesRegex(ResultsError, "8 nodes in one frame and 7 in another"):
            pose(reference, points[:7])
        with self.assertRaisesRegex(ResultsError, "changes its shape by"):
            pose(reference, 1.1 * points)
        with self.assertRaisesRegex(ResultsError, "changes its shape by"):
            pose(reference, reference * [1, 1, -1])  # a mirror image is no rotation

    def test_rigid_walls(self) -> None:
        wall, = self.packed(write_boulder(write_space_results(self.folder), 3))["space"]["walls"]
        low, high = np.array(wall["low"]), np.array(wall["high"])
        triangles = (low + numbers(wall["corners"], "<u2", 3) / 65535 * (high - low)).reshape(-1, 3, 3)
        self.assertEqual((wall["poses"], wall["until"], len(triangles)), (None, None, 2))
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        np.testing.assert_allclose(normals, [[0, 0, 4]] * 2, atol=1e-3)

    def test_balls_are_as_large_as_their_distance(self) -> None:
        """Also in a gully that fills half its box; points of the slope are far from those of another body."""
        from plotting.results import Results  # noqa: PLC0415
        from reporting.frames import Packer  # noqa: PLC0415
        write_space_results(self.folder)
        packer = Packer(Results(self.folder))
        packer.scene.size = 1.0
        lattice = np.stack(np.meshgrid(*[0.1 * np.arange(20)] * 3), axis=-1).reshape(-1, 3)
        slope = lattice[lattice[:, 0] + lattice[:, 2] < 1.95]
        packer.num_points = len(slope)
        self.assertAlmostEqual(packer._sphere_size(slope), 0.1)
        packer.num_points = len(slope) / 8
        self.assertAlmostEqual(packer._sphere_size(slope), 0.2)

    def test_up_is_against_gravity(self) -> None:
        for up, gravity in ((2, -9.81), (1, -9.81), (2, 9.81)):
            space = self.packed(write_space_results(self.folder / f"{up}{gravity}", up, gravity))["space"]
            expected = np.zeros(3)
            expected[up] = -np.sign(gravity)
            np.testing.assert_allclose(space["up"], expected, atol=1e-12)
            np.testing.assert_allclose(np.cross(space["right"], space["up"]), space["eye"], atol=1e-12)

    def test_frames_without_soil(self) -> None:
        """All of it has left, or none has come yet."""
        from plotting.results import ResultsError  # noqa: PLC0415
        for dim, write, frames in ((2, write_results, soil_frames()), (3, write_space_results, space_frames(2)[0])):
            for empty in ((5,), (0,), (0, 1, 3, 4, 5)):
                with self.subTest(dim=dim, empty=empty):
                    folder = write(self.folder / f"{dim}{len(empty)}{empty[0]}")
                    write_series(folder / "mpm", "soil", emptied(frames, empty))
                    scene = self.packed(folder)
                    shown = [len(numbers(each["points"], "<u2", dim)) for each in scene["soil"]]
                    self.assertEqual(shown, [0 if k in empty else scene["shown"] for k in range(6)])
                    self.assertGreater(scene["shown"], 0)
                    if dim == 3:
                        self.assertGreater(scene["space"]["size"], 0)
            folder = write(self.folder / f"{dim} none")
            write_series(folder / "mpm", "soil", emptied(frames, range(6)))
            scene = self.packed(folder)
            self.assertEqual((scene["soil"], len(scene["structures"])), ([], 1))
            for path in (folder / "fem").glob("structure*"):
                path.unlink()
            with self.assertRaisesRegex(ResultsError, "neither points in"):
                self.packed(folder)

    def test_bytes_are_bounded(self) -> None:
        from reporting import frames  # noqa: PLC0415
        write_boulder(write_space_results(self.folder), 3)
        with mock.patch.object(frames, "MAX_BYTES", 60_000):
            scene = self.packed(self.folder)
        self.assertEqual((scene["points"], scene["shown"]), (6400, 1000))
        self.assertLess(sum(len(frame["points"]) + len(frame["values"][0]) for frame in scene["soil"]),
                        60_000 * 4 / 3)


class Library(ScriptCase):
    def page(self, folder: Path) -> str:
        from plotting.results import Results  # noqa: PLC0415
        from reporting.page import page  # noqa: PLC0415
        return page(Results(folder))

    def test_only_scenes_in_space_have_it(self) -> None:
        from reporting import library  # noqa: PLC0415
        place = self.write("three.min.js", "THREE = '</script> <!-- found';")
        with mock.patch.object(library, "PLACES", (place,)):
            space = self.page(write_space_results(self.folder / "space"))
            flat = self.page(write_results(self.folder / "flat"))
        self.assertIn("THREE = '<\\/script> <\\!-- found';", space)
        self.assertIn("Copyright © 2010-2019 three.js authors", space)
        self.assertNotIn("three.js authors", flat)

    def test_not_installed(self) -> None:
        from reporting import library  # noqa: PLC0415
        with mock.patch.object(library, "PLACES", (self.folder / "none.js",)):
            self.assertIsNone(library.library())
            text = self.page(write_space_results(self.folder / "space"))
        self.assertNotIn("three.js authors", text)
        self.assertIn("libjs-three: install it", text)


if __name__ == "__main__":
    unittest.main()
