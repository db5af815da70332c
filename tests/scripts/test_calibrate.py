#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/calibrate: known parameters are found again, and what the tests do not say is said.

    test_calibrate.py PROGRAMS      folder of the built programs
"""

import json
import unittest
from unittest import mock

import element_case
import numpy as np
from element_case import SAND, ElementCase

from element import calibration
from element.calibration import Model, calibrate, misfit_of_curves
from element.calibration_plan import read_calibration
from element.curves import read_laboratory
from element.laboratory import ElementError
from fitting.least_squares import Fit
from sampling.reader import PlanError

GUESS = SAND | {"young_modulus": 1e7, "friction_angle": 28, "cohesion": 500}
FRICTION = {"phi": {"set": "/friction_angle", "between": [20, 45]}, "c": {"set": "/cohesion", "between": [100, 5e4]}}
STIFFNESS = {"E": {"set": "/young_modulus", "between": [1e6, 1e8]}}


class Calibrations(ElementCase):
    def laboratory(self, confine: float, noise: float = 0.0, columns: tuple[str, ...] = ("q",),
                   last: float = 0.06) -> dict:
        """A table of a triaxial test on SAND, and its entry in a plan."""
        rng = np.random.default_rng(int(confine))
        curves = self.curves("triaxial", confine=confine, strain=0.06)
        x = np.linspace(0.001, last, 25)
        found = [np.interp(x, curves["eps_a"], curves[name]) for name in columns]
        found = [y + noise * np.ptp(y) * rng.normal(size=len(y)) for y in found]
        found = [y / 1e3 if name == "q" else y for name, y in zip(columns, found)]
        head = ",".join(["eps_a[%]", *(f"{name}[{'kPa' if name == 'q' else '-'}]" for name in columns)])
        rows = "".join(",".join(f"{value:.10g}" for value in row) + "\n" for row in zip(100 * x, *found))
        name = f"lab_{confine:g}.csv"
        self.write(name, f"# made up\n{head}\n{rows}")
        return {"lab": name, "test": "triaxial", "confine": confine, "strain": 0.06}

    def plan(self, tests: list[dict], parameters: dict, **keys: object):
        values = {"material": GUESS, "parameters": parameters, "tests": tests, "samples": 8, "polished": 1, **keys}
        return read_calibration(self.write_json("plan.json", values))

    def fit(self, *args: object, **keys: object) -> Fit:
        plan = self.plan(*args, **keys)
        fit = calibrate(plan, Model(plan, element_case.PROGRAMS))
        self.misfit = misfit_of_curves(plan, fit)
        return fit

    def test_columns_that_the_test_does_not_answer(self) -> None:
        """A shear angle in a triaxial test, a volume in an undrained one: no parameter changes them."""
        test = self.laboratory(2e5)
        head, *rows = (self.folder / test["lab"]).read_text().splitlines()[1:]
        for column, more, words in (("gamma[-]", {}, "gamma, which does not change in the test"),
                                    ("eps_v[-]", {"undrained": True}, "eps_v, which does not change in the test"),
                                    ("slip[mm]", {}, "slip, which is not known in the test")):
            added = [f"{row},{k}" for k, row in enumerate(rows)]
            self.write("more.csv", "\n".join([f"{head},{column}", *added]) + "\n")
            with self.assertRaisesRegex(ElementError, f"more.csv: found the column {words} .*triaxial.*allowed: .*q"):
                self.fit([test | {"lab": "more.csv"} | more], FRICTION)

    def test_a_law_that_misses_the_curve(self) -> None:
        """Perfectly plastic soil against a curve with a peak: the fit is no description of it."""
        test = self.laboratory(2e5)
        text = "eps_a[%],q[kPa]\n" + "".join(f"{x:g},{600 * x * np.exp(1 - x):g}\n" for x in np.linspace(0.1, 6, 25))
        self.write("peak.csv", text)
        remarks = self.fit([test | {"lab": "peak.csv"}], FRICTION | STIFFNESS).remarks
        self.assertTrue(any("misses the curve by" in remark for remark in remarks), remarks)

    def test_exact_data_give_the_parameters(self) -> None:
        fit = self.fit([self.laboratory(5e4), self.laboratory(2e5)], FRICTION | STIFFNESS)
        for name, key in (("phi", "friction_angle"), ("c", "cohesion"), ("E", "young_modulus")):
            self.assertAlmostEqual(fit.values[name] / SAND[key], 1, delta=1e-3, msg=name)
        self.assertLess(max(self.misfit.values()), 1e-3)
        self.assertEqual(fit.remarks, [])

    def test_noisy_data_give_them_within_their_confidence(self) -> None:
        fit = self.fit([self.laboratory(5e4, 0.02), self.laboratory(2e5, 0.02)], FRICTION | STIFFNESS)
        for name, key in (("phi", "friction_angle"), ("c", "cohesion"), ("E", "young_modulus")):
            low, high = fit.interval[name]
            self.assertTrue(low < SAND[key] < high, f"{name}: {low} {high}")
            self.assertGreater(high - low, 1e-3 * SAND[key])
        self.assertAlmostEqual(self.misfit["triaxial_0 q"], 0.02, delta=0.01)

    def test_one_cell_pressure_does_not_tell_friction_from_cohesion(self) -> None:
        fit = self.fit([self.laboratory(1e5, 0.01)], FRICTION)
        self.assertTrue(any("phi, c: not identified by these tests" in remark for remark in fit.remarks), fit.remarks)

    def test_elastic_data_say_nothing_of_strength(self) -> None:
        cohesion = {"c": {"set": "/cohesion", "between": [2e4, 5e4]}}
        fit = self.fit([self.laboratory(2e5, last=0.01)], cohesion | STIFFNESS)
        self.assertTrue(any(remark.startswith("c: not identified") for remark in fit.remarks), fit.remarks)
        self.assertFalse(any(remark.startswith("E") for remark in fit.remarks), fit.remarks)

    def test_a_bound_that_is_reached_is_said(self) -> None:
        fit = self.fit([self.laboratory(5e4), self.laboratory(2e5)],
                       {"phi": {"set": "/friction_angle", "between": [20, 30]}})
        self.assertTrue(any("at the bound 30" in remark for remark in fit.remarks), fit.remarks)

    def test_values_that_the_law_refuses_are_gone_round(self) -> None:
        """Dilation above friction is refused by the program: such samples do not end the search."""
        parameters = {"phi": {"set": "/friction_angle", "between": [2, 45]},
                      "psi": {"set": "/dilation_angle", "between": [0, 40], "scale": "linear"}}
        material = GUESS | {"young_modulus": SAND["young_modulus"], "cohesion": SAND["cohesion"]}
        fit = self.fit([self.laboratory(1e5, columns=("q", "eps_v"))], parameters, material=material)
        self.assertAlmostEqual(fit.values["phi"], 33, delta=0.1)
        self.assertAlmostEqual(fit.values["psi"], 6, delta=0.1)

    def test_no_sample_with_an_answer(self) -> None:
        with self.assertRaisesRegex(ElementError, "none of 8 samples.*poisson_ratio"):
            self.fit([self.laboratory(1e5)], {"nu": {"set": "/poisson_ratio", "between": [0.6, 0.9]}})

    def test_the_script_writes_what_it_found(self) -> None:
        self.plan([self.laboratory(5e4), self.laboratory(2e5)], FRICTION | STIFFNESS)
        result = self.python_script("calibrate", self.folder / "plan.json", "--output", self.folder / "out",
                                    "--programs", element_case.PROGRAMS)
        self.assertEqual(result.returncode, 0, result.stderr)
        record = json.loads((self.folder / "out" / "calibration.json").read_text())
        self.assertAlmostEqual(record["material"]["friction_angle"], 33, delta=0.05)
        self.assertTrue((self.folder / "out" / "triaxial_1.png").exists())


class WrongPlans(ElementCase):
    """Nothing is run."""

    def setUp(self) -> None:
        super().setUp()
        self.write("lab.csv", "eps_a[-],q[kPa]\n0,0\n0.01,50\n0.02,80\n0.03,90\n")
        self.values = {"material": GUESS, "parameters": {**STIFFNESS},
                       "tests": [{"lab": "lab.csv", "test": "triaxial", "confine": 1e5}]}
        patch = mock.patch.object(calibration, "run_program", side_effect=AssertionError)
        patch.start()
        self.addCleanup(patch.stop)

    def expect(self, part: str, **change: object) -> None:
        path = self.write_json("plan.json", self.values | change)
        with self.assertRaisesRegex((PlanError, ElementError), part):
            read_calibration(path)

    def test_plans(self) -> None:
        read_calibration(self.write_json("plan.json", self.values))
        bad = {"set": "/young_modulus", "between": [1e6, 1e8]}
        self.expect("parameters", parameters={})
        self.expect("two that set the same", parameters={"a": bad, "b": bad})
        self.expect("between: found .*low < high", parameters={"a": bad | {"between": [2, 1]}})
        self.expect("/set: found", parameters={"a": bad | {"set": "/softening/slip"}})
        self.expect("scale", parameters={"a": bad | {"between": [-1, 1], "scale": "log"}})
        self.expect("unknown", paramters={})
        self.expect("material and scene|found material and scene", scene="x")
        self.expect("polished: found 30, allowed: at most", polished=30)
        self.expect("allowed: more values", parameters={k: {"set": f"/{k}", "between": [1, 2]} for k in "abcde"})
        test = self.values["tests"][0]
        self.expect("tests/0/confine", tests=[{"lab": "lab.csv", "test": "triaxial"}])
        self.expect("tests/0/hold", tests=[test | {"hold": 3}])
        self.expect("tests/0/over", tests=[test | {"over": "u"}])
        self.expect("names of their own", tests=[test | {"name": "a"}, test | {"name": "a"}])
        self.expect("no.csv", tests=[test | {"lab": "no.csv"}])

    def test_an_abscissa_ascends(self) -> None:
        """A curve that is sorted the other way, has a row twice, or returns; the other columns may do so."""
        for rows, part in (("3,90\n2,80\n1,50\n", r"lab.csv: row 2: found eps_a 0.02 after 0.03 \(SI units\), allowed"),
                           ("1,50\n2,80\n2,81\n3,90\n", "lab.csv: row 3: found eps_a 0.02 after 0.02"),
                           ("1,50\n2,80\n3,90\n2.9,40\n", "lab.csv: row 4: found eps_a 0.029 after 0.03")):
            self.write("lab.csv", f"# made up\neps_a[%],q[kPa]\n{rows}")
            self.expect(part)
        self.write("lab.csv", "q[kPa],eps_a[%]\n50,1\n80,2\n80,3\n70,4\n")
        read_calibration(self.write_json("plan.json", self.values))
        self.expect("row 3: found q 80000 after 80000", tests=[self.values["tests"][0] | {"over": "q", "strain": 0.04}])

    def test_tables(self) -> None:
        for text, part in (("eps_a[-],q\n0,0\n1,1\n2,2\n", "'q'"), ("eps_a[-],q[psi]\n0,0\n1,1\n2,2\n", "psi"),
                           ("eps_a[-],eps_a[%]\n0,0\n1,1\n2,2\n", "twice"),
                           ("eps_a[-],q[Pa]\n0,0\n1,x\n2,2\n", "row 2"),
                           ("eps_a[-],q[Pa]\n0,0\n1,nan\n2,2\n", "finite"), ("eps_a[-],q[Pa]\n0,0\n1\n2,2\n", "row 2"),
                           ("eps_a[-],q[Pa]\n0,0\n0,1,1\n2,2\n", "row 2: found 3 values, allowed: 2"),
                           ("eps_a[-],q[Pa]\n0,0\n1,\"1,5\"\n2,2\n", "row 2: found '1,5' for q, .*point for decimals"),
                           ("eps_a[-],q[Pa]\n0,0\n1,1_0\n2,2\n", "row 2: found '1_0' for q"),
                           ("eps_a[-];q[Pa]\n0;0\n1;1\n2;2\n", "found the column 'eps_a"),
                           ("eps_a[-],q[Pa]\n0,0\n", "at least 3 rows"), ("", "at least 3 rows")):
            with self.assertRaisesRegex(ElementError, part):
                read_laboratory(self.write("bad.csv", text))
        table = read_laboratory(self.write("lab.csv", "\ufeff# made\neps_a[%], q [MPa]\n0,0\n1,0.1\n2,0.2\n"))
        np.testing.assert_allclose(table.columns["eps_a"], [0, 0.01, 0.02])
        np.testing.assert_allclose(table.columns["q"], [0, 1e5, 2e5])


if __name__ == "__main__":
    element_case.take_programs()
    unittest.main()
