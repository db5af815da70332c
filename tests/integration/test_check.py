#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""--check in a launch: the set-up of a coupled run up to its first step, and what is wrong with it."""

import copy
import json
import subprocess

import launch
from launch import Ended, IntegrationCase, meeting
from test_foreign import FOREIGN, PYTHON, ROOT

# Programs of codes that scripts/setup does not install, and what they say where those are missing.
OPTIONAL = {"dealii_structure": "structures/dealii/build builds it", "opensees_structure": "-m pip install openseespy"}

# Warnings of scenes, which their pages explain.
WARNED = {"debris_flow_barrier": 'found "water" without "initial_stress"',
          "debris_flow_on_terrain": 'found "water" without "initial_stress"', "ring_net": "at /gravity",
          "slit_dam": "too long for the grid"}


class CheckCase(IntegrationCase):
    def check(self, files: dict[str, dict], code: int = 0, *options: str, **how) -> Ended:
        """Whatever is found, nothing is written."""
        self.write_scene(files)
        ended = self.run_launch("--check", *options, code=code, **how)
        self.assertFalse(self.out.exists(), ended.text)
        return ended

    def refused(self, files: dict[str, dict], *words: str) -> None:
        self.assert_says(self.check(files, code=2).text, "error: ", *words)

    def warned(self, files: dict[str, dict], *words: str) -> None:
        self.assert_says(self.check(files).text, "warning: ", *words)


class GoodScene(CheckCase):
    def test_report(self) -> None:
        ended = self.check(meeting())
        self.assertNotIn("warning", ended.text)
        # Spacing 0.01 on a line of 0.11 m; the left, top and right side of 2 x 10 cells.
        self.assert_says(ended.text, "interface wall: 12 vertices of soil on 23 of structure (nearest_projection)",
                         "farthest ")
        self.assert_says(ended.text, "2D, 46 unknowns on the coupled surfaces")
        self.assert_says(ended.text, "soil: 48 points, 189 grid nodes, 160 grid cells")
        self.assert_says(ended.text, "structure: 33 nodes, 20 cells, 60 unknowns")
        self.assert_says(ended.text, "time: 25 steps of 0.0005 s to 0.0125 s, 6 frames")
        self.assert_says(ended.text, "wall: smallest gap to the soil 0.01 m, 0.5 cells")
        # 96 bytes a point; 60 a node and 40 a cell; 24 a vertex of the line and 44 a segment.
        size = 48 * 96 + 33 * 60 + 20 * 40 + 12 * 24 + 11 * 44
        self.assert_says(ended.text, f"frames take at most {1e-6 * 6 * size:.3g} MB")
        self.assert_says(ended.text, f"{self.scene}: valid")

    def test_ranks(self) -> None:
        ended = self.check(meeting(), ranks={"mpm_solver": 2, "fem_solver": 2})
        self.assert_says(ended.text, "soil: 48 points")

    def test_restart_from_another_scene(self) -> None:
        self.write_scene(meeting())
        self.run_launch("--set", "coupler.json:/time/end=0.002", code=0)
        first = self.folder / "first"
        self.out.rename(first)
        self.check(meeting(), 0, "--restart", str(first))
        ended = self.check(meeting(), 2, "--restart", str(first), "--set", "fem.json:/material/density=1000")
        self.assert_says(ended.text, "error: ", "fem.json", "/material/density", "1000", "1100")


class Files(CheckCase):
    """Conditions that have to hold from file to file."""

    def test_interfaces_that_do_not_pair_up(self) -> None:
        files = meeting()
        files["coupler"]["interfaces"][0]["name"] = "wal"
        self.refused(files, "scene/coupler.json: at /interfaces/0/name", '"wal"', 'did you mean "wall"?')
        files = meeting()
        files["fem"]["interfaces"].append({"name": "foot", "groups": ["bottom"]})
        self.refused(files, "scene/fem.json: at /interfaces/1/name", '"foot"', "does not couple", "wall")

    def test_dimensions(self) -> None:
        files = meeting()
        files["fem"]["dimension"] = 3
        files["fem"]["mesh"]["box"] = {"low": [0.25, 0, 0], "high": [0.26, 0.01, 0.05], "cells": [2, 1, 10],
                                       "type": "hex8"}
        files["fem"]["gravity"] = [0, 0, -9.81]
        files["fem"]["probes"] = []
        self.refused(files, "scene/fem.json: at /dimension: found 3", "allowed: 2")

    def test_gravity(self) -> None:
        files = meeting()
        files["fem"]["gravity"] = [0, -9.8]
        self.warned(files, "scene/fem.json: at /gravity: found [0, -9.8]", "[0, -9.81]")

    def test_a_structure_that_nothing_holds(self) -> None:
        files = meeting()
        del files["fem"]["supports"], files["fem"]["initial_equilibrium"]
        self.warned(files, "scene/fem.json: at /supports: found no supports", "moves freely")

    def test_a_file_that_nobody_reads(self) -> None:
        files = meeting()
        files["coupler"]["participants"]["beam"] = files["coupler"]["participants"].pop("structure")
        files["coupler"]["interfaces"][0]["structure"] = "beam"
        self.write_scene(files)
        ended = self.run_launch("--check", code=0, programs=("coupler", "mpm_solver"))
        self.assert_says(ended.text, "scene/fem.json: no participant reads this file", 'no "structure"', "beam")
        self.assert_says(ended.text, "/participants/beam", "from outside")
        self.assert_says(ended.text, "interface wall: the surface of beam is not known here")
        self.assert_says(ended.text, "soil: 48 points")


