#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/study with a plan that has "fit", with a program that only looks like ours: x = a + b t."""

import json
import os
import signal
import subprocess
import unittest
import zlib
from unittest import mock

import numpy as np
from study_case import A, B, StudyCase

from fitting import work
from fitting.bounds import Sought
from fitting.data import DataSet, MeasuredTable, OverPlan
from fitting.least_squares import Judge, Search, evaluate, search, slopes_at
from fitting.plan import FitPlan, _reach, read_fit
from plotting.deposit import Deposit, Plan
from plotting.results import ResultsError
from plotting.style import plt
from sampling.reader import PlanError, read_object
from sampling.study import Study

NU = "mpm.json:/bodies/0/material/poisson_ratio"  # the program does not look at it
TIMES = (0, 0.25, 0.5, 1)


def course(a: float, b: float, times: tuple[float, ...] = TIMES, sway: float = 0.0) -> str:
    """A table of x = a + b t, its values too large and too small by turns."""
    return "time,x\n" + "".join(f"{t},{a + b * t + sway * (-1) ** k}\n" for k, t in enumerate(times))


class FitCase(StudyCase):
    def setUp(self) -> None:
        super().setUp()
        scene = json.loads((self.folder / "scene" / "mpm.json").read_text())
        scene["time"]["end"] = 1  # as the program has it
        self.write("scene/mpm.json", json.dumps(scene))
        self.write("x.csv", course(3, 20))
        self.fit = {"parameters": {"a": {"set": A, "between": [1, 8]}, "b": {"set": B, "between": [5, 45]}},
                    "data": {"x": {"file": "x.csv", "value": "x", "deviation": 0.1, "column": "x"}},
                    "samples": 4, "restarts": 1}
        self.values = {"scene": "scene", "fit": self.fit}

        def save(figure: object, path: object) -> object:
            plt.close(figure)
            return path

        patch = mock.patch.object(work, "save", save)
        patch.start()
        self.addCleanup(patch.stop)

    def fitted(self, code: int = 0, *options: object) -> tuple[dict, subprocess.CompletedProcess]:
        done = self.study(*options, code=code)
        return json.loads((self.out / "fit.json").read_text()), done

    def expect_remark(self, start: str, code: int = 1) -> dict:
        found, _ = self.fitted(code)
        self.assertTrue(any(each.startswith(start) for each in found["warnings"]), found["warnings"])
        return found


