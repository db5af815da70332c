#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A foreign structure whose facets leave the interface: soil falls through the gap."""

import json
from pathlib import Path

import h5py
import launch
import numpy as np
import restart_rows
from launch import IntegrationCase, Launch, free_endpoint, meeting, read_table

FLOOR = ["/usr/bin/python3", str(Path(__file__).resolve().parent / "foreign_floor.py")]
TOP, SPEED, MASS = 0.4, 6.0, 20.0  # [m, m/s, kg] of a block that falls on the middle of the floor
BEARS = 8.0  # [N s/m] of a vertex; the block has 120


def scene() -> dict[str, dict]:
    """Nothing has weight."""
    files = meeting()
    del files["fem"]
    files["mpm"] = {
        "dimension": 2, "gravity": [0, 0],
        "grid": {"box": {"low": [0, -0.4], "high": [1, 0.6], "cells": [20, 20], "type": "quad4"}},
        "bodies": [{"name": "soil",
                    "mesh": {"box": {"low": [0.45, TOP + 0.01], "high": [0.55, TOP + 0.11], "cells": [4, 4],
                                     "type": "quad4"}},
                    "points_per_cell": 4, "velocity": [0, -SPEED],
                    "material": {"law": "neo_hookean", "density": 2000, "young_modulus": 1e6, "poisson_ratio": 0.2}}],
        "interfaces": [{"name": "wall", "surface": {
            "mesh": {"box": {"low": [0, TOP - 0.05], "high": [1, TOP], "cells": [20, 1], "type": "quad4"}},
            "groups": ["top"], "behind": ["all"]}}]}
    files["coupler"]["time"] |= {"end": 0.06, "dt": 5e-4}
    files["coupler"]["output"]["interval"] = 0.01
    files["coupler"]["coupling"]["predictor"] = 1
    return files


class BreakingFloor(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = scene()

    def start_floor(self, bears: float) -> Launch:
        started = Launch([*FLOOR, str(bears), "--coupler", self.endpoint], self.folder)
        self.addCleanup(started.end)
        return started

    def listen(self) -> None:
        """Write the scene with an endpoint that is free."""
        self.endpoint = free_endpoint()
        self.files["coupler"]["protocol"] = {"endpoint": self.endpoint}
        self.write_scene(self.files)

    def run_scene(self, *options: str, bears: float = BEARS, code: int = 0) -> str:
        """The text of coupler and soil, beside which the floor runs."""
        self.listen()
        run = self.start(*options, programs=("coupler", "mpm_solver"))
        floor = self.start_floor(bears)
        ended = run.wait()
        self.assertEqual(ended.code, code, ended.text + floor.text())
        if code == 0:
            self.assertEqual(floor.wait().code, 0, floor.text())
        return ended.text

    def height(self) -> float:
        """Of the middle of the block in the last frame [m]."""
        with h5py.File(sorted((self.out / "mpm").glob("soil_*.h5"))[-1]) as data:
            return float(np.mean(data["coordinates"][()][:, 1]))

    def test_the_block_falls_through(self) -> None:
        self.run_scene()
        probes = read_table(self.out / "probes.csv")
        facets = [int(float(row["structure.facets"])) for row in probes]
        self.assertEqual(facets[0], 20)
        self.assertLess(facets[-1], 19)
        self.assertLess(self.height(), TOP - 0.05)
        told = json.loads((self.out / "summary.json").read_text())["messages"]["soil"]["set_facets"]["count"]
        self.assertEqual(told, sum(new != old for old, new in zip(facets, facets[1:])))
        for axis in "xy":
            error = max(abs(float(row[f"soil.momentum_error_{axis}"])) for row in probes)
            self.assertLess(error, 1e-6 * MASS * SPEED)

    def test_a_floor_that_bears_more_throws_it_back(self) -> None:
        self.run_scene("--set", "coupler.json:/time/end=0.03", bears=1e6)
        self.assertGreater(self.height(), TOP)

    def test_a_restart_gives_the_same_rows(self) -> None:
        """From the step in which the first facets left."""
        straight, first, second = (self.folder / name for name in ("straight", "first", "second"))
        self.out = straight
        self.run_scene("--set", "coupler.json:/time/end=0.02")
        facets = [int(float(row["structure.facets"])) for row in read_table(straight / "probes.csv")]
        steps = next(k for k, count in enumerate(facets) if count < 20)
        self.out = first
        self.run_scene("--set", f"coupler.json:/time/end={5e-4 * steps}")
        self.out = second
        self.run_scene("--restart", str(first), "--set", "coupler.json:/time/end=0.02")
        for table in ("steps.csv", "probes.csv"):
            old, new = (restart_rows.rows_without_seconds(out / table) for out in (straight, second))
            self.assertEqual(len(new) - 1, 40 - steps)
            self.assertEqual(new[1:], old[1 - len(new):])

    def test_it_passes_the_check(self) -> None:
        """Forces so large that facets leave while it is checked."""
        self.listen()
        coupler = Launch([str(launch.binaries / "coupler"), str(self.scene), "--output", str(self.out),
                          "--check-participant", "structure", "--amplitude", "4e3"], self.folder)
        self.addCleanup(coupler.end)
        floor = self.start_floor(BEARS)
        text = coupler.wait().text
        self.assertEqual(floor.wait().code, 0, floor.text())
        self.assertNotIn("FAILED", text)
        self.assert_says(text, "the same facets after save, steps, load and the same steps", "passed")

    def test_a_soil_that_takes_none_is_refused(self) -> None:
        wall = self.files["mpm"]["interfaces"][0]
        wall |= {"method": "boundary_points", "penalty": 1e7}
        del wall["surface"]["behind"]
        text = self.run_scene(code=2)
        self.assert_says(text, 'interface "wall"', '"soil" cannot take other facets')


if __name__ == "__main__":
    launch.main()