class Soil(CheckCase):
    def test_a_probe_far_from_the_soil(self) -> None:
        files = meeting()
        files["mpm"]["probes"] = [{"name": "in", "point": [0.2, 0.06]}, {"name": "out", "point": [0.2, 0.1]}]
        self.warned(files, "mpm.json: at /probes/1/point", '"out"', "m away, more than a cell of the grid (0.02 m)")
        files["mpm"]["probes"].pop()
        self.assertNotIn("warning", self.check(files).text)

    def test_a_gauge_outside_the_grid(self) -> None:
        files = meeting()
        files["mpm"]["gauges"] = [{"name": "part", "corners": [[0.3, -0.1], [0.3, 0.1]]},
                                  {"name": "out", "corners": [[0.5, 0], [0.5, 0.1]]}]
        self.warned(files, "mpm.json: at /gauges/1/corners", '"out"', "outside the background grid")
        files["mpm"]["gauges"].pop()
        self.assertNotIn("warning", self.check(files).text)

    def test_a_material_in_other_units(self) -> None:
        for key, value, word in (("friction_angle", 0.35, "in radians it would be 20.1 degrees"),
                                 ("density", 2.65, "lighter than any soil")):
            files = meeting()
            files["mpm"]["bodies"][0]["material"][key] = value
            self.warned(files, f"mpm.json: at /bodies/0/material/{key}: found {value}", word)

    def test_mud_in_other_units(self) -> None:
        for key, value, words in (("yield_stress", 0.02, ("next to none", "in kPa it would be 20 Pa")),
                                  ("yield_stress", 2e5, ("more than any mud has",)),
                                  ("consistency", 2e7, ("thicker than any mud",))):
            files = meeting()
            mud = {"law": "herschel_bulkley", "density": 1800, "young_modulus": 1e6, "poisson_ratio": 0.45,
                   "yield_stress": 100, "consistency": 20}
            files["mpm"]["bodies"][0]["material"] = mud | {key: value}
            self.warned(files, f"mpm.json: at /bodies/0/material/{key}: found {value}", *words)

    def test_initial_stress_of_a_body_that_is_held_nowhere(self) -> None:
        files = meeting()
        files["mpm"]["bodies"][0].update(velocity=[0, 0], initial_stress={"k0": 0.7, "surface": 0.12})
        files["mpm"]["bodies"][0]["mesh"]["box"].update(low=[0.1, 0.06], high=[0.18, 0.12])
        self.refused(files, "mpm.json: at /bodies/0/initial_stress", "no equilibrium", "part of it is not held")

    def test_a_reversed_surface(self) -> None:
        files = meeting()
        files["mpm"]["interfaces"][0]["surface"]["polyline"].reverse()
        words = ("scene/coupler.json: at /interfaces/0: ", '"wall"', "normals that agree",
                 "reverse the order of the soil's polyline")
        self.refused(files, *words)
        files["mpm"]["bodies"][0]["mesh"]["box"].update(low=[0.08, 0], high=[0.16, 0.06])  # far from it
        self.refused(files, *words)

    def test_a_structure_outside_the_grid(self) -> None:
        files = meeting()
        surface = files["mpm"]["interfaces"][0]["surface"]
        surface["polyline"] = [[x + 5, y] for x, y in surface["polyline"]]
        files["fem"]["mesh"]["box"].update(low=[5.25, 0], high=[5.26, 0.05])
        files["fem"]["probes"] = []
        self.refused(files, "mpm.json: at /interfaces/0/surface", '"wall"', "from (5.25, 0) to (5.26, 0.0499865)",
                     "outside the background grid", "(0.4, 0.16)")

    def test_soil_on_both_sides_of_a_thin_wall(self) -> None:
        files = meeting()
        other = copy.deepcopy(files["mpm"]["bodies"][0])
        other["name"] = "other"
        other["mesh"]["box"].update(low=[0.27, 0], high=[0.35, 0.06])
        files["mpm"]["bodies"].append(other)
        self.warned(files, "mpm.json: at /interfaces/0/surface", 'soil on both sides of "wall"', "0.01 m thick",
                    "0.5 cells of 0.02 m", "advised: cells of at most half the thickness")

    def test_soil_inside_the_structure(self) -> None:
        files = meeting()
        files["mpm"]["bodies"][0]["mesh"]["box"].update(low=[0.17, 0], high=[0.257, 0.06])
        self.refused(files, "mpm.json: at /interfaces/0/surface", "material points inside the structure", '"wall"')

    def test_a_surface_too_coarse_for_the_grid(self) -> None:
        files = meeting()
        files["mpm"]["interfaces"][0]["surface"]["spacing"] = 0.05
        self.warned(files, "mpm.json: at /interfaces/0/surface", "2 of 3 facets", "2.5 cells", "at most one cell")