class Fits(FitCase):
    def test_known_values_are_found_with_their_confidence(self) -> None:
        """The deviations are those of a straight line through values of 0.1."""
        found, done = self.fitted()
        columns = np.column_stack([np.ones(4), TIMES])
        sd = 0.1 * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
        for name, value, deviation in (("a", 3, sd[0]), ("b", 20, sd[1])):
            each = found["parameters"][name]
            self.assertAlmostEqual(each["value"], value, delta=5e-3)
            self.assertAlmostEqual(each["sd"], deviation, delta=1e-3 * deviation)
            self.assertAlmostEqual(each["interval_95"][1] - each["value"], 1.96 * deviation, delta=2e-3 * deviation)
        self.assertLess(found["correlation"][0][1], -0.7)
        self.assertEqual(found["warnings"], [])
        self.assertIn("x       4", done.stdout)
        self.assertEqual(len(self.rows("residuals")), 4)
        best = next(row for row in self.rows() if row["label"] == found["run"])
        self.assertAlmostEqual(float(best["a"]), 3, delta=5e-3)
        self.assertTrue((self.out / "runs" / best["label"] / "probes.csv").exists())

    def test_scatter_beyond_the_deviation_widens_the_interval(self) -> None:
        _, narrow = self.fitted(), json.loads((self.out / "fit.json").read_text())
        self.write("x.csv", course(3, 20, sway=0.15))
        found, _ = self.fitted()
        self.assertGreater(found["parameters"]["a"]["sd"], 1.5 * narrow["parameters"]["a"]["sd"])
        self.write("x.csv", course(3, 20, sway=2))
        self.expect_remark("the scene does not follow these data")

    def test_a_parameter_without_influence(self) -> None:
        self.fit["parameters"]["nu"] = {"set": NU, "between": [0.2, 0.3]}
        found = self.expect_remark("nu: not identified by these data")
        self.assertIsNone(found["parameters"]["nu"]["sd"])
        self.assertAlmostEqual(found["parameters"]["a"]["value"], 3, delta=5e-3)
        self.assertFalse([each for each in found["warnings"] if not each.startswith("nu")])

    def test_two_that_stand_for_each_other(self) -> None:
        self.write("x.csv", course(3, 20, (0.98, 0.99, 1)))
        self.expect_remark("a, b: not identified by these data one without the other")

    def test_bounds_narrower_than_what_the_data_say(self) -> None:
        self.fit["parameters"] = {"a": {"set": A, "between": [2.9, 3.1]}}
        self.fit["data"]["x"]["deviation"] = 1
        self.values["settings"] = {B: 20}
        self.expect_remark("a: not identified by these data: they say no more than its bounds")

    def test_a_bound_that_is_reached(self) -> None:
        self.fit["parameters"]["b"]["between"] = [5, 15]
        self.expect_remark("b: at the bound 15")

    def test_one_value_for_one_parameter(self) -> None:
        self.fit["parameters"] = {"a": {"set": A, "between": [1, 8]}}
        self.fit["data"] = {"end": {"value": 23, "deviation": 0.1, "column": "x", "take": "last"}}
        self.values["settings"] = {B: 20}
        found = self.expect_remark("as many values as parameters")
        self.assertAlmostEqual(found["parameters"]["a"]["value"], 3, delta=5e-3)
        self.assertAlmostEqual(found["parameters"]["a"]["sd"], 0.1, delta=5e-3)

    def test_units_do_not_matter(self) -> None:
        """Two data sets, the one in milliseconds and millimetres, say what both say in SI units."""
        self.fit["data"]["end"] = {"value": 23, "deviation": 1, "column": "x", "take": "last"}
        found, _ = self.fitted()
        rows = "".join(f"{1e3 * t},{1e3 * (3 + 20 * t)},100\n" for t in TIMES)
        self.write("x.csv", f"# made up\n time [ms], x[mm],sd[mm]\n\n{rows}")
        self.fit["data"]["x"]["deviation"] = "sd"
        again, _ = self.fitted()
        self.assertEqual(again["parameters"]["a"]["value"], found["parameters"]["a"]["value"])
        np.testing.assert_allclose(again["parameters"]["b"]["sd"], found["parameters"]["b"]["sd"], rtol=1e-9)

    def test_a_start_of_its_own_needs_no_samples(self) -> None:
        self.fit |= {"restarts": 0}
        self.fit["parameters"]["a"]["start"], self.fit["parameters"]["b"]["start"] = 2, 40
        found, _ = self.fitted()
        self.assertEqual((self.rows()[0]["a"], self.rows()[0]["b"]), ("2.0", "40.0"))
        self.assertAlmostEqual(found["parameters"]["b"]["value"], 20, delta=1e-2)
        self.assertEqual(len(found["starts"]), 1)


