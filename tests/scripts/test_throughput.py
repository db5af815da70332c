# SPDX-License-Identifier: BSD-3-Clause
"""The soil of scripts/bench throughput on its bed of facets."""

import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from studies import throughput  # noqa: E402
from studies.instructions import scene  # noqa: E402


class Bed(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bed = Path(folder.name) / "made" / "bed.ply"

    def test_the_body_lies_on_it_and_keeps_its_size_and_cells(self) -> None:
        for name, form in throughput.ALL_FORMS.items():
            with self.subTest(name):
                free, settings = scene(*form), throughput.on_facets(scene(*form), self.bed)
                box, before = (of["bodies"][0]["mesh"]["box"] for of in (settings, free))
                grid = settings["grid"]["box"]
                cell = grid["high"][0] / grid["cells"][0]
                self.assertAlmostEqual(box["low"][-1], throughput.BED * cell)
                self.assertAlmostEqual(box["high"][-1] - box["low"][-1], before["high"][-1])
                self.assertEqual((box["low"][0], box["cells"]), (0, before["cells"]))
                self.assertLess(box["high"][-1], grid["high"][-1])
                self.assertAlmostEqual(grid["high"][-1] / grid["cells"][-1], cell)
                self.assertNotIn("bottom", [wall["group"] for wall in settings["walls"]])

    def test_its_triangles_cover_the_floor_once_and_look_up(self) -> None:
        throughput.on_facets(scene("gimp", "fbar", "hex8"), self.bed)
        lines = self.bed.read_text(encoding="utf-8").splitlines()
        start = lines.index("end_header") + 1
        rows = [[float(word) for word in line.split()] for line in lines[start:]]
        places = np.array([row for row in rows if len(row) == 3])
        corners = places[np.array([row[1:] for row in rows if len(row) == 4], dtype=int)]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
        self.assertTrue((areas > 0).all())
        self.assertAlmostEqual(areas.sum(), 0.2 * 0.1)
        self.assertTrue((places[:, 2] == 0.02).all())
        self.assertIn(f"element vertex {len(places)}", lines)
        self.assertIn(f"element face {len(corners)}", lines)


if __name__ == "__main__":
    unittest.main()
