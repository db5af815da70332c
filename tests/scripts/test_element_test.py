#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/element-test: tests of the laboratory put together, their curves against closed forms.

    test_element_test.py PROGRAMS      folder of the built programs
"""

import math
import unittest

import element_case
import numpy as np
from element_case import SAND, ElementCase
from script_case import ROOT

from element.curves import friction_angle_of
from element.laboratory import TESTS
from plotting.results import Table

MUD = {"law": "herschel_bulkley", "density": 1800, "young_modulus": 1e6, "poisson_ratio": 0.45, "yield_stress": 100,
       "consistency": 50}
COHESIONLESS = SAND | {"cohesion": 0}
K_P = (1 + math.sin(math.radians(33))) / (1 - math.sin(math.radians(33)))


class Laboratory(ElementCase):
    """Components that the tests prescribe and hold."""

    def test_triaxial_reaches_the_strength(self) -> None:
        for confine in (2e4, 1e5):
            curves = self.curves("triaxial", COHESIONLESS, confine=confine, strain=0.1, back_pressure=3e5)
            self.assertAlmostEqual(curves["q"][-1] / confine, K_P - 1, delta=1e-8)
            self.assertEqual((curves["eps_a"][0], curves["eps_v"][0], curves["u"][0]), (0, 0, 0))
            np.testing.assert_allclose(curves["sigma_r"], confine, rtol=1e-8)
            self.assertLess(curves["eps_v"][-1], 0)  # it dilates

    def test_undrained_triaxial_keeps_the_volume(self) -> None:
        curves = self.curves("triaxial", COHESIONLESS | {"dilation_angle": 0}, confine=1e5, strain=0.1, undrained=True)
        self.assertLess(np.max(np.abs(curves["eps_v"])), 1e-10)
        np.testing.assert_allclose(curves["sigma_r"] + curves["u"], 1e5, rtol=1e-8)
        self.assertAlmostEqual(curves["sigma_a"][-1] / curves["sigma_r"][-1], K_P, delta=1e-8)

    def test_plane_strain_and_constant_p(self) -> None:
        plane = self.curves("plane_strain", COHESIONLESS, confine=1e5, strain=0.05)
        self.assertAlmostEqual(plane["sigma_a"][-1] / plane["sigma_r"][-1], K_P, delta=1e-8)
        mean = self.curves("constant_p", COHESIONLESS, confine=1e5, strain=0.05)
        np.testing.assert_allclose(mean["p"], 1e5, rtol=1e-8)

    def test_oedometer_loads_and_unloads(self) -> None:
        elastic = SAND | {"friction_angle": 50}
        curves = self.curves("oedometer", elastic, stress=4e5, unload=1e5)
        top = int(np.argmax(curves["sigma_a"]))
        self.assertAlmostEqual(curves["sigma_a"][top], 4e5, delta=1e-3)
        self.assertAlmostEqual(curves["sigma_a"][-1], 1e5, delta=1e-3)
        self.assertAlmostEqual(curves["sigma_r"][top] / 4e5, 0.3 / 0.7, delta=1e-8)
        self.assertEqual(np.max(np.abs(curves["eps_r"])), 0)

    def test_isotropic_has_no_deviator(self) -> None:
        curves = self.curves("isotropic", stress=4e5)
        self.assertLess(np.max(np.abs(curves["q"])), 1e-4)

    def test_shear_keeps_the_upright_stress_and_has_a_slip(self) -> None:
        curves = self.curves("direct_shear", COHESIONLESS, confine=1e5, strain=0.2, band_width=0.01)
        np.testing.assert_allclose(curves["sigma_a"], 1e5, rtol=1e-8)
        self.assertAlmostEqual(curves["slip"][-1], 0.002, delta=1e-12)
        self.assertLess(curves["tau"][-1] / 1e5, math.tan(math.radians(33)))
        self.assertGreater(curves["tau"][-1] / 1e5, math.tan(math.radians(25)))

    def test_cycles_turn_and_come_back(self) -> None:
        curves = self.curves("simple_shear", confine=1e5, strain=0.01, cycles=2)
        self.assertAlmostEqual(np.max(curves["gamma"]), 0.01, delta=1e-12)
        self.assertAlmostEqual(np.min(curves["gamma"]), -0.01, delta=1e-12)
        self.assertEqual(curves["gamma"][-1], 0)

    def test_mud_creeps_and_relaxes(self) -> None:
        # The axial rate under a deviator q: sqrt(J2) = q / sqrt(3), axial strain rate = shear rate / sqrt(3).
        q = 400.0
        curves = self.curves("creep", MUD, confine=1e3, stress=q, hold=0.01, duration=1e-5)
        rate = (q / math.sqrt(3) - 100) / 50 / math.sqrt(3)
        held = np.flatnonzero(curves["t"] > 1.5e-5)
        measured = np.polyfit(curves["t"][held], curves["eps_a"][held], 1)[0]
        self.assertAlmostEqual(measured / rate, 1, delta=0.02)
        relaxed = self.curves("relaxation", MUD, confine=1e3, strain=0.01, hold=10.0, duration=1e-4)
        self.assertAlmostEqual(relaxed["q"][-1], 100 * math.sqrt(3), delta=1)

    def test_every_test_says_what_it_does(self) -> None:
        for name, (make, *_) in TESTS.items():
            self.assertTrue(make.__doc__, name)

    def test_angle_of_friction_of_each_row(self) -> None:
        self.curves("triaxial", COHESIONLESS, confine=1e5, strain=0.1)
        angles = friction_angle_of(Table(self.folder / "triaxial.csv"))
        self.assertTrue(np.isnan(angles[0]))  # free of stress
        self.assertAlmostEqual(angles[-1], 33, delta=1e-6)


class Script(ElementCase):
    def run_script(self, *words: object):
        return self.python_script("element-test", *words, "--output", self.folder / "out",
                                  "--programs", element_case.PROGRAMS)

    def test_of_a_scene(self) -> None:
        scene = ROOT / "configs" / "slope_barrier"
        result = self.run_script(scene / "mpm.json", "--test", "triaxial", "--confine", 5e4, 1e5, "--strain", 0.05)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("triaxial_50_kPa", result.stdout)
        self.assertIn("33", result.stdout)  # the scene's angle of friction
        self.assertTrue((self.folder / "out" / "curves.png").exists())
        wrong = self.run_script(scene, "--test", "isotropic", "--stress", 1e5,
                                "--set", "mpm.json:/bodies/0/material/poisson_ratio=0.7")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("mpm.json: at /bodies/0/material/poisson_ratio", wrong.stderr)

    def test_stages_of_its_own(self) -> None:
        own = self.write_json("own.json", {"material": SAND, "stages": [
            {"name": "load", "stress": {"xx": 1e5, "yy": 1e5, "zz": 1e5}}]})
        result = self.run_script(own)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.run_script(own, "--test", "triaxial").returncode, 2)

    def test_what_cannot_be_followed_keeps_its_rows(self) -> None:
        soil = self.write_json("soil.json", {"material": SAND})
        result = self.run_script(soil, "--test", "creep", "--confine", 1e5, "--stress", 1e6, "--hold", 10)
        self.assertEqual(result.returncode, 3)
        self.assertIn('stage "load"', result.stderr)
        self.assertIn("limit load", result.stderr)
        self.assertGreater(Table(self.folder / "out" / "creep_100_kPa.csv").num_rows, 30)

    def test_wrong_words(self) -> None:
        soil = self.write_json("soil.json", {"material": SAND})
        typo = self.write_json("typo.json", {"material": SAND, "watre": {}})
        for words, part in ((("--test", "triaxial", "--strain", 0.1), "--confine"),
                            (("--test", "oedometer", "--stress", 1e5, "--hold", 3), "--hold"),
                            (("--test", "direct_shear", "--confine", 1e5, "--strain", 0.1), "--band-width"),
                            (("--test", "triaxial", "--confine", 1e5, 1e5, "--strain", 0.1), "twice"),
                            (("--test", "triaxial", "--confine", 1e5, "--strain", 0.1, "--body", "x"), "--body"),
                            (("--test", "triaxial", "--confine", "nan", "--strain", 0.1), "--confine: found nan"),
                            (("--test", "oedometer", "--stress", "inf"), "--stress: found inf"),
                            ((), "--test"),
                            (("--test", "triaxial", "--confine", 1e5, "--strain", 0.1, "--cycles", 0), "--cycles"),
                            (("--test", "triaxial", "--confine", 5e4, "--strain", 0.1, "--increments", 0),
                             "increments"),
                            (("--test", "triaxial", "--confine", 1e5, "--strain", 1.5), "below 1")):
            result = self.run_script(soil, *words)
            self.assertEqual(result.returncode, 2, words)
            self.assertIn(part, result.stderr)
        mud = self.write_json("mud.json", {"material": MUD})
        self.assertIn("the option is --duration", self.run_script(mud, "--test", "isotropic", "--stress", 1e3).stderr)
        self.assertIn("watre", self.run_script(typo, "--test", "isotropic", "--stress", 1e5).stderr)
        self.assertIn("no.json", self.run_script(self.folder / "no.json", "--test", "isotropic").stderr)


if __name__ == "__main__":
    element_case.take_programs()
    unittest.main()