class Runs(FitCase):
    def test_a_stopped_fit_goes_on_and_is_the_unbroken_one(self) -> None:
        self.study(out=self.folder / "whole")
        all_ran = self.num_ran()

        def stop_after_six(study: Study, outcome: object, attempt: object, read=Study._read) -> None:
            read(study, outcome, attempt)
            if sum(each.completed for each in study.outcomes) == 6:
                os.kill(os.getpid(), signal.SIGTERM)

        with mock.patch.object(Study, "_read", stop_after_six), self.assertRaises(SystemExit) as raised:
            self.study("--at-once", 1)
        self.assertEqual(raised.exception.code, 143)
        self.assertFalse((self.out / "fit.json").exists())
        self.study()
        self.assertLessEqual(self.num_ran(), 2 * all_ran + 1)  # one may have begun
        for table in ("runs.csv", "parameters.csv", "residuals.csv", "fit.json"):
            self.assertEqual((self.out / table).read_bytes(), (self.folder / "whole" / table).read_bytes(), table)
        before = self.num_ran()
        self.study()
        self.assertEqual(self.num_ran(), before)

    def test_a_run_without_an_end_is_named(self) -> None:
        """The run comes to no end where a is 9, where the first start is."""
        self.fit["parameters"]["a"] |= {"between": [1, 17], "scale": "linear", "start": 9}
        self.fit["parameters"]["b"]["start"] = 10
        found, done = self.fitted(1)
        self.assertAlmostEqual(found["parameters"]["a"]["value"], 3, delta=5e-3)
        self.assertEqual(self.rows()[0]["status"], "failed: step 1: no solution")
        self.assertEqual(len(found["warnings"]), 1)
        self.assertRegex(done.stdout, r"warning: run 0 \(\w{12}\) failed: step 1: no solution; the fit went round")
        self.fit |= {"restarts": 0}
        done = self.study(code=1)
        self.assertIn("none of 1 samples has an answer; the last: run 0 (", done.stderr)
        before = self.num_ran()
        self.study("--retry", code=1)
        self.assertEqual(self.num_ran(), before + 1)

    def test_a_run_that_fails_for_another_reason_ends_the_fit(self) -> None:
        self.program.write_text("#!/bin/sh\necho '[mpm] error: disk full'\nexit 4\n")
        done = self.study(code=1)
        self.assertRegex(done.stderr, r"scripts/study: run \d \(\w{12}\) failed: exit code 4: disk full")
        self.assertEqual({row["status"] for row in self.rows()}, {"failed: exit code 4: disk full"})
        self.assertFalse((self.out / "fit.json").exists())

    def test_a_column_that_is_not_there(self) -> None:
        self.fit["data"]["x"]["column"] = "y"
        self.assertIn("no column y; there are time, x", self.study(code=2).stderr)

    def test_data_after_the_end_of_a_run(self) -> None:
        """The scene says that it goes on until then, the run knows better."""
        self.write("x.csv", course(3, 20, (0, 0.5, 1.1)))
        self.values["settings"] = {"mpm.json:/time/end": 2}
        self.assertIn("found times from 0 to 1.1 s, allowed: those of x in", self.study(code=2).stderr)

    def test_options_of_designs_are_refused(self) -> None:
        for option in (("--list",), ("--count",), ("--only", 0)):
            self.assertIn(f'{option[0]}: found a plan with "fit"', self.study(*option, code=2).stderr)
        self.assertEqual(self.num_ran(), 0)


class Scattered:
    """x = 5 z_0 at twenty places, with scatter of 0.3 that follows from both values."""

    last_refusal = ""

    def misfits(self, points: list[np.ndarray]) -> list[np.ndarray]:
        return [5 * (z[0] - 0.4) * np.linspace(1, 2, 20)
                + 0.3 * np.random.default_rng(zlib.crc32(z.tobytes())).normal(size=20) for z in points]


class Engine(unittest.TestCase):
    def test_scatter_is_not_taken_for_an_influence(self) -> None:
        sought = [Sought("a", 0, 1, False), Sought("b", 0, 1, False)]
        slopes = slopes_at(sought, Scattered(), np.array([0.4, 0.5]), 0.1)
        self.assertLess(slopes.bend[0], work.BENT)
        self.assertGreater(slopes.bend[1], work.BENT)
        (r,) = Scattered().misfits([np.array([0.4, 0.5])])
        fit = evaluate(sought, r, slopes, np.array([0.4, 0.5]), Judge("these data", known=True))
        remarks = work._remarks_of_parameters([*sought], fit, slopes)
        self.assertTrue(any(each.startswith("b: not identified") for each in [*remarks, *fit.remarks]))
        self.assertFalse(any(each.startswith("a: ") for each in [*remarks, *fit.remarks]))

    def test_starts_end_in_different_minima(self) -> None:
        """(z - 0.2)(z - 0.8) is zero twice."""
        class Twice:
            last_refusal = ""

            def misfits(self, points: list[np.ndarray]) -> list[np.ndarray]:
                return [np.array([10 * (z[0] - 0.2) * (z[0] - 0.8)] * 2) for z in points]

        ends = search([Sought("a", 0, 1, False)], Twice(), Search(4, 4, 1))
        found = sorted(round(end.z[0], 4) for end in ends)
        self.assertEqual((found[0], found[-1]), (0.2, 0.8))


