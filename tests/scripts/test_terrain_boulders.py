#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/terrain: boulders of a plan."""

import json
import unittest

import numpy as np
from test_terrain import SOUTH, WEST, TerrainCase, plane


class BouldersOfPlan(TerrainCase):
    def test_boulders_lie_on_the_ground(self) -> None:
        stone = {"name": "stone", "shape": {"radius": 1.6}, "density": 2650, "place": [WEST + 15, SOUTH + 12]}
        slab = stone | {"name": "slab", "shape": {"box": [3.2, 3.2, 3.2]}, "place": [WEST + 8, SOUTH + 10]}
        self.make(boulders=[stone, slab])
        settings = json.loads((self.folder / "scene" / "mpm.json").read_text())
        for found, radius, soil in zip(settings["boulders"], (1.6, 1.6 * np.sqrt(3)), (0, 1.5), strict=True):
            place = np.array(found["centre"]) + settings["origin"]
            self.assertNotIn("place", found)
            apart = (place[2] - plane(*place[:2]) - soil) / np.sqrt(1 + 0.4**2 + 0.1**2)
            self.assertGreater(apart, radius)
            self.assertLess(apart, 1.011 * radius)
        self.assertIn("stone: ", self.check("coupler", "mpm_solver", "fem_solver"))

    def test_boulders_that_cannot_be(self) -> None:
        stone = {"name": "stone", "shape": {"radius": 1.6}, "density": 2650, "place": [WEST + 15, SOUTH + 12]}
        for words, change in (("/boulders/0/place: found [1], allowed: [x, y]", {"place": [1]}),
                              ("/boulders/0/place: found (500000, 5200000) outside", {"place": [WEST, SOUTH]}),
                              ("/boulders/0/centre: found [1, 2, 3], allowed: place", {"centre": [1, 2, 3]}),
                              ("/boulders/0/shape/ball: unknown", {"shape": {"ball": 2}}),
                              ("/boulders/0/shape: found 2 keys", {"shape": {"radius": 2, "box": [1, 1, 1]}}),
                              ("/boulders/0/shape/box: found [1, 1], allowed: three", {"shape": {"box": [1, 1]}}),
                              ("/boulders/0/density: found 0", {"density": 0})):
            self.refused(words, boulders=[stone | change])


if __name__ == "__main__":
    unittest.main()
