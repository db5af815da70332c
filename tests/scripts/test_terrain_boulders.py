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

    def soil_around(self, origin: np.ndarray, place: np.ndarray, reach: float) -> np.ndarray:
        """Places of the surface of the meshed soil near a place, n x 3 [m]: bilinear between its highest nodes."""
        lines = (self.folder / "scene" / "slide.msh").read_text().split("$Nodes")[1].split("$EndNodes")[0].splitlines()
        nodes = np.array([line.split() for line in lines if len(line.split()) == 3], dtype=float) + origin
        highest: dict[tuple[float, float], float] = {}
        for x, y, z in nodes:
            key = (round(x), round(y))
            highest[key] = max(highest.get(key, z), z)
        steps = np.linspace(-reach, reach, 161)
        surface = []
        for x, y in np.stack(np.meshgrid(place[0] + steps, place[1] + steps), axis=-1).reshape(-1, 2):
            i, j = int(np.floor(x)), int(np.floor(y))
            u, v = x - i, y - j
            corners = [highest.get((i + di, j + dj)) for dj in (0, 1) for di in (0, 1)]
            if None not in corners:
                surface.append((x, y, np.dot(corners, [(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v])))
        return np.array(surface)

    def test_boulders_lie_on_a_ridge_of_soil_and_beside_it(self) -> None:
        crest, radius = SOUTH + 11, 1.6
        self.of_function("ridge.asc", lambda _, y: 5 - 1.2 * np.abs(y - crest))
        inside = [[WEST + x, SOUTH + y] for x, y in ((4, 8), (16, 8), (16, 14), (4, 14))]
        stone = {"shape": {"radius": radius}, "density": 2650}
        self.make(barrier=None, slide={"depth": "ridge.asc", "polygon": inside}, clear_height=12,
                  boulders=[stone | {"name": "on", "place": [WEST + 7, crest]},
                            stone | {"name": "beside", "place": [WEST + 12, crest + 1.3]}])
        settings = json.loads((self.folder / "scene" / "mpm.json").read_text())
        for found in settings["boulders"]:
            place = np.array(found["centre"]) + settings["origin"]
            soil = self.soil_around(np.array(settings["origin"]), place, radius)
            apart = np.linalg.norm(soil - place, axis=1).min()
            self.assertGreater(apart, radius, found["name"])
            self.assertLess(apart, 1.02 * radius, found["name"])
        self.assertIn("on: ", self.check("mpm_solver"))

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