class Plans(FitCase):
    """Nothing runs."""

    def read(self) -> FitPlan:
        path = self.plan()
        return read_fit(path, read_object(path))

    def expect(self, *words: str) -> None:
        with self.subTest(words=words), self.assertRaises(PlanError) as raised:
            self.read()
        for word in words:
            self.assertIn(word, str(raised.exception))

    def expect_of(self, place: dict, words: tuple[str, ...], **changes: object) -> None:
        """Changes of a part of the plan, ... takes a key out."""
        before = dict(place)
        place.update(changes)
        for key in [key for key, value in changes.items() if value is ...]:
            del place[key]
        self.expect(*words)
        place.clear()
        place.update(before)

    def test_keys(self) -> None:
        self.read()
        self.expect_of(self.values, ("plan.json:/scene: ", "no such scene folder"), scene="nowhere")
        self.expect_of(self.values, ("plan.json:/parameters: unknown, allowed: scene",), parameters={})
        self.expect_of(self.values, ("plan.json:/settings: ", 'found "dx"'), settings={"mpm.json:/time/dx": 1})
        self.expect_of(self.values, ("plan.json:/ranks/mpm: found 0",), ranks={"mpm": 0})
        self.expect_of(self.fit, ("plan.json:/fit/parameters: found {}",), parameters={})
        self.expect_of(self.fit, ("plan.json:/fit/data: found nothing",), data=...)
        self.expect_of(self.fit, ("plan.json:/fit/restarts: found 9, allowed: at most as many as samples, 4",),
                       restarts=9)
        self.expect_of(self.fit, ("plan.json:/fit/restarts: found 0, allowed: a whole number >= 1",), restarts=0)
        self.expect_of(self.fit, ("plan.json:/fit/step: found 0.5, allowed: a number > 0, at most 0.25",), step=0.5)

    def test_parameters(self) -> None:
        a = self.fit["parameters"]["a"]
        where = "plan.json:/fit/parameters/a"
        self.expect_of(a, (f"{where}/between: found [8, 1], allowed: [low, high] with low < high",), between=[8, 1])
        self.expect_of(a, (f"{where}/start: found 9, allowed: a number from 1 to 8",), start=9)
        self.expect_of(a, ("plan.json:/fit/parameters/b/start: found nothing",), start=2)
        self.expect_of(a, (f"{where}: ", 'did you mean "density"?'), set="mpm.json:/bodies/0/material/densty")
        self.expect_of(a, (f"{where}: ", "found -1.0, allowed: > 0"), between=[-1, 8])
        self.expect_of(a, ("plan.json:/fit/parameters/b: ", "overwrites what a sets"), set=[A, B])
        self.expect_of(self.fit["parameters"], ("found the name misfit",), misfit={"set": NU, "between": [0.1, 0.2]})
        self.write("x.csv", course(3, 20, (1,)))
        self.expect("plan.json:/fit/data: found 1 measured value for 2 parameters, allowed: at least as many values")

    def test_a_setting_that_a_parameter_sets_too(self) -> None:
        self.expect_of(self.values, (f'plan.json:/fit/parameters/a: found {A}, which "settings" of the plan sets '
                                     'too, allowed: one of both',), settings={A: 2})

    def test_a_scene_without_soil(self) -> None:
        (self.folder / "scene" / "mpm.json").unlink()
        self.write("scene/fem.json", json.dumps({"dimension": 2, "material": {"density": 2000}, "time": {"end": 1}}))
        self.fit["parameters"] = {"a": {"set": "fem.json:/material/density", "between": [1000, 3000]}}
        self.read()
        self.fit["data"]["heap"] = {"file": "x.csv", "over": "time", "value": "x", "deviation": 0.1, "deposit": "depth"}
        self.expect("plan.json:/scene: ", "mpm.json")

    def test_data(self) -> None:
        x = self.fit["data"]["x"]
        where = "plan.json:/fit/data/x"
        self.expect_of(x, (f"{where}/file: ", "no.csv: No such file"), file="no.csv")
        self.expect_of(x, (f"{where}/file: ", "found no column y, allowed: time, x"), value="y")
        self.expect_of(x, (f"{where}/file: ", "found no column t, allowed: time, x"), over="t")
        self.expect_of(x, (f"{where}/over: found 'x', allowed: 1 column other than x",), over="x")
        self.expect_of(x, (f"{where}/deviation: found 0, allowed: a number > 0 in the unit of x",), deviation=0)
        self.expect_of(x, (f"{where}/deviation: found nothing",), deviation=...)
        self.expect_of(x, (f"{where}/take: unknown, allowed: file",), take="last")
        self.expect_of(x, (f"{where}: found column and deposit of column, summary, deposit",), deposit="depth")
        self.expect_of(x, (f"{where}/summary: found", "no file beside it"), column=..., summary="/steps")
        self.expect_of(x, (f"{where}/value: found 'x', allowed: a number",), file=...)
        self.expect_of(x, (f"{where}/deposit: found 'height', allowed: one of depth",), column=..., deposit="height")
        self.expect_of(x, (f"{where}/file: found 'd.asc', allowed: a CSV file",), column=..., deposit="depth",
                       file="d.asc", value=...)

    def test_tables(self) -> None:
        place = "plan.json:/fit/data/x"
        for text, words in (
                ("", ("found 0 rows, allowed: a head and at least one row",)),
                ("time,x\n", ("found 0 rows",)),
                ("time,x\n0,1\n0.5,nan\n1,2\n", ("row 2: found 'nan' for x, allowed: a finite number",)),
                ("time,x\n0,1\n0.5\n", ("row 2: found 1 value, allowed: 2, as the head has",)),
                ("time,x\n0,1\n0,5,2\n", ("row 2: found 3 values, allowed: 2, as the head has",)),
                ("time,x\n0,1\n1,1_0\n", ("row 2: found '1_0' for x, allowed: a finite number",)),
                ('time,x\n0,1\n1,"2,5"\n', ("row 2: found '2,5' for x, allowed: a finite number, with a point",)),
                ("time,x\n0,1\nsoon,2\n", ("row 2: found 'soon' for time",)),
                ("time,x\n0,1\n0.5,2\n0.5,3\n", ("row 3: found time 0.5 (SI units) twice, allowed",)),
                ("time,x,x\n0,1,1\n1,2,2\n", ("found the column x twice",)),
                ("time,x[inch]\n0,1\n1,2\n", ("found the unit 'inch' of x, allowed: m, mm",)),
                ("time[mm],x\n0,1\n1,2\n", ("/over: found time in a unit of length, allowed: one of time",)),
                ("time,x\n0,1\n7,2\n", ("found the time 7 s, allowed: 0 to ",)),
                ("time,x\n-0.1,1\n1,2\n", ("found the time -0.1 s, allowed: 0 to ",))):
            self.write("x.csv", text)
            self.expect(place, *words)
        self.fit["data"]["x"]["deviation"] = "sd"
        for head, value, words in (("sd[s]", 1, ("found sd with the unit of time, allowed: one of length",)),
                                   ("sd", 1, ("found sd with the unit of none, allowed: one of length",)),
                                   ("sd[mm]", -1, ("row 1: found -1, allowed: a number > 0",))):
            self.write("x.csv", f"time,x[mm],{head}\n0,1,{value}\n1,2,1\n")
            self.expect(f"{place}/deviation", *words)


