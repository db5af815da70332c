#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/section: lines, columns, walls and whole scenes that the programs accept.

    test_section.py PROGRAMS      folder of the built programs
"""

import json
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np
from script_case import ROOT, ScriptCase

from section_scene.columns import column_sides
from section_scene.plan import read_plan
from section_scene.scene import Made, make, write_scene
from terrain_scene.raster import TerrainError

PROGRAMS = Path(sys.argv.pop(1)).resolve()
SAND = {"law": "mohr_coulomb", "density": 1800, "young_modulus": 2e7, "poisson_ratio": 0.3, "friction_angle": 33}
WALL = {"at": 20.3, "height": 2, "thickness": 0.6, "depth": 1.1,
        "footing": {"width": 2.7, "thickness": 0.4, "before": 1}}
# Two layers of which the lower one comes to the ground; the upper one ends in tips.
GROUND = [[0, 7], [11.3, 1.7], [16.1, 0], [31.7, 0.4]]
UPPER = [[0, 6.2], [8, 4], [16, -1.4], [31.7, -1.1]]
BASE = [[0, 4], [16.2, -3.1], [31.7, -3.1]]


def area(corners: list | np.ndarray) -> float:
    """Area of a polygon that runs against the clock."""
    x, z = np.asarray(corners, dtype=float).T
    return float((x * np.roll(z, -1) - np.roll(x, -1) * z).sum() / 2)


def between(top: list, bottom: list, left: float = -np.inf, right: float = np.inf) -> float:
    """Area between two lines where the first one is above, by their zeros; not by the columns of the scene."""
    top, bottom = np.array(top, dtype=float), np.array(bottom, dtype=float)
    low, high = max(top[0, 0], bottom[0, 0], left), min(top[-1, 0], bottom[-1, 0], right)
    x = np.unique(np.concatenate([[low, high], top[:, 0], bottom[:, 0]]))
    x = x[(x >= low) & (x <= high)]
    gap = np.interp(x, *top.T) - np.interp(x, *bottom.T)
    total = 0.0
    for w, a, b in zip(np.diff(x), gap[:-1], gap[1:]):
        if a >= 0 and b >= 0:
            total += w * (a + b) / 2
        elif max(a, b) > 0:
            total += w * max(a, b) ** 2 / (2 * abs(a - b))
    return total


LOWER = between(GROUND, BASE) - between(GROUND, UPPER)


class SectionCase(ScriptCase):
    def plan(self, **changes: object) -> Path:
        plan = {"ground": GROUND, "layers": [{"name": "upper", "bottom": UPPER, "material": SAND},
                                             {"name": "lower", "bottom": BASE, "material": SAND}],
                "friction": 0.5, "cell_size": 0.5, "clear_height": 1, "time": {"end": 1, "dt": 0.01}} | changes
        return self.write("plan.json", json.dumps({k: v for k, v in plan.items() if v is not None}))

    def make(self, **changes: object) -> Made:
        return make(read_plan(self.plan(**changes)))

    def refused(self, *words: str, **changes: object) -> None:
        with self.assertRaises(TerrainError) as found:
            self.make(**changes)
        for word in words:
            self.assertIn(word, str(found.exception))

    def said(self, **changes: object) -> str:
        return "\n".join(write_scene(self.make(**changes), self.folder / "said"))

    def written_area(self, name: str) -> float:
        """Area of the cells of a mesh file, by its own text."""
        lines = (self.folder / "scene" / name).read_text(encoding="ascii").splitlines()
        at = lines.index("$Nodes")
        count = int(lines[at + 1].split()[1])
        nodes = np.array([line.split() for line in lines[at + 3 + count:at + 3 + 2 * count]], dtype=float)[:, :2]
        cells = [list(map(int, line.split()[1:])) for line in lines[lines.index("$Elements") + 3:]
                 if len(line.split()) == 5]
        return sum(area(nodes[np.array(cell) - 1]) for cell in cells)


class Areas(SectionCase):
    def assert_areas(self, made: Made, *expected: float) -> None:
        for mass, found in zip(made.masses, expected, strict=True):
            self.assertAlmostEqual(mass.area / found, 1, delta=1e-9, msg=mass.name)
            self.assertAlmostEqual(mass.cell_area() / found, 1, delta=1e-9, msg=mass.name)

    def test_layers_have_the_areas_of_the_plan(self) -> None:
        for h in (0.2, 0.5, 0.7):
            self.assert_areas(self.make(cell_size=h), between(GROUND, UPPER), LOWER)

    def test_layer_that_comes_to_the_ground_ends_there(self) -> None:
        rising = [[0, 6.2], [9, 4.3], [13, -1], [31.7, -1.1]]  # above the ground around x = 9
        lower = between(GROUND, BASE) - between(GROUND, rising)
        self.assert_areas(self.make(layers=[{"name": "upper", "bottom": rising, "material": SAND},
                                            {"name": "lower", "bottom": BASE, "material": SAND}]),
                          between(GROUND, rising), lower)

    def test_wall_with_footing_takes_its_area_from_the_soil(self) -> None:
        made = self.make(wall=WALL)
        ground = min(np.interp([19.3, 22.0], *np.array(GROUND).T))
        bottom, top = ground - 1.1, ground - 0.7
        footing = [[19.3, bottom], [22.0, bottom], [22.0, top], [19.3, top]]
        stem = between(GROUND, [[20.3, top], [20.9, top]])
        under = between([[19.3, top], [22.0, top]], UPPER) - between([[19.3, bottom], [22.0, bottom]], UPPER)
        self.assert_areas(made, between(GROUND, UPPER) - under - stem, LOWER - (area(footing) - under))

    def test_slide_on_the_ground(self) -> None:
        top = [[1, 6.531], [3, 8], [6, 6.5], [8, 2]]  # through the ground before its end
        made = self.make(slide={"surface": top, "material": SAND})
        self.assert_areas(made, between(GROUND, UPPER), LOWER, between(top, GROUND))
        made = self.make(layers=None, slide={"from": 2.1, "to": 12.9, "depth": 1.3, "material": SAND})
        self.assert_areas(made, 1.3 * 10.8)

    def test_files_hold_them(self) -> None:
        write_scene(self.make(wall=WALL), self.folder / "scene")
        made = self.make(wall=WALL)
        for mass in made.masses:
            self.assertAlmostEqual(self.written_area(f"{mass.name}.msh") / mass.area, 1, delta=1e-9)
        self.assertAlmostEqual(self.written_area("wall.msh"), 2.7 * 0.4 + 0.6 * (2 + 1.1 - 0.4), delta=1e-9)

    def test_section_of_a_raster(self) -> None:
        x, y = np.meshgrid(1 + 2 * np.arange(20), 1 + 2 * np.arange(20))
        rows = "\n".join(" ".join(f"{v:.9g}" for v in row) for row in (1500 - 0.5 * x - 0.25 * y)[::-1])
        self.write("dem.asc", f"ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 2\nNODATA_value -9999\n{rows}\n")
        layers = [{"name": "sand", "bottom": {"depth": 2}, "material": SAND}]
        ground = {"slope": "dem.asc", "line": [[5, 5], [20, 5], [20, 30]]}
        made = self.make(ground=ground, layers=layers)
        self.assert_areas(made, 2 * (15 + 25))
        np.testing.assert_allclose(made.plan.ground.z + made.origin[1], np.interp(
            made.plan.ground.x, [0, 15, 40], [1496.25, 1488.75, 1482.5]), rtol=0, atol=1e-9)
        self.assertLess(np.abs(made.masses[0].nodes).max(), 100)  # local coordinates
        self.refused("ground/line", "(5, 41)", ground=ground | {"line": [[5, 5], [5, 45]]}, layers=layers)
        self.refused("ground/line/1", "again", ground=ground | {"line": [[5, 5], [5, 5], [9, 9]]}, layers=layers)
        text = (self.folder / "dem.asc").read_text()
        for name, values, words in (("feet", "2225", "in US survey foot"), ("degrees", "4326", "WGS 84 in degrees"),
                                    ("web", "3857", "whose metre is 0.")):
            self.write(f"{name}.asc", text.replace("yllcorner 0", "yllcorner 6e6"))
            self.write(f"{name}.prj", f"EPSG:{values}")
            self.refused("ground/slope", words, ground=ground | {"slope": f"{name}.asc"}, layers=layers)
        self.write("gap.asc", text.replace("1499.25", "-32768").replace("1494.25", "-32768"))
        self.refused("ground/slope", "heights of -32768 m", ground=ground | {"slope": "gap.asc"}, layers=layers)
        high = "\n".join(" ".join(f"{100 * (float(v) - 1480):g}" for v in row.split()) for row in rows.splitlines())
        self.write("cm.asc", text.replace(rows, high))
        self.refused("ground/slope", "heights like centimetres", ground=ground | {"slope": "cm.asc"}, layers=layers)


class Walls(SectionCase):
    def test_wall_and_footing_are_one_mesh(self) -> None:
        wall = self.make(wall=WALL).wall
        self.assertEqual(len(np.unique(np.round(wall.nodes, 9), axis=0)), len(wall.nodes))  # none is doubled
        group = np.arange(len(wall.nodes))
        for _ in range(len(wall.nodes)):
            before = group.copy()
            for cell in wall.cells:
                group[cell] = group[cell].min()
            if (group == before).all():
                break
        self.assertEqual(set(group), {0})
        rim = np.concatenate(list(wall.groups.values()))
        length = np.linalg.norm(np.diff(wall.nodes[rim], axis=1)[:, 0], axis=1).sum()
        self.assertAlmostEqual(length, 2 * 2.7 + 2 * 3.1, places=9)  # a footing that is not joined would add twice 0.6
        self.assertLessEqual(np.ptp(wall.nodes[wall.groups["foot"]], axis=(0, 1))[1], 1e-12)

    def test_soil_meets_it_without_gap_or_overlap(self) -> None:
        made = self.make(wall=WALL)
        sides = column_sides(made.plan)
        for place in (19.3, 20.3, 20.9, 22.0):
            self.assertLess(np.abs(sides - place).min(), 1e-9)

    def test_wall_without_footing_on_rigid_ground(self) -> None:
        wall = {"at": 20, "height": 2, "thickness": 0.6}
        made = self.make(layers=None, slide={"from": 2, "to": 9, "depth": 2, "material": SAND}, wall=wall)
        foot = made.wall.nodes[made.wall.groups["foot"]]
        self.assertTrue((foot[..., 1] <= np.interp(foot[..., 0], *np.array(GROUND).T) + 1e-9).all())
        self.assertAlmostEqual(made.wall.crest[1], np.interp(20, *np.array(GROUND).T) + 2)

    def test_refused(self) -> None:
        self.refused("wall/depth", "nothing", wall={"at": 20, "height": 2, "thickness": 0.6})
        self.refused("wall/depth", "at least the thickness of the footing", wall=WALL | {"depth": 0.3})
        self.refused("footing/width", "1.6", wall=WALL | {"footing": {"width": 1.2, "thickness": 0.4, "before": 1}})
        self.refused("wall", "inside the ground", wall=WALL | {"at": 31.5})
        self.refused("wall", "allowed: 500000", wall={"at": 20, "height": 2, "thickness": 1e-9, "depth": 0.5})


class Lines(SectionCase):
    def test_ground_line(self) -> None:
        self.refused("ground/2", "folds back", "(10, 1)", ground=[[0, 5], [12, 2], [10, 1], [30, 0]])
        self.refused("ground/1", "folds back", ground=GROUND[::-1])
        self.refused("ground/2", "again", ground=[[0, 5], [12, 2], [12, 2], [30, 0]])
        self.refused("ground/2", "upright", ground=[[0, 5], [12, 2], [12, 1], [30, 0]])
        self.refused("ground", "at least 2 rows", ground=[[0, 5]])
        self.refused("ground", "at least 2 rows", ground=[])

    def test_layers(self) -> None:
        def layers(*bottoms: object) -> list[dict]:
            return [{"name": f"l{k}", "bottom": bottom, "material": SAND} for k, bottom in enumerate(bottoms)]

        self.refused("layers/1/bottom", "a gap from x = 30", "31.7", layers=layers(UPPER, [[0, 4], [30, -3]]))
        self.refused("layers/0/bottom", "a gap from x = 0 to 1", layers=layers([[1, 4], [31.7, -3]]))
        self.refused("layers/0/bottom/2", "again", layers=layers([[0, 4], [9, 2], [9, 2], [31.7, -3]]))
        self.refused("layers/0/bottom", "a height", layers=layers("deep"))
        self.refused("l0", "no part", layers=layers(8, BASE))  # above all of the ground
        self.refused("layers/1/name", "of its own", layers=[{"name": "a", "bottom": 0, "material": SAND},
                                                            {"name": "a", "bottom": -3, "material": SAND}])
        for name in ("wall", "slide"):  # files of these names hold something else
            self.refused("layers/0/name", "of its own", layers=[{"name": name, "bottom": BASE, "material": SAND}])
        for name in ("../up", "a/b", "Lehm_ü", "a.b", " "):
            self.refused("layers/0/name", "letters from A to z", layers=[{"name": name, "bottom": BASE,
                                                                         "material": SAND}])
        self.refused("layers/0/botom", "did you mean bottom", layers=[{"name": "a", "botom": 0}])
        self.refused("no soil", layers=[])

    def test_slide(self) -> None:
        self.refused("slide", "exactly one of surface", slide={"material": SAND})
        self.refused("slide/to", "more than from", slide={"from": 9, "to": 3, "depth": 1, "material": SAND})
        self.refused("slide", "inside the ground", slide={"from": -1, "to": 3, "depth": 1, "material": SAND})
        self.refused("slide/velocity", slide={"from": 1, "to": 3, "depth": 1, "material": SAND, "velocity": [1, 2, 3]})

    def test_units_that_are_hardly_meant(self) -> None:
        for key, value, word in (("density", 1.8, "t/m^3"), ("young_modulus", 20, "MPa"),
                                 ("friction_angle", 1.2, "radians"),
                                 ("cohesion", 5, "kPa")):
            layers = [{"name": "a", "bottom": BASE, "material": SAND | {key: value}}]
            self.assertIn(f"layers/0/material/{key}: found {value:g}, taken as", self.said(layers=layers), key)
            self.assertIn(word, self.said(layers=layers))
        said = self.said()
        for word in ("taken as", "plausible"):
            self.assertNotIn(word, said)
        self.assertIn("friction: found 27", self.said(friction=27))


class Water(SectionCase):
    LEVEL = [{"name": "sand", "bottom": -1, "material": SAND, "porosity": 0.4},
             {"name": "gravel", "bottom": -3, "material": SAND | {"density": 2000}, "porosity": 0.35}]
    FLAT = [[0, 0], [8, 0]]

    def bodies(self, **changes: object) -> list[dict]:
        write_scene(self.make(**changes), self.folder / "scene")
        return json.loads((self.folder / "scene/mpm.json").read_text(encoding="utf-8"))["bodies"]

    def test_layers_carry_what_lies_on_them(self) -> None:
        sand, gravel = self.bodies(ground=self.FLAT, layers=self.LEVEL)
        self.assertEqual(sand["initial_stress"], {"k0": "jaky", "surface": 0})
        # Of one stiffness both are compressed alike.
        self.assertAlmostEqual(gravel["initial_stress"]["surface"], -1 + 1800 / 2000)
        below = self.bodies(ground=self.FLAT, layers=self.LEVEL, water={"table": -1.5})
        self.assertEqual(below[0], sand)  # the table does not reach it
        self.assertAlmostEqual(below[1]["initial_stress"]["surface"], -1 + 1800 / 1650)
        self.assertNotIn("water", sand)
        sand, gravel = self.bodies(ground=self.FLAT, layers=self.LEVEL, water={"table": -0.2})
        self.assertEqual(sand["initial_stress"], {"k0": "jaky", "surface": 0, "water_table": -0.2})
        # 0.2 m of 1400 and 0.8 m of 1800 kg/m^3, as 0.8 m of 2000 and the rest of 1650.
        self.assertAlmostEqual(gravel["initial_stress"]["surface"],
                               -0.2 + (0.2 * 1400 + 0.8 * 1800 - 0.8 * 2000) / 1650)
        self.assertEqual(gravel["water"], {"porosity": 0.35})

    def test_constants_that_only_the_solver_can_judge(self) -> None:
        """A law without friction, constants that vary, are missing or wrong: the heights are those of the densities."""
        clay = {"law": "tresca", "density": 1800, "young_modulus": 1e6, "poisson_ratio": 0.4, "cohesion": 4e4}
        without = {key: value for key, value in SAND.items() if key != "poisson_ratio"}
        varies = SAND | {"young_modulus": {"field": "E.json"}}
        none = SAND | {"young_modulus": 0}
        for material, k0 in ((clay, "jaky"), (without, "elastic"), (varies, "jaky"), (none, "jaky")):
            with self.subTest(material=material):
                layers = [{"name": "top", "bottom": -1, "material": material, "k0": k0},
                          {"name": "rest", "bottom": -3, "material": material | {"density": 2000}, "k0": k0}]
                rest = self.bodies(ground=self.FLAT, layers=layers)[1]
                self.assertAlmostEqual(rest["initial_stress"]["surface"], -1 + 1800 / 2000)

    def test_refused(self) -> None:
        self.refused("water/table", "above the ground", "pool", ground=self.FLAT, layers=self.LEVEL,
                     water={"table": 0.1})
        self.refused("layers/0/porosity", ground=self.FLAT, water={"table": -0.2},
                     layers=[{"name": "a", "bottom": -3, "material": SAND}])
        self.refused("water/table", "level", water={"table": -2},
                     layers=[{"name": "a", "bottom": BASE, "material": SAND, "porosity": 0.4}])
        self.refused("water/table", "slide", ground=self.FLAT, layers=self.LEVEL, water={"table": -0.2},
                     slide={"from": 1, "to": 3, "depth": 1, "material": SAND})
        heavy = [self.LEVEL[0] | {"material": SAND | {"density": 1200}}, self.LEVEL[1]]
        self.refused("gravel", "lighter soil", ground=self.FLAT, layers=heavy, water={"table": 0})


class Scenes(SectionCase):
    def program(self, name: str, *options: object) -> subprocess.CompletedProcess:
        return subprocess.run([PROGRAMS / name, self.folder / "scene", "--output", self.folder / "results",
                               *map(str, options)],
                              capture_output=True, text=True, check=False, timeout=600)

    def test_layers_of_unlike_stiffness_have_no_jump(self) -> None:
        soft = [Water.LEVEL[0] | {"material": SAND | {"young_modulus": 1e6}},
                Water.LEVEL[1] | {"material": SAND | {"density": 2100, "young_modulus": 2e7}}]
        for table in (None, -0.3, -1.2, -6):
            with self.subTest(table=table):
                water = {} if table is None else {"water": {"table": table}}
                write_scene(self.make(ground=Water.FLAT, layers=soft, time={"end": 0.02, "dt": 0.01}, **water),
                            self.folder / "scene")
                checked = self.program("mpm_solver", "--check")
                self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_level_ground_with_water_runs_to_its_end_at_rest(self) -> None:
        plan = self.plan(ground=Water.FLAT, layers=Water.LEVEL, water={"table": -0.2}, time={"end": 0.02, "dt": 0.01})
        made = self.python_script("section", plan, self.folder / "scene")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertGreater((self.folder / "scene/scene.png").stat().st_size, 10_000)
        ran = self.program("mpm_solver")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        probes = np.genfromtxt(self.folder / "results/probes.csv", delimiter=",", names=True)
        weight = 9.81 * 8 * (0.2 * 1400 + 0.8 * 1800 + 2 * 2000)
        self.assertAlmostEqual(probes["basefy"][-1] / -weight, 1, delta=0.02)

    def test_scene_with_a_wall_is_accepted(self) -> None:
        plan = self.plan(wall=WALL, slide={"from": 2, "to": 6, "depth": 1, "material": SAND}, gauges=[
            {"name": "toe", "at": 16, "height": 3}], time={"end": 1, "dt": 0.01, "settle": 0.3})
        made = self.python_script("section", plan, self.folder / "scene", "--set", "cell_size=0.4")
        self.assertEqual(made.returncode, 0, made.stderr)
        checked = self.script("run", self.folder / "scene", "--check")
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        self.assertIn("valid", checked.stdout + checked.stderr)
        again = self.python_script("section", plan, self.folder / "scene")
        self.assertEqual(again.returncode, 2)
        self.assertIn("--replace", again.stderr)

    def test_example_is_what_its_plan_makes(self) -> None:
        scene = ROOT / "configs/slope_section"
        made = self.python_script("section", scene / "plan.json", self.folder / "scene")
        self.assertEqual(made.returncode, 0, made.stderr)
        for path in sorted((self.folder / "scene").iterdir()):
            if path.suffix != ".png":
                self.assertEqual(path.read_text(encoding="utf-8"), (scene / path.name).read_text(encoding="utf-8"),
                                 path.name)


if __name__ == "__main__":
    unittest.main()
