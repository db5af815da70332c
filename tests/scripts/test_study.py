#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/study with a program that only looks like ours: runs, resuming, tables. Real runs are in
integration/test_study.py."""

import contextlib
import csv
import io
import json
import os
import signal
import unittest
from unittest import mock

from study_case import PICTURE, A, B, StudyCase

from plotting.lock import Owner, writing
from plotting.results import ResultsError
from sampling.evaluation import Evaluation
from sampling.study import Study
from studies.runner import Runner, Start


class Runs(StudyCase):
    def test_a_factorial_plan_runs_every_combination(self) -> None:
        self.study()
        self.assertEqual([(row["a"], row["b"], row["end"]) for row in self.rows()],
                         [("1", "10", "11.0"), ("1", "20", "21.0"), ("2", "10", "12.0"), ("2", "20", "22.0"),
                          ("3", "10", "13.0"), ("3", "20", "23.0")])
        note = json.loads((self.out / "runs" / f"{self.rows()[0]['label']}.run.json").read_text())
        self.assertEqual(note["settings"], [f"{A}=1", f"{B}=10"])
        self.assertEqual(json.loads((self.out / "study.json").read_text())["plan"], self.values)
        self.assertEqual(self.drawn, ["responses"])

    def test_runs_that_are_there_are_not_repeated_unless_they_differ(self) -> None:
        self.study()
        self.study()
        self.assertEqual(self.num_ran(), 6)
        self.values["parameters"]["a"]["list"] = [1, 4]
        self.study()
        self.assertEqual(self.num_ran(), 8)
        self.assertEqual([row["end"] for row in self.rows()], ["11.0", "21.0", "14.0", "24.0"])
        text = (self.folder / "scene" / "mpm.json").read_text()  # what every run reads
        self.write("scene/mpm.json", text.replace('"dimension"', ' "dimension"'))
        self.study()
        self.assertEqual(self.num_ran(), 12)

    def test_what_no_run_reads_does_not_matter(self) -> None:
        plan = self.write("scene/plan.json", json.dumps(self.values | {"scene": "."}))

        def study() -> int:
            done = self.python_script("study", plan, "--output", self.folder / "scene" / "study")
            self.assertEqual(done.returncode, 0, done.stderr)
            return self.num_ran()

        self.assertEqual(study(), 6)
        self.write("scene/README.md", "words")
        self.write("scene/.hidden/notes", "words")
        plan.write_text(plan.read_text() + "\n")
        self.assertEqual(study(), 6)
        self.write("scene/structure.json", "{}")  # of a foreign code
        self.assertEqual(study(), 12)

    def test_a_mesh_elsewhere_matters(self) -> None:
        self.write("mesh.msh", "1")
        scene = json.loads((self.folder / "scene" / "mpm.json").read_text())
        self.write("scene/mpm.json", json.dumps(scene | {"grid": {"file": "../mesh.msh"}}))
        self.study()
        self.write("mesh.msh", "22")
        self.study()
        self.assertEqual(self.num_ran(), 12)

    def test_points_with_the_same_settings_are_one_run(self) -> None:
        self.values |= {"design": {"method": "random", "runs": 8, "seed": 3}}
        self.values["parameters"]["b"] = {"set": B, "list": [10]}
        self.study()
        self.assertEqual(len(self.rows()), 8)
        self.assertLessEqual(self.num_ran(), 3)
        labels = [row["label"] for row in self.rows()]
        second = next(k for k, label in enumerate(labels) if label in labels[:k])
        said = self.study("--only", second).stdout
        self.assertEqual(said, f"run {second} has the settings of run {labels.index(labels[second])}\n")

    def test_a_stopped_study_goes_on_and_is_the_unbroken_one(self) -> None:
        self.study(out=self.folder / "whole")
        all_ran = self.num_ran()

        def stop_after_two(study: Study, outcome: object, attempt: object, read=Study._read) -> None:
            read(study, outcome, attempt)
            if sum(each.completed for each in study.outcomes) == 2:
                os.kill(os.getpid(), signal.SIGTERM)

        with mock.patch.object(Study, "_read", stop_after_two), self.assertRaises(SystemExit) as raised:
            self.study("--at-once", 1)
        self.assertEqual(raised.exception.code, 143)
        self.assertFalse((self.out / "runs.csv").exists())
        first = self.num_ran() - all_ran
        self.assertIn(first, (2, 3))  # one may have begun
        self.study()
        self.assertLessEqual(self.num_ran(), 2 * all_ran + 1)
        for table in ("runs.csv", "answers.csv"):
            self.assertEqual((self.out / table).read_bytes(), (self.folder / "whole" / table).read_bytes())

    def test_a_failed_run_is_said_and_the_others_go_on(self) -> None:
        self.values["parameters"]["a"]["list"] = [9, 1]
        done = self.study(code=1)
        self.assertEqual([row["status"] for row in self.rows()],
                         ["failed: step 1: no solution"] * 2 + ["completed"] * 2)
        self.assertEqual([row["end"] for row in self.rows()], ["", "", "11.0", "21.0"])
        self.assertIn("run 0 (", done.stderr)
        self.assertIn("2 of 4 runs are not completed", done.stdout)
        self.assertEqual(self.rows("answers")[0]["points"], "2")
        self.study(code=1)  # the same settings fail again: they are not run
        self.assertEqual(self.num_ran(), 4)
        self.study("--retry", code=1)
        self.assertEqual(self.num_ran(), 6)

    def test_a_run_that_leaves_nothing_is_tried_again(self) -> None:
        self.program.write_text("#!/bin/sh\necho x >>$RAN\necho '[mpm] error: disk full'\nexit 4\n")
        self.study(code=1)
        self.assertEqual(self.rows()[0]["status"], "failed: exit code 4: disk full")
        self.study(code=1)
        self.assertEqual(self.num_ran(), 12)

    def test_a_column_that_is_not_there_stops_the_study(self) -> None:
        self.values["answers"]["end"]["column"] = "y"
        done = self.study("--at-once", 1, code=2)
        self.assertIn("no column y; there are time, x", done.stderr)
        self.assertLess(self.num_ran(), 6)
        self.values["answers"]["end"]["column"] = "x"
        self.study()
        self.assertEqual(self.num_ran(), 6)

    def test_one_run_of_a_job_array(self) -> None:
        self.study("--only", 4)
        self.assertEqual(self.ran.read_text(), "3 10\n")
        self.assertFalse((self.out / "runs.csv").exists())
        with writing(self.out, "study", shared=True):  # another task of the array
            self.study("--only", 5)
            self.study(code=2)
        self.study()
        self.assertEqual(self.num_ran(), 6)
        self.assertIn("--only: found 6, allowed: 0 to 5", self.study("--only", 6, code=2).stderr)

    def test_a_second_study_in_the_folder_is_refused(self) -> None:
        self.out.mkdir()
        with writing(self.out, "study"):
            self.assertIn("in use by scripts/study (pid", self.study(code=2).stderr)
        self.assertEqual(self.num_ran(), 0)

    def test_a_folder_with_other_files_is_refused(self) -> None:
        self.write("out/notes.txt", "mine")
        self.assertIn("found notes.txt, allowed: a new or empty folder", self.study(code=2).stderr)

    def test_the_list_runs_nothing(self) -> None:
        self.assertIn("run", self.study("--list").stdout)
        self.assertEqual(self.study("--count").stdout, "6\n")
        self.assertFalse(self.out.exists())

    def test_variants_are_names_for_several_settings(self) -> None:
        self.values["parameters"] = {"kind": {"variants": {"soft": {A: 1, B: 10}, "stiff": {A: 2, B: 30}}}}
        self.study()
        self.assertEqual([(row["kind"], row["end"]) for row in self.rows()], [("soft", "11.0"), ("stiff", "32.0")])

    def test_repeats_change_a_setting_and_give_an_error_a_point(self) -> None:
        base = json.loads((self.folder / "scene" / "mpm.json").read_text())["bodies"][0]["material"]["young_modulus"]
        self.values["parameters"] = {"a": {"set": A, "list": [1, 2]}}
        self.values["repeats"] = {"count": 3, "set": B, "change": 0.5}
        self.study()
        ends = [float(row["end"]) for row in self.rows()]
        self.assertEqual(ends[1:3], [1 + 1.5 * base, 1 + 2 * base])
        (first, second) = self.rows("points")
        self.assertAlmostEqual(float(first["end"]), sum(ends[:3]) / 3)
        self.assertGreater(float(second["end: standard error"]), 0)

    def test_bands_and_fragility_are_written(self) -> None:
        self.values |= {"bands": {"x": {"column": "x"}},
                        "fragility": {"f": {"demand": "end", "capacity": 12.5, "intensity": "a"}}}
        with mock.patch.object(Evaluation, "picture", PICTURE):
            done = self.study()
        for name in ("responses", "band_x", "fragility_f"):
            self.assertTrue((self.out / f"{name}.png").read_bytes().startswith(b"\x89PNG"))
        band = self.rows("band_x")
        self.assertEqual((float(band[-1]["mean"]), band[-1]["standard error"]), (17.0, ""))
        self.assertEqual([(row["a"], row["share"]) for row in self.rows("fragility_f")],
                         [("1.0", "0.5"), ("2.0", "0.5"), ("3.0", "1.0")])
        self.assertIn("Fragility f: lognormal with median", done.stdout)

    def test_indices_of_a_sum_are_shares_of_its_variance(self) -> None:
        self.values |= {"design": {"method": "sobol_indices", "runs": 8, "seed": 1},
                        "parameters": {"a": {"set": A, "uniform": [1, 2]}, "b": {"set": B, "uniform": [1, 4]}}}
        self.study()
        self.assertEqual(len(self.rows()), 8 * 4)
        rows = list(csv.reader((self.out / "sobol_indices.csv").read_text().splitlines()))[1:]
        self.assertEqual([row[:2] for row in rows], [["end", "a"], ["end", "b"]])
        self.assertLess(float(rows[0][5]), float(rows[1][5]))


class Reuse(StudyCase):
    """Runner, which scripts/bench and scripts/study share."""

    def attempt(self, *settings: str, start: Start = Start(), reuse: bool = True) -> int:
        with contextlib.redirect_stdout(io.StringIO()):
            runs = [("run", str(self.folder / "scene"), list(settings))]
            return Runner(self.out, reuse, [], start).attempts(runs)[0].code

    def test_only_runs_of_the_same_settings_are_taken_again(self) -> None:
        self.attempt(f"{A}=1")
        self.attempt(f"{A}=1")
        self.assertEqual(self.num_ran(), 1)
        self.attempt(f"{A}=2")
        self.assertEqual(self.num_ran(), 2)
        self.attempt(f"{A}=2", start=Start(words=("--ranks", "mpm=2")))
        self.assertEqual(self.num_ran(), 3)
        self.attempt(f"{A}=2", start=Start(words=("--ranks", "mpm=2")), reuse=False)
        self.assertEqual(self.num_ran(), 4)

    def test_a_bench_takes_a_run_again_by_its_settings_too(self) -> None:
        def run(value: int) -> int:
            with contextlib.redirect_stdout(io.StringIO()):
                Runner(self.out, True, []).run("run", str(self.folder / "scene"), [f"{A}={value}"])
            return self.num_ran()

        self.assertEqual([run(1), run(1), run(2), run(2)], [1, 1, 2, 2])
        with self.assertRaisesRegex(ResultsError, "exit code 3"):
            run(9)
        self.assertEqual(run(2), 4)  # what the failed run left in the folder is of other settings

    def test_results_without_a_note_are_not_taken(self) -> None:
        self.attempt(f"{A}=1")
        (self.out / "run.run.json").unlink()
        self.attempt(f"{A}=1")
        self.assertEqual(self.num_ran(), 2)

    def test_a_run_in_use_is_left_alone(self) -> None:
        self.attempt(f"{A}=1")
        with writing(self.out / "run", "x"), mock.patch("studies.runner.owner_of") as owner:
            owner.return_value = Owner.ALIVE
            self.assertEqual(self.attempt(f"{A}=2"), 2)
        self.assertTrue((self.out / "run" / "summary.json").exists())

    def test_a_run_that_takes_too_long_is_ended(self) -> None:
        self.program.write_text("#!/bin/sh\nexec sleep 60\n")
        self.assertIsNone(self.attempt(start=Start(patience=0.2)))


if __name__ == "__main__":
    unittest.main()
