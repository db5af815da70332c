#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/terrain: rasters, columns, walls and whole scenes that the programs accept.

    test_terrain.py PROGRAMS      folder of the built programs
"""

import json
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from script_case import ScriptCase

from made_up_results import write_space_results
from running.mpi import find_launcher
from terrain_scene.barrier import build_wall
from terrain_scene.depths import CellDepths, Mass, near_outlines, of_raster
from terrain_scene.outline import Outline
from terrain_scene.raster import Raster, TerrainError, read_raster
from terrain_scene.slope import Columns, Slope, lay_columns, write_ply

PROGRAMS = Path(sys.argv.pop(1)).resolve()
WEST, SOUTH = 500000.0, 5200000.0  # of the rasters [m]


def plane(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 700 - 0.4 * (x - WEST) + 0.1 * (y - SOUTH)


def volume(nodes: np.ndarray, cells: np.ndarray) -> float:
    """Volume of hexahedra whose vertical edges are upright: area in plan times the mean height."""
    corners = nodes[cells]
    wide, high = corners[:, 2] - corners[:, 0], corners[:, 4:, 2] - corners[:, :4, 2]
    return float((wide[:, 0] * wide[:, 1] * high.mean(axis=1)).sum())


class TerrainCase(ScriptCase):
    def raster(self, name: str, values: np.ndarray, head: str | None = None, spacing: float = 2.0) -> Path:
        """values: rows from south to north."""
        rows = "\n".join(" ".join(f"{v:.9g}" for v in row) for row in values[::-1])
        head = head or f"xllcorner {WEST}\nyllcorner {SOUTH}\n"
        return self.write(name, f"NCOLS {values.shape[1]}\nnrows {values.shape[0]}\n{head}cellsize {spacing}\n"
                                f"NODATA_value -9999\n{rows}\n")

    def of_function(self, name: str, function=plane, columns: int = 20, rows: int = 12) -> Path:
        x, y = np.meshgrid(WEST + 1 + 2 * np.arange(columns), SOUTH + 1 + 2 * np.arange(rows))
        return self.raster(name, function(x, y))

    def plan(self, **changes: object) -> Path:
        self.of_function("slope.asc")
        plan = {"slope": "slope.asc", "area": [[WEST + 2, SOUTH + 2], [WEST + 26, SOUTH + 20]], "cell_size": 1,
                "clear_height": 3, "friction": 0.3,
                "slide": {"depth": 1.5, "polygon": [[WEST + x, SOUTH + y] for x, y in
                                                    ((5, 6), (11, 6), (11, 14), (5, 14))]},
                "barrier": {"line": [[WEST + 20, SOUTH + 6], [WEST + 20.5, SOUTH + 14]], "height": 2, "thickness": 0.5},
                "time": {"end": 1, "dt": 0.01}} | changes
        return self.write("plan.json", json.dumps({k: v for k, v in plan.items() if v is not None}))

    def refused(self, *words: str, **changes: object) -> None:
        result = self.python_script("terrain", self.plan(**changes), self.folder / "scene")
        self.assertEqual(result.returncode, 2, result.stdout)
        for word in words:
            self.assertIn(word, result.stderr)

    def check(self, *programs: str) -> str:
        scene = self.folder / "scene"
        launcher = find_launcher()
        options = [str(scene), "--check", "--output", str(self.folder / "out")]
        command = launcher.command([(1, [str(PROGRAMS / program), *options]) for program in programs])
        environment = os.environ | launcher.environment | {"OMP_NUM_THREADS": "1"}
        ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600, env=environment)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        return ended.stdout + ended.stderr

    def make(self, **changes: object) -> str:
        result = self.python_script("terrain", self.plan(**changes), self.folder / "scene")
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout


class Rasters(TerrainCase):
    def test_corner_and_centre_name_the_same_places(self) -> None:
        values = np.arange(12.0).reshape(3, 4)
        corner = read_raster(self.raster("a.asc", values))
        centre = read_raster(self.raster("b.asc", values, f"xllcenter {WEST + 1}\nyllcenter {SOUTH + 1}\n"))
        self.assertEqual(corner.limits(), (WEST + 1, SOUTH + 1, WEST + 7, SOUTH + 5))
        self.assertEqual(corner.limits(), centre.limits())
        self.assertEqual(corner.at(np.array([WEST + 1]), np.array([SOUTH + 1]))[0], 0)  # in the south-west
        self.assertEqual(corner.at(np.array([WEST + 7]), np.array([SOUTH + 5]))[0], 11)

    def test_bilinear_functions_are_met_exactly(self) -> None:
        def twisted(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            return 3 + 0.5 * (x - WEST) - 2 * (y - SOUTH) + 0.25 * (x - WEST) * (y - SOUTH)

        raster = read_raster(self.of_function("a.asc", twisted, 4, 3))
        x = WEST + 1 + np.array([0, 0.3, 2, 3.7, 6])
        for y in SOUTH + 1 + np.array([0.0, 1.9, 4]):
            np.testing.assert_allclose(raster.needed_at(x, np.full(5, y)), twisted(x, y), rtol=1e-8)

    def test_missing_data_is_named_by_row_and_column(self) -> None:
        values = np.ones((3, 4))
        values[0, 2] = -9999
        raster = read_raster(self.raster("a.asc", values))
        raster.needed_at(np.array([WEST + 3.0]), np.array([SOUTH + 2.0]))  # next to it
        with self.assertRaisesRegex(TerrainError, "no data in row 3, column 3"):
            raster.needed_at(np.array([WEST + 3.1]), np.array([SOUTH + 2.0]))
        with self.assertRaisesRegex(TerrainError, "the raster reaches"):
            raster.needed_at(np.array([WEST + 0.9]), np.array([SOUTH + 2.0]))

    def test_numbers_for_no_data_may_differ_in_the_last_digits(self) -> None:
        head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value "
        for number, stored in (("-3.40282e+38", "-3.4028234663852886e+38"), ("-3.4028234663852886e+38", "-3.40282e+38"),
                               ("-9999", "-9999.0"), ("-9999.0", "-9999"), ("0", "0"), ("nan", "nan")):
            raster = read_raster(self.write("a.asc", f"{head}{number}\n1 2\n{stored} 4\n"))
            self.assertEqual(np.isnan(raster.values).tolist(), [[True, False], [False, False]])
        for stored in ("-3.40282e+38", "inf", "1e9"):
            with self.assertRaisesRegex(TerrainError, "in row 2, column 1 .*NODATA_value"):
                read_raster(self.write("a.asc", f"{head}-9999\n1 2\n{stored} 4\n"))

    def test_broken_files(self) -> None:
        for text, words in (("ncols 2\nnrows 2\ncellsize 1\n1 2 3 4", "exactly one of xllcorner"),
                            ("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\n1 2 3 4", "cellsize"),
                            ("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3", "found 3 values"),
                            ("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 x", "line 7"),
                            ("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ndx 1\ndy 2\n1 2\n3 4",
                             "line 5: found \"dx 1\""),
                            ("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1 2\n1 2\n3 4", "line 5: found"),
                            ("ncols 2.5\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4", "a whole number"),
                            ("ncols 1\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2", "at least 2 x 2")):
            with self.assertRaisesRegex(TerrainError, words):
                read_raster(self.write("a.asc", text))

    def test_geotiff_without_gdal(self) -> None:
        path = self.write("a.tif", "")
        with mock.patch.dict(sys.modules, {"osgeo": None}), self.assertRaisesRegex(TerrainError, "python3-gdal"):
            read_raster(path)


def dome(cells: int) -> Columns:
    """Soil with the depth 2 (1 - r^2), r < 1, on an inclined plane, from a raster of 480 x 480 means: volume pi."""
    x = np.linspace(0, 3, cells + 1)
    slope = Slope(3 / cells, 1 + 0.5 * x[None, :] - 0.2 * x[:, None])
    fine = (np.arange(480) + 0.5) * 3 / 480
    values = np.maximum(0, 2 * (1 - (fine[None, :] - 1.5) ** 2 - (fine[:, None] - 1.5) ** 2))
    return lay_columns(slope, Mass(CellDepths(np.zeros(2), 3 / 480, values), [], None))


class Shapes(TerrainCase):
    def test_columns_have_the_volume_that_they_say(self) -> None:
        for cells in (12, 24):
            made = dome(cells)
            self.assertAlmostEqual(volume(made.nodes, made.cells), made.filled, delta=1e-12)
            self.assertLess(abs(made.asked - np.pi), 1e-3)
            high = made.nodes[made.cells][:, 4:, 2] - made.nodes[made.cells][:, :4, 2]
            self.assertLess(high.max(), 3 / cells * (1 + 1e-9))

    def test_thin_rims_left_out_vanish_with_the_cells(self) -> None:
        # A rim as wide as the depth of a quarter of a cell takes: of the order h^2.
        lost = [made.asked - made.filled for made in map(dome, (12, 24, 48))]
        self.assertGreater(min(lost), 0)
        self.assertGreater(np.log2(lost[0] / lost[2]) / 2, 1.7)

    def test_a_polygon_that_cuts_cells_keeps_its_volume(self) -> None:
        slope = Slope(1.0, np.zeros((9, 9)))
        polygon = np.array([(1.5, 2), (5.25, 2), (5.25, 6), (1.5, 6)])
        made = lay_columns(slope, Mass(None, [2.0], [Outline((polygon,))]))
        self.assertAlmostEqual(made.filled, 2 * 3.75 * 4, delta=1e-12)
        self.assertAlmostEqual(made.asked, made.filled, delta=1e-12)
        self.assertAlmostEqual(volume(made.nodes, made.cells), made.filled, delta=1e-12)

    def test_a_raster_keeps_its_volume_on_any_cells(self) -> None:
        """Ragged rims, gaps, cells larger or smaller than those of the grid, shifted against them, a single cell."""
        random = np.random.default_rng(3)
        ragged = random.uniform(1, 3, (7, 5)) * (random.uniform(size=(7, 5)) > 0.3)
        for values in (ragged, np.full((1, 1), 2.0), np.full((2, 2), 2.0), np.pad(np.full((2, 3), 2.0), 1)):
            for spacing in (0.37, 1.0, 5.0):
                corner = np.array([3.21, 2.5])
                size = int(np.ceil((corner + spacing * np.array(values.shape[::-1])).max())) + 2
                mass = Mass(CellDepths(corner, spacing, values), [], None)
                means, covered = mass.means(1.0, (size, size))
                self.assertAlmostEqual(means.sum(), values.sum() * spacing**2, delta=1e-9 * values.sum() * spacing**2)
                self.assertAlmostEqual(mass.asked(), values.sum() * spacing**2, delta=1e-12)
                self.assertTrue((means[covered] > 0).all())

    def test_depth_inside_a_raster_is_bilinear(self) -> None:
        x = np.arange(6) + 0.5
        mass = CellDepths(np.zeros(2), 1.0, 2 + 0.25 * x[None, :] + 0.5 * x[:, None])
        at = np.array([1.0, 2.2, 3.7, 4.99]), np.array([1.5, 3.3, 2.0, 4.4])  # not in the cells of the rim
        np.testing.assert_allclose(mass.at(*at), 2 + 0.25 * at[0] + 0.5 * at[1], rtol=1e-12)
        np.testing.assert_array_equal(mass.at(np.array([-0.1, 6.1, 3.0]), np.array([3.0, 3.0, 6.01])), 0)

    def test_only_what_can_have_mass_is_kept_of_a_raster(self) -> None:
        """A raster of a whole valley: of_raster keeps the rows and columns with mass, near_outlines those of the
        polygon and one beyond, and the depth inside is the same."""
        random = np.random.default_rng(5)
        values = np.pad(random.uniform(1, 3, (4, 6)), ((20, 30), (40, 10)), constant_values=np.nan)
        raster = Raster(Path("a.asc"), 1000.0, 2000.0, 2.0, values)
        kept = of_raster(raster, np.array([990.0, 1990.0, 0.0]))
        self.assertEqual(kept.values.shape, (4, 6))
        np.testing.assert_allclose(kept.corner, [10 + 80 - 1, 10 + 40 - 1])
        self.assertEqual(of_raster(Raster(Path("a.asc"), 0.0, 0.0, 1.0, np.zeros((5, 5))), np.zeros(3)).volume(), 0)
        whole = Raster(Path("b.asc"), 1000.0, 2000.0, 2.0, random.uniform(1, 3, (60, 80)))
        polygon = np.array([[1031.3, 2041.7], [1052.2, 2040.1], [1049.9, 2066.6]])
        part = near_outlines(whole, [Outline((polygon,))])
        self.assertLess(part.values.size, whole.values.size / 10)
        masses = [Mass(of_raster(each, np.zeros(3)), [], [Outline((polygon,))]) for each in (whole, part)]
        x, y = np.meshgrid(np.linspace(1025, 1060, 57), np.linspace(2035, 2070, 43))
        np.testing.assert_allclose(masses[1].at(x, y), masses[0].at(x, y), rtol=1e-12)
        self.assertAlmostEqual(masses[1].asked() / masses[0].asked(), 1, delta=1e-12)
        for far in (np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), polygon + 1e4):
            self.assertEqual(Mass(of_raster(near_outlines(whole, [Outline((far,))]), np.zeros(3)), [],
                                  [Outline((far,))]).asked(), 0)

    def test_masses_beyond_measure_are_refused(self) -> None:
        slope = Slope(1.0, np.zeros((9, 9)))
        with self.assertRaisesRegex(TerrainError, "deepest column 1e[+]09 m at .3.5, 4.5. of the area"):
            values = np.zeros((8, 8))
            values[4, 3] = 1e9
            lay_columns(slope, Mass(CellDepths(np.zeros(2), 1.0, values), [], None))

    def test_facets_look_up_and_lie_on_the_slope(self) -> None:
        random = np.random.default_rng(1)
        slope = Slope(0.5, random.uniform(0, 0.6, (4, 6)))
        self.assertEqual(write_ply(slope, self.folder / "a.ply"), 2 * 3 * 5)
        head, body = (self.folder / "a.ply").read_bytes().split(b"end_header\n")
        nodes = np.frombuffer(body[:24 * 12], "<f4").reshape(24, 3)
        faces = np.frombuffer(body[24 * 12:], [("size", "u1"), ("corners", "<i4", 3)])["corners"]
        normals = np.cross(nodes[faces[:, 1]] - nodes[faces[:, 0]], nodes[faces[:, 2]] - nodes[faces[:, 0]])
        np.testing.assert_allclose(normals[:, 2], 0.25, rtol=1e-6)
        fine = slope.facets(np.zeros((3, 5)))
        pieces = round(slope.spacing / fine.spacing)
        np.testing.assert_allclose(fine.z[::pieces, ::pieces], slope.z, rtol=1e-12)
        self.assertLessEqual(fine.longest_edge(), np.sqrt(0.5) * slope.spacing)
        self.assertGreater(slope.cut(pieces - 1).longest_edge(), np.sqrt(0.5) * slope.spacing)

    def test_wall_on_a_slope(self) -> None:
        slope = Slope(1.0, np.arange(11)[:, None] * 0.3 + np.zeros((1, 11)))
        line = np.array([[2.0, 2.0], [5.0, 2.5], [8.0, 2.0]])
        wall = build_wall(slope, line, 3.0, 0.4)
        below = slope.at(wall.nodes[:, 0], wall.nodes[:, 1]) - wall.nodes[:, 2]
        self.assertAlmostEqual(below.max(), 1.0)
        # on the lower side, which the crest does not follow
        self.assertAlmostEqual(below.min(), -3.0, delta=0.3 * 0.25)
        self.assertAlmostEqual(wall.crest[2], 0.3 * 2.5 + 3)
        odd = build_wall(slope, line[:2], 3.0, 1.2)  # three cells across
        self.assertLess(np.linalg.norm(odd.crest[:2] - line[:2].mean(axis=0)), 0.5)
        across = np.array([-0.5, 3.0]) / np.linalg.norm([-0.5, 3.0])
        self.assertLess(abs((odd.crest[:2] - line[0]) @ across), 1e-12)
        foot, faces = (set(wall.groups[name].ravel()) for name in ("foot", "faces"))
        self.assertLess(np.abs(below[sorted(foot & faces)]).max(), 1e-12)  # they meet at the ground
        # Faces and foot are closed: the volume by the divergence theorem is thickness x length x height.
        self.assertEqual(len(wall.groups["foot"]) + len(wall.groups["faces"]),
                         len({tuple(sorted(facet)) for group in wall.groups.values() for facet in group}))
        with self.assertRaisesRegex(TerrainError, "outside the area"):
            build_wall(slope, line + 5, 3.0, 0.4)


class Scenes(TerrainCase):
    def test_soil_and_barrier(self) -> None:
        said = self.make()
        self.assertIn("72 m^3 in the plan, 72 m^3 (+0.00 %)", said)
        self.assertIn("material: not given, taken", said)
        self.assertIn("barrier/thickness: found 0.5 m, 0.5 cells", said)
        self.assertTrue((self.folder / "scene" / "scene.png").exists())
        soil = json.loads((self.folder / "scene" / "mpm.json").read_text())
        self.assertEqual(soil["origin"][:2], [WEST + 2, SOUTH + 2])
        checked = self.check("coupler", "mpm_solver", "fem_solver")
        self.assertNotIn("warning", checked)
        self.assertIn("basis: gimp", checked)
        gap = float(checked.split("terrain: smallest gap to the soil ")[1].split()[0])
        self.assertLess(abs(gap), 1e-6)  # it rests on the plane

    def test_a_raster_of_depths_beside_gaps_counts_whole_cells(self) -> None:
        inner = np.full((4, 4), 2.0)
        for name, values, corner in (("gaps.asc", np.pad(inner, 2, constant_values=-9999), 3),
                                     ("cropped.asc", inner, 7), ("zeros.asc", np.pad(inner, 2), 3)):
            self.raster(name, values, f"xllcorner {WEST + corner}\nyllcorner {SOUTH + corner}\n")
            self.assertIn("128 m^3 in the plan, 128 m^3 (+0.00 %)", self.make(barrier=None, slide={"depth": name}))
            shutil.rmtree(self.folder / "scene")

    def test_soil_alone_between_two_rasters(self) -> None:
        self.of_function("top.asc", lambda x, y: plane(x, y) + 2 * (abs(x - WEST - 9) < 3) * (abs(y - SOUTH - 10) < 3))
        said = self.make(barrier=None, slide={"top": "top.asc"})
        self.assertIn("48 m^3 in the plan, 48 m^3 (+0.00 %)", said)  # 3 x 2 cells of 2 m, 2 m deep
        self.assertFalse((self.folder / "scene" / "coupler.json").exists())
        self.assertIn("basis: gimp", self.check("mpm_solver"))

    def test_gauges_stand_on_the_slope(self) -> None:
        line = [[WEST + 15, SOUTH + 6], [WEST + 15, SOUTH + 14]]  # northwards: flow to the east counts positive
        self.make(gauges=[{"name": "throat", "line": line, "height": 3}])
        soil = json.loads((self.folder / "scene" / "mpm.json").read_text())
        gauge, = soil["gauges"]
        self.assertEqual(gauge["name"], "throat")
        low, high = (plane(x, SOUTH + y) - soil["origin"][2] for x, y in ((WEST + 16, 6), (WEST + 15, 14)))
        np.testing.assert_allclose(gauge["corners"], [[13, 4, low], [13, 12, low], [13, 4, high + 3]], atol=1e-6)
        self.assertNotIn("warning", self.check("coupler", "mpm_solver", "fem_solver"))

    def test_gauges_that_cannot_be(self) -> None:
        line = [[WEST + 15, SOUTH + 6], [WEST + 15, SOUTH + 14]]
        for words, change in (("/gauges/0/name: found nothing", {"line": line, "height": 3}),
                              ("/gauges/0/line: found 3 rows", {"name": "a", "line": [*line, line[0]], "height": 3}),
                              ("gauge a: line: found no length", {"name": "a", "line": line[:1] * 2, "height": 3}),
                              ("/gauges/0/line: found (500000, 5200000) outside",
                               {"name": "a", "line": [line[0], [WEST, SOUTH]],
                                                                       "height": 3}),
                              ("/gauges/0/height: found 0", {"name": "a", "line": line, "height": 0})):
            self.refused(words, gauges=[change])
        self.refused("/gauges: found 3, allowed: a list of objects", gauges=3)

    def test_plans_that_cannot_be(self) -> None:
        self.refused("plan.json/slide/depht: unknown", "did you mean depth?",
                     slide={"depth": 1, "depht": 2, "polygon": [[WEST, SOUTH]] * 3})
        self.refused("plan.json/cellsize: unknown", "did you mean cell_size?", cellsize=1)
        self.refused("plan.json/time/End: unknown", "did you mean end?", time={"End": 1, "dt": 0.1})
        self.refused("exactly one of depth", slide={"polygon": [[0, 0], [1, 0], [0, 1]]})
        self.refused("found no mass", slide={"depth": 1, "polygon": [[0, 0], [1, 0], [0, 1]]})
        flat = [[WEST + x, SOUTH + y] for x, y in ((8, 8), (16, 8), (16, 16), (8, 16))]
        self.refused("found no mass", "it is 0.1 m deep at most, allowed: a cell_size up to 0.4 m",
                     slide={"depth": 0.1, "polygon": flat})
        self.refused("/cell_size: found 0", cell_size=0)
        self.refused("two corners", area=[[1, 1], [0, 2]])
        self.refused("the raster reaches", barrier=None, area=[[WEST, SOUTH], [WEST + 10, SOUTH + 10]])
        self.refused("mass at the rim", slide={"depth": 1, "polygon": [[WEST + x, SOUTH + y] for x, y in
                                                                       ((2, 6), (9, 6), (9, 12), (2, 12))]})

    def test_plans_beyond_measure_end_soon(self) -> None:
        self.refused("/slope: found nothing", slope=None)
        self.refused("/slide/depth: ", "no such raster", slide={"depth": "none.asc"})
        polygon = [[WEST + 5, SOUTH + 6], [WEST + 11, SOUTH + 6], [WEST + 11, SOUTH + 14]]
        for words, material in (("/slide/material: found 'sand', allowed: an object", "sand"),
                                ("/slide/material/density: found -1800", {"density": -1800})):
            self.refused(words, slide={"depth": 1, "polygon": polygon, "material": material})
        self.refused("cell_size: found 0.001 m", "24000 x 18000 cells", cell_size=1e-3)
        self.refused("/cell_size: found inf", cell_size=float("inf"))
        line = [[SOUTH + 6, WEST + 20], [SOUTH + 14, WEST + 20]]  # axes in the wrong order: very long to the grid
        self.refused("barrier/line: found (", "outside the area, allowed: from (500002, 5200002) to (500026, 5200020)",
                     barrier={"line": line, "height": 2, "thickness": 0.5})
        self.refused("found (9.51, 46.88) outside", "look like degrees",
                     barrier={"line": [[9.51, 46.88], [9.52, 46.88]], "height": 2, "thickness": 0.5})
        line = [[WEST + 20, SOUTH + 6], [WEST + 20, SOUTH + 14]]
        self.refused("barrier: found height 2 m and thickness 0.0001 m", "cells, allowed: 500000",
                     barrier={"line": line, "height": 2, "thickness": 1e-4})
        for depth in (1e9, float("inf")):  # in one place
            heap = np.ones((12, 20))
            heap[4, 4] = depth
            self.raster("depth.asc", heap)
            self.refused("depth.asc: found", "allowed: metres", slide={"depth": "depth.asc", "polygon": polygon})
        self.refused("the deepest column 1e+07 m", "allowed: 10000000 cells", slide={"depth": 1e7, "polygon": polygon})
        self.raster("depth.asc", np.ones((4, 4)), "xllcorner 0\nyllcorner 0\n")
        self.refused("found no mass", "depth.asc: the raster reaches from (1, 1) to (7, 7)",
                     slide={"depth": "depth.asc"})
        result = self.python_script("terrain", self.plan(), self.folder / "plan.json" / "scene")
        self.assertEqual(result.returncode, 2)
        self.assertIn("plan.json", result.stderr)

    def test_a_scene_is_not_written_over_unasked(self) -> None:
        self.make(barrier=None)
        settings = self.folder / "scene" / "mpm.json"
        settings.write_text("{}")
        self.refused("has a scene already", "--replace")
        self.assertEqual(settings.read_text(), "{}")
        for barrier, files in (({}, 4), ({"barrier": None}, 2)):
            result = self.python_script("terrain", self.plan(**barrier), self.folder / "scene", "--replace")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertNotEqual(settings.read_text(), "{}")
            self.assertEqual(len(list(settings.parent.glob("*.json"))), files)

    def test_points_of_results_in_coordinates_of_the_world(self) -> None:
        results = write_space_results(self.folder / "results")
        settings = results / "mpm" / "resolved_config.json"
        values = json.loads(settings.read_text())
        values["mpm.json"]["origin"] = [WEST, SOUTH, 700]
        settings.write_text(json.dumps(values))
        ended = self.python_script("terrain", "--world", results, self.folder / "world.csv", "--time", 0)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        table = np.genfromtxt(self.folder / "world.csv", delimiter=",", names=True)
        self.assertTrue((np.abs(table["x"] - WEST) < 10).all() and (np.abs(table["z"] - 700) < 10).all())
        # A run of the soil alone keeps its settings beside the frames' folder.
        settings.rename(results / "resolved_config.json")
        again = self.python_script("terrain", "--world", results, self.folder / "again.csv", "--time", 0)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.folder / "again.csv").read_text(), (self.folder / "world.csv").read_text())
        late = self.python_script("terrain", "--world", results, self.folder / "late.csv", "--time", 99)
        self.assertEqual(late.returncode, 2)
        self.assertIn("--time: found 99, allowed: 0 to", late.stderr)


if __name__ == "__main__":
    unittest.main()
