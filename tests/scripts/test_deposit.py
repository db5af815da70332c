#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/deposit: depth over the plan from the material points of frames."""

import json
import unittest
from pathlib import Path

import numpy as np
from script_case import ScriptCase

import made_up_results as made_up
from plotting import deposit
from plotting.results import Results, ResultsError


def frame(time: float, low: list[float], size: list[float], speed: float, spacing: float = 0.05) -> tuple:
    """A box of points, each with the volume of its share, that moves along x."""
    ticks = [np.arange(start + spacing / 2, start + length, spacing) for start, length in zip(low, size)]
    points = np.column_stack([axis.ravel() for axis in np.meshgrid(*ticks)])
    velocity = np.zeros_like(points)
    velocity[:, 0] = speed
    volume = np.full(len(points), spacing ** len(size))
    return time, points, None, {"velocity": velocity, "volume": volume, "volume_ratio": np.ones(len(points))}


class Deposits(ScriptCase):
    def run_of(self, *frames: tuple) -> Results:
        """Frames have three coordinates in the plane too, as those of the programs."""
        dim = frames[0][1].shape[1]
        padded = [(time, np.pad(points, ((0, 0), (0, 3 - dim))), cells, fields) for time, points, cells,
                  fields in frames]
        made_up.write_series(self.folder / "mpm", "soil", padded)
        made_up.write_table(self.folder / "probes.csv", ["time", f"soil.A.u{'xyz'[dim - 1]}"], [[0, 0]])
        return Results(self.folder)

    def test_a_box_has_its_depth(self) -> None:
        run = self.run_of(frame(0, [0.2, 0.4, 1.0], [0.6, 0.4, 0.3], 1.0))
        found = deposit.find_deposit(run, cell=0.2)
        self.assertEqual(found.plan.shape, (3, 2))
        np.testing.assert_allclose(found.plan.low, [0.2, 0.4])
        np.testing.assert_allclose(found.depth, 0.3, rtol=1e-12)
        np.testing.assert_allclose(found.max_speed, 1)

    def test_volume_is_kept_whatever_the_cells(self) -> None:
        rng = np.random.default_rng(1)
        points = rng.uniform([-3, 5, 0], [1, 7, 2], (500, 3))
        volume = rng.uniform(1e-6, 1e-1, 500)  # from far smaller to larger than the cells
        run = self.run_of((0.0, points, None, {"velocity": points, "volume": volume, "volume_ratio": np.ones(500)}))
        for cell in (0.03, 0.2, 1.0, 30.0, None):
            found = deposit.find_deposit(run, cell=cell)
            self.assertAlmostEqual(np.sum(found.depth) * found.plan.area, np.sum(volume), delta=1e-12 * np.sum(volume))
            np.testing.assert_allclose(found.plan.low / found.plan.cell % 1, 0, atol=1e-9)

    def test_depth_is_that_of_the_mass_at_rest(self) -> None:
        """Soil that opens by a quarter has the depth that was released, whatever the cells; the rest is `opened`."""
        time, points, cells, fields = frame(0, [0.2, 0.4, 1.0], [0.6, 0.4, 0.3], 1.0)
        run = self.run_of((time, points, cells, fields | {"volume": 1.25 * fields["volume"],
                                                          "volume_ratio": 1.25 * fields["volume_ratio"]}))
        for cell in (0.07, 0.2, 1.0, None):
            found = deposit.find_deposit(run, cell=cell)
            self.assertAlmostEqual(np.sum(found.depth) * found.plan.area, 0.072, delta=1e-12)
            self.assertAlmostEqual(np.sum(found.opened) * found.plan.area, 0.018, delta=1e-12)
        np.testing.assert_allclose(deposit.find_deposit(run, cell=0.2).depth, 0.3, rtol=1e-12)

    def test_frames_without_soil_are_empty(self) -> None:
        none = (1.0, np.empty((0, 3)), None, {"velocity": np.empty((0, 3)), "volume": np.empty(0),
                                               "volume_ratio": np.empty(0)})
        found = deposit.find_deposit(self.run_of(frame(0, [0, 0, 0], [0.4, 0.2, 0.4], 1.0), none), cell=0.2)
        self.assertEqual((np.max(found.depth), np.max(found.max_speed)), (0, 1))
        np.testing.assert_allclose(found.max_depth, 0.4)

    def test_options_that_cannot_be(self) -> None:
        self.run_of(frame(0, [0, 0, 0], [0.4, 0.2, 0.4], 1.0), frame(1, [0, 0, 0], [0.4, 0.2, 0.4], 1.0))
        for options in (("--cell", "inf"), ("--cell", "nan"), ("--cell", "0"), ("--origin", "inf", "0")):
            with self.assertRaises(SystemExit) as ended:
                self.python_script("deposit", self.folder, *options)
            self.assertEqual(ended.exception.code, 2)
        for time in ("99", "-1", "nan"):
            result = self.python_script("deposit", self.folder, "--time", time)
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"--time: found {time}, allowed: 0 to 1 s", result.stderr)

    def test_a_point_across_an_edge_is_shared(self) -> None:
        point = np.array([[0.99, 0.5, 0.0]])
        run = self.run_of((0.0, point, None, {"velocity": 0 * point, "volume": np.array([0.1**3]),
                                             "volume_ratio": np.ones(1)}))
        found = deposit.find_deposit(run, cell=1.0)
        np.testing.assert_allclose(found.depth, [[0.6e-3], [0.4e-3]], rtol=1e-12)

    def test_the_largest_are_those_of_all_frames_so_far(self) -> None:
        run = self.run_of(frame(0, [0, 0, 0], [0.2, 0.2, 0.4], 0.0), frame(1, [0.2, 0, 0], [0.4, 0.2, 0.2], 3.0),
                          frame(2, [0.6, 0, 0], [0.2, 0.2, 0.4], 0.5))
        first, end = deposit.find_deposit(run, 1.2, 0.2), deposit.find_deposit(run, None, 0.2)
        self.assertEqual((first.time, end.time), (1, 2))
        np.testing.assert_allclose(first.depth[:, 0], [0, 0.2, 0.2])
        np.testing.assert_allclose(end.depth[:, 0], [0, 0, 0, 0.4], atol=1e-15)
        np.testing.assert_allclose(end.max_depth[:, 0], [0.4, 0.2, 0.2, 0.4])
        np.testing.assert_allclose(end.max_speed[:, 0], [0, 3, 3, 0.5])

    def test_rasters(self) -> None:
        self.run_of(frame(0, [0, 0, 0], [0.4, 0.2, 0.4], 1.0), frame(1, [0, 0, 0], [0.2, 0.6, 0.2], 2.0))
        result = self.python_script("deposit", self.folder, "--cell", "0.2", "--origin", "1000", "2000")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        names = [Path(line).name for line in result.stdout.splitlines()[:-1]]
        self.assertEqual(names, ["depth.asc", "opened.asc", "max_depth.asc", "max_speed.asc", "deposit.png"])
        self.assertIn("1 s: 0.024 m³ of soil at rest, +0 by opening, depth up to 0.2 m, up to 0.4 m so far, speed up "
                      "to 2 m/s", result.stdout)
        lines = (self.folder / "deposit" / "max_depth.asc").read_text(encoding="utf-8").splitlines()
        head = dict(line.split() for line in lines[:6])
        self.assertEqual((head["ncols"], head["nrows"], float(head["cellsize"])), ("2", "3", 0.2))
        self.assertEqual((float(head["xllcorner"]), float(head["yllcorner"])), (1000, 2000))
        rows = [[float(word) for word in line.split()] for line in lines[6:]]  # from north to south
        np.testing.assert_allclose(rows, [[0.2, 0], [0.2, 0], [0.4, 0.4]], atol=1e-15)

    def test_rasters_of_a_scene_with_an_origin_lie_on_the_map(self) -> None:
        self.run_of(frame(0, [0, 0, 0], [0.4, 0.2, 0.4], 1.0))
        settings = {"mpm.json": {"gravity": [0, 0, -9.81], "origin": [500000.5, 5200000, 700]}}
        self.write("mpm/resolved_config.json", json.dumps(settings))
        for options, corner in (((), (500000.5, 5200000)), (("--origin", "1", "2"), (1, 2))):
            result = self.python_script("deposit", self.folder, "--cell", "0.2", *options)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            lines = (self.folder / "deposit" / "depth.asc").read_text(encoding="utf-8").splitlines()
            head = dict(line.split() for line in lines[:6])
            self.assertEqual((float(head["xllcorner"]), float(head["yllcorner"])), corner)

    def test_profile_in_the_plane(self) -> None:
        run = self.run_of(frame(0, [0, 0], [0.4, 0.2], 1.0))
        self.assertAlmostEqual(deposit.find_deposit(run).plan.cell, 0.1)  # two points
        result = self.python_script("deposit", self.folder, "--cell", "0.2")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        table = np.genfromtxt(self.folder / "deposit" / "deposit.csv", delimiter=",", names=True)
        np.testing.assert_allclose(table["x"], [0.1, 0.3])
        for name, value in (("depth", 0.2), ("opened", 0), ("max_depth", 0.2), ("max_speed", 1)):
            np.testing.assert_allclose(table[name], value)
        self.assertGreater((self.folder / "deposit" / "deposit.png").stat().st_size, 5000)

    def test_what_cannot_be_drawn_is_named(self) -> None:
        made_up.write_results(self.folder / "old")
        result = self.python_script("deposit", self.folder / "old")
        self.assertEqual(result.returncode, 2)
        self.assertIn("its points have no volume", result.stderr)
        with self.assertRaisesRegex(ResultsError, "cells of 1e-05 m make"):
            deposit.find_deposit(self.run_of(frame(0, [0, 0, 0], [0.4, 0.2, 0.1], 1)), cell=1e-5)


if __name__ == "__main__":
    unittest.main()