class Deposits(FitCase):
    """A heap of 1, 2, 3 m over cells of 2 m, on a map that begins at 100 m."""

    def predicted(self, at: list[list[float]], source: OverPlan = OverPlan("depth", None, None)) -> np.ndarray:
        dim = len(at[0])
        shape = (3,) if dim == 1 else (3, 2)
        depth = np.array([1.0, 2, 3]) if dim == 1 else np.column_stack([[1.0, 2, 3]] * 2)
        found = Deposit(Plan(tuple(range(dim)), np.zeros(dim), 2.0, shape), 0.5, depth, depth, depth, depth)
        results = mock.Mock(folder="out", origin=np.array([100.0, 200, 0]))
        data = DataSet("heap", "plan.json:/fit/data/heap", ("x", "y")[:dim], np.array(at), np.zeros(len(at)),
                       np.ones(len(at)), source)
        with mock.patch("fitting.data.find_deposit", return_value=found):
            return data.predicted(results)

    def test_values_between_centres_and_beside_the_soil(self) -> None:
        np.testing.assert_allclose(self.predicted([[101.0], [102], [105], [106], [200]]), [1, 1.5, 3, 1.5, 0])
        np.testing.assert_allclose(self.predicted([[101.0, 201], [104, 202], [105, 204], [0, 0]]), [1, 2.5, 1.5, 0])

    def test_a_run_that_does_not_come_so_far_has_no_soil_there(self) -> None:
        np.testing.assert_array_equal(self.predicted([[1.0], [300]]), [0, 0])
        np.testing.assert_array_equal(self.predicted([[1.0, 201], [101, 300]]), [0, 0])

    def test_another_time_is_said(self) -> None:
        with self.assertRaisesRegex(ResultsError, "found no frame at 0.4 s, the nearest is at 0.5 s"):
            self.predicted([[101.0]], OverPlan("depth", 0.4, None))

    def test_another_origin_is_said(self) -> None:
        """The grid is 0.4 m long."""
        self.fit["data"] = {"heap": {"file": "d.csv", "value": "d", "deviation": 0.1, "deposit": "depth"}}
        path = self.plan()

        def read() -> FitPlan:
            return read_fit(path, read_object(path))

        self.write("d.csv", "x,d\n0.3,1\n0.5,0\n")
        read()
        self.write("d.csv", "x,d\n100.1,1\n100.5,0\n")
        with self.assertRaisesRegex(PlanError, "fit/data/heap: found no point of the data over the grid of the scene, "
                                               "0 to 0.4 m in map coordinates, allowed: at least one; do both"):
            read()
        scene = json.loads((self.folder / "scene" / "mpm.json").read_text())
        self.write("scene/mpm.json", json.dumps(scene | {"origin": [100, 7]}))
        read()

    def test_reach_of_the_grid(self) -> None:
        soil = {"dimension": 3, "gravity": [0, -9.81, 0], "origin": [10, 20, 30],
                "grid": {"box": {"low": [0, 1, 2], "high": [3, 4, 5]}}}
        np.testing.assert_allclose(_reach(soil), [[10, 32], [13, 35]])
        for change in ({"grid": {"file": "grid.msh"}}, {"dimension": 4}, {"origin": [1]}, {"grid": {"box": {}}}):
            self.assertIsNone(_reach(soil | change))

    def test_a_raster_gives_a_value_a_cell(self) -> None:
        scene = json.loads((self.folder / "scene" / "mpm.json").read_text()) | {"dimension": 3}
        scene["gravity"] = [0, 0, -9.81]
        scene["grid"]["box"] |= {"low": [100, 200, 0], "high": [110, 210, 1]}
        self.write("scene/mpm.json", json.dumps(scene))
        self.write("d.asc", "ncols 2\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 2\nNODATA_value -9999\n"
                            "0.1 -9999\n0.3 0.4\n")
        self.fit["data"] = {"heap": {"file": "d.asc", "deviation": 0.05, "deposit": "depth"}}
        path = self.plan()
        (data,) = read_fit(path, read_object(path)).data
        np.testing.assert_allclose(data.at, [[101, 201], [103, 201], [101, 203]])
        np.testing.assert_allclose(data.values, [0.3, 0.4, 0.1])
        np.testing.assert_allclose(data.deviation, 0.05)

    def test_a_table_of_a_profile(self) -> None:
        table = MeasuredTable(self.write("p.csv", "x[cm],depth[mm]\n10,5\n"), "plan.json:/fit/data/p")
        np.testing.assert_allclose([table.numbers("x")[0], table.numbers("depth")[0]], [0.1, 0.005])


if __name__ == "__main__":
    unittest.main()