class Surfaces(CheckCase):
    def test_millimetres(self) -> None:
        files = meeting()
        files["fem"]["mesh"]["box"].update(low=[250, 0], high=[260, 50])
        files["fem"]["probes"] = []
        files["fem"]["initial_equilibrium"] = False  # 50 m of it would not stand
        self.refused(files, 'interface "wall"', "m away from the structure's surface",
                     "extends over 50, the soil's over 0.05, a factor of about 1000")

    def test_too_far_apart(self) -> None:
        files = meeting()
        files["fem"]["mesh"]["box"].update(low=[0.251, 0], high=[0.261, 0.05])
        files["fem"]["probes"] = []
        ended = self.check(files, code=2)
        self.assert_says(ended.text, 'interface "wall"', "m away", "coupling/mapping/tolerance")
        self.assertNotIn("millimetres", ended.text)

    def test_tolerance_below_the_rounding_of_positions(self) -> None:
        files = meeting()
        files["coupler"]["coupling"]["mapping"]["tolerance"] = 1e-16
        files["fem"]["mesh"]["box"]["cells"] = [1, 5]
        files["fem"]["interfaces"][0]["groups"] = ["left"]
        files["mpm"]["interfaces"][0]["surface"] = {"mesh": files["fem"]["mesh"], "groups": ["left"]}
        self.warned(files, "scene/coupler.json: at /coupling/mapping/tolerance: found 1e-16", "rounding")

    def test_tolerances_of_solvers(self) -> None:
        files = meeting()
        files["fem"]["newton"] = {"residual_tolerance": 1e-16}
        self.refused(files, "scene/fem.json: at /newton/residual_tolerance: found 1e-16", "rounding")
        files["fem"]["newton"] = {"residual_tolerance": 1e-14}
        self.warned(files, "scene/fem.json: at /newton/residual_tolerance: found 1e-14", "rounding")
        files["fem"]["newton"] = {"increment_tolerance": 1e-15}
        self.warned(files, "scene/fem.json: at /newton/increment_tolerance: found 1e-15", "without effect")


def command_of(scene: launch.Path) -> str:
    """The program of a scene's foreign structure; "": it has none."""
    coupler = scene / "coupler.json"
    participants = json.loads(coupler.read_text()).get("participants", {}) if coupler.is_file() else {}
    return next((part["command"][0] for part in participants.values() if "command" in part), "")


class ByScript(IntegrationCase):
    """scripts/run --check, with a foreign code too."""

    def run_script(self, scene: launch.Path) -> subprocess.CompletedProcess:
        if launch.binaries != ROOT / "build" / "release" / "bin":
            self.skipTest("scripts/run uses build/release only")
        return subprocess.run([ROOT / "scripts" / "run", scene, "--output", self.out, "--check"],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=launch.TIMEOUT, check=False)

    def script(self, habit: str = "") -> subprocess.CompletedProcess:
        files = meeting()
        if habit:
            del files["fem"]
            files["coupler"]["participants"]["structure"]["command"] = [PYTHON, *FOREIGN, habit]
            files["coupler"]["protocol"] = {"connect_deadline": 20}
        self.write_scene(files)
        return self.run_script(self.scene)

    def test_scenes_of_the_project(self) -> None:
        """All are valid, without a warning but those that their pages explain, and foreign codes write nothing either;
        one that is not here says how to get it."""
        for scene in sorted(path.parent for path in (ROOT / "configs").glob("*/mpm.json")):
            with self.subTest(scene.name):
                done = self.run_script(scene)
                how = OPTIONAL.get(command_of(scene))
                if how and how in done.stdout:
                    self.assertNotEqual(done.returncode, 0, done.stdout)
                    self.assertFalse(self.out.exists())
                    continue
                self.assertEqual(done.returncode, 0, done.stdout)
                self.assert_says(done.stdout, "valid")
                warnings = [line for line in done.stdout.splitlines() if "warning" in line]
                known = WARNED.get(scene.name)
                self.assertEqual([line for line in warnings if known is None or known not in line], [])
                self.assertEqual(known is None, not warnings)
                self.assertFalse(self.out.exists())

    def test_own_solvers(self) -> None:
        done = self.script()
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assert_says(done.stdout, "interface wall: 12 vertices of soil on 23 of structure")
        self.assert_says(done.stdout, f"{self.scene}: valid")
        self.assertFalse(self.out.exists())

    def test_a_foreign_code(self) -> None:
        done = self.script("good")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assert_says(done.stdout, "interface wall: 12 vertices of soil on 4 of structure")
        self.assert_says(done.stdout, "structure: does not tell its size")
        self.assert_says(done.stdout, f"{self.scene}: valid")

    def test_a_foreign_code_that_does_not_start(self) -> None:
        done = self.script("fails")
        self.assertNotEqual(done.returncode, 0, done.stdout)
        self.assert_says(done.stdout, "structure ended with exit code 3")
        self.assert_says(done.stdout, "The check failed")


if __name__ == "__main__":
    launch.main()
