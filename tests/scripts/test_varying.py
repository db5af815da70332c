#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/plot SCENE --varying draws the constants that vary in space before a scene runs."""

import json
import sys
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from script_case import ScriptCase

from plotting import varying
from plotting.results import ResultsError
from reporting.settings import overview

PROGRAMS = Path(sys.argv.pop(1)).resolve()


def box(high: list[float], cells: list[int]) -> dict:
    kind = "quad4" if len(high) == 2 else "hex8"
    return {"box": {"low": [0] * len(high), "high": high, "cells": cells, "type": kind}}


def scene(dim: int, cohesion: object) -> dict:
    """Clay with a stiff body beside it."""
    material = {"law": "tresca", "density": 2000, "young_modulus": 1e7, "poisson_ratio": 0.3}
    shape = box([4, 1, 2][:dim] if dim == 3 else [4, 2], [8, 2, 4] if dim == 3 else [8, 4])
    return {"dimension": dim, "grid": shape,
            "bodies": [{"name": "soil", "mesh": shape, "points_per_cell": 2**dim,
                        "material": {**material, "cohesion": cohesion}}],
            "time": {"dt": 1, "dt_min": 0.1, "end": 1}, "output": {"interval": 1}}


BY_DEPTH = {"by_depth": [[0, 1e4], [2, 3e4]], "below": 2}


class Varying(ScriptCase):
    def scene(self, settings: dict) -> Path:
        return self.write("scene/mpm.json", json.dumps(settings)).parent

    def test_table_has_the_values(self) -> None:
        for dim in (2, 3):
            table = varying.read_varying(self.scene(scene(dim, BY_DEPTH)), [], PROGRAMS)
            self.assertEqual(varying.names_of(table), ["cohesion"])
            self.assertEqual(table.num_rows, {2: 128, 3: 512}[dim])
            height = table["z" if dim == 3 else "y"]
            np.testing.assert_allclose(table["cohesion"], 1e4 * (3 - height), rtol=1e-12)

    def test_one_value_can_be_replaced(self) -> None:
        words = ["mpm.json:/bodies/0/material/cohesion/by_depth=[[0,5e3],[2,5e3]]"]
        table = varying.read_varying(self.scene(scene(2, BY_DEPTH)), words, PROGRAMS)
        self.assertEqual(set(table["cohesion"]), {5e3})

    def test_a_seed_is_a_sample(self) -> None:
        field = {"random": {"mean": 1e4, "cov": 0.3, "correlation_lengths": [1, 1], "seed": 1}}
        folder = self.scene(scene(2, field))
        first, again = (varying.read_varying(folder, [], PROGRAMS)["cohesion"] for _ in range(2))
        other = varying.read_varying(folder, ["mpm.json:/bodies/0/material/cohesion/random/seed=2"], PROGRAMS)
        np.testing.assert_array_equal(first, again)
        self.assertFalse(np.any(first == other["cohesion"]))

    def test_scene_without_is_refused(self) -> None:
        with self.assertRaisesRegex(ResultsError, "found no material with constants that vary"):
            varying.read_varying(self.scene(scene(2, 1e4)), [], PROGRAMS)

    def test_pictures(self) -> None:
        for dim in (2, 3):
            with mock.patch.object(varying.read_varying, "__defaults__", (PROGRAMS,)):
                done = self.python_script("plot", self.scene(scene(dim, BY_DEPTH)), "--varying", "--out", self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout.strip(), str(self.folder / "varying.png"))
            self.assertGreater((self.folder / "varying.png").stat().st_size, 5000)
            (self.folder / "varying.png").unlink()

    def test_report_names_what_varies(self) -> None:
        settings = scene(2, {**BY_DEPTH, "random": {"cov": 0.2}})
        settings["bodies"][0]["material"]["layers"] = [{"below": 1}]
        (text,) = (text for label, text in overview({"mpm.json": settings}) if label.startswith("soil"))
        self.assertIn("cohesion varies by depth and at random, and layers below", text)
        self.assertIn("young modulus 1e+07", text)

    def test_slice_through_the_middle(self) -> None:
        grid = np.stack(np.meshgrid([0, 1, 2, 3], [0, 1, 2], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
        shown = varying.slice_of(grid.astype(float), 0.8)
        self.assertEqual(set(grid[shown][:, 1]), {1})
        self.assertEqual(shown.sum(), 8)


if __name__ == "__main__":
    unittest.main()
