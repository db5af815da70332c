#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/study with a program that only looks like ours: plans, runs, resuming, tables. Real runs are in
integration/test_study.py."""

import contextlib
import csv
import io
import json
import os
import re
import signal
import subprocess
import unittest
from pathlib import Path
from unittest import mock

from script_case import ROOT, ScriptCase

from plotting.lock import Owner, writing
from plotting.results import ResultsError
from sampling.plan import read_plan
from sampling.reader import PlanError
from sampling.study import Study
from studies.runner import Runner, Start

# Answers a + b t for settings a, b; fails where a is 9, and notes that it ran.
PROGRAM = """#!/usr/bin/python3 -S
import json, os, sys
words = sys.argv[1:]
out = words[words.index("--output") + 1]
settings = [words[k + 1].partition("=") for k, word in enumerate(words) if word == "--set"]
a, b = (float(next((value for path, _, value in settings if path.endswith(key)), 1)) for key in ("density", "modulus"))
open(os.environ["RAN"], "a").write(f"{a:g} {b:g}\\n")
os.makedirs(out, exist_ok=True)
with open(out + "/probes.csv", "w") as table:
    table.write("time,x\\n" + "".join(f"{t},{a + b * t}\\n" for t in (0, 0.5, 1)))
bad = a == 9
summary = {"completed": not bad, "steps": 2} | ({"reason": "step 1: no solution"} if bad else {})
json.dump(summary, open(out + "/summary.json", "w"))
if bad:
    print("[mpm] error: no solution")
sys.exit(3 if bad else 0)
"""
A, B = (f"mpm.json:/bodies/0/material/{key}" for key in ("density", "young_modulus"))


class StudyCase(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.ran = self.folder / "ran"
        self.program = self.write("program", PROGRAM)
        self.program.chmod(0o755)
        self.write("scene/mpm.json", (ROOT / "configs" / "column_run_out" / "mpm.json").read_text())
        self.out = self.folder / "out"
        self.values = {
            "scene": "scene",
            "parameters": {"a": {"set": A, "list": [1, 2, 3]},
                           "b": {"set": B, "range": {"from": 10, "to": 20, "count": 2}}},
            "design": {"method": "factorial"},
            "answers": {"end": {"column": "x", "take": "last"}},
        }

        def command(runner: Runner, output: Path, scene: str, settings: list[str]) -> list[str]:
            words = [word for each in settings for word in ("--set", each)]
            return [str(self.program), scene, "--output", str(output), *words]

        for patch in (mock.patch.object(Runner, "_command", command),
                      mock.patch.dict(os.environ, {"RAN": str(self.ran)})):
            patch.start()
            self.addCleanup(patch.stop)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            self.addCleanup(signal.signal, number, signal.getsignal(number))

    def plan(self) -> Path:
        return self.write("plan.json", json.dumps(self.values))

    def study(self, *options: object, code: int = 0, out: Path | None = None) -> subprocess.CompletedProcess:
        done = self.python_script("study", self.plan(), "--output", out or self.out, *options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def rows(self, name: str = "runs", out: Path | None = None) -> list[dict[str, str]]:
        with ((out or self.out) / f"{name}.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    def num_ran(self) -> int:
        return len(self.ran.read_text().splitlines()) if self.ran.exists() else 0


class Runs(StudyCase):
    def test_a_factorial_plan_runs_every_combination(self) -> None:
        self.study()
        self.assertEqual([(row["a"], row["b"], row["end"]) for row in self.rows()],
                         [("1", "10", "11.0"), ("1", "20", "21.0"), ("2", "10", "12.0"), ("2", "20", "22.0"),
                          ("3", "10", "13.0"), ("3", "20", "23.0")])
        note = json.loads((self.out / "runs" / f"{self.rows()[0]['label']}.run.json").read_text())
        self.assertEqual(note["settings"], [f"{A}=1", f"{B}=10"])
        self.assertEqual(json.loads((self.out / "study.json").read_text())["plan"], self.values)
        self.assertTrue((self.out / "responses.png").exists())

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
        done = self.study()
        band = self.rows("band_x")
        self.assertEqual((float(band[-1]["mean"]), band[-1]["standard error"]), (17.0, ""))
        self.assertEqual([(row["a"], row["share"]) for row in self.rows("fragility_f")],
                         [("1.0", "0.5"), ("2.0", "0.5"), ("3.0", "1.0")])
        self.assertIn("F: lognormal with median", done.stdout)

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


class Plans(StudyCase):
    def expect(self, *words: str, **changes: object) -> None:
        values = self.values | changes
        path = self.write("plan.json", json.dumps({key: value for key, value in values.items() if value is not ...}))
        with self.subTest(words=words), self.assertRaises(PlanError) as raised:
            Study(read_plan(path), self.out, None)
        for word in words:
            self.assertIn(word, str(raised.exception))

    def parameter(self, **values: object) -> dict:
        return {"a": {"set": A, **values}}

    def test_what_is_wrong_is_said_with_its_place(self) -> None:
        self.expect("plan.json:/scene: found nothing", scene=...)
        self.expect("plan.json:/scene: ", "nowhere: no such scene folder", scene="nowhere")
        self.expect("plan.json:/sceen: unknown, allowed: scene", "did you mean scene?", sceen="x")
        self.expect("plan.json:/parameters: found {}, allowed: an object with at least one", parameters={})
        self.expect("plan.json:/answers: found nothing", answers=...)
        self.expect("plan.json:/settings: ", 'found "dx" at mpm.json:/time', settings={"mpm.json:/time/dx": 1})
        self.expect("plan.json:/parameters/a: ", 'did you mean "density"?',
                    parameters={"a": {"set": "mpm.json:/bodies/0/material/densty", "list": [1]}})
        self.expect("plan.json:/parameters/a: ", "found -1, allowed: > 0", parameters=self.parameter(list=[-1]))
        self.expect("plan.json:/answers/end/take: found 'max', allowed: one of largest",
                    answers={"end": {"column": "x", "take": "max"}})
        self.expect("plan.json:/answers: found the name of a parameter", answers={"a": {"column": "x", "take": "last"}})
        self.expect("plan.json:/answers/end/summary", answers={"end": {"summary": "steps"}})
        self.expect("plan.json:/bands/x/table: found 'walls.csv', allowed: one of probes.csv",
                    bands={"x": {"table": "walls.csv", "column": "x"}})
        self.expect("plan.json:/fragility/f/demand: found 'a', allowed: one of end",
                    fragility={"f": {"demand": "a", "capacity": 1, "intensity": "a"}})
        self.expect("plan.json:/fragility/f/capacity: found True, allowed: a number",
                    fragility={"f": {"demand": "end", "capacity": True, "intensity": "a"}})
        self.expect("plan.json:/ranks/mpm: found 0, allowed: a whole number >= 1", ranks={"mpm": 0})
        self.expect("plan.json:/ranks/soil: unknown, allowed: mpm, fem", ranks={"soil": 2})
        self.expect("plan.json:/repeats/set: ", "allowed: a number that is not 0",
                    repeats={"count": 2, "set": "mpm.json:/bodies/0/material/law", "change": 1e-6})

    def test_distributions(self) -> None:
        random = {"method": "random", "runs": 4, "seed": 1}
        for words, values in (
                (("/a: found none of list, range",), {}),
                (("/a: found list and uniform of",), {"list": [1], "uniform": [1, 2]}),
                (("/a/list: found [1, 1], allowed: a list of different values",), {"list": [1, 1]}),
                (("/a/list: found []",), {"list": []}),
                (("/a/uniform: found [2, 1], allowed: [low, high]",), {"uniform": [2, 1]}),
                (("/a/log_uniform: found [0, 1]", "0 < low"), {"log_uniform": [0, 1]}),
                (("/a/normal/deviation: found 0, allowed: a number > 0",), {"normal": {"mean": 1, "deviation": 0}}),
                (("/a/lognormal/variation: found beside median",),
                 {"lognormal": {"median": 1, "log_deviation": 1, "variation": 1}}),
                (("/a/lognormal: found none of median, mean",), {"lognormal": {}}),
                (("/a/range/to: found 1",), {"range": {"from": 1, "to": 1, "count": 2}}),
                (("/a/range/count: found 1",), {"range": {"from": 1, "to": 2, "count": 1}}),
                (("/a/range/from: found -1",), {"range": {"from": -1, "to": 2, "count": 3, "spacing": "log"}})):
            self.expect(*words, parameters=self.parameter(**values), design=random)

    def test_designs(self) -> None:
        sample = self.parameter(uniform=[1, 2])
        both = sample | {"b": {"set": B, "uniform": [1, 2]}}
        for words, design in ((("/design/method: found 'grid', allowed: one of factorial",), {"method": "grid"}),
                              (("/design/runs: found 60", "such as 32 or 64"),
                               {"method": "sobol", "runs": 60, "seed": 1}),
                              (("/design/seed: found nothing",), {"method": "random", "runs": 4}),
                              (("/a: found a distribution",), {"method": "factorial"}),
                              (("/design/cross: found a",),
                               {"method": "random", "runs": 4, "seed": 1, "cross": ["a"]})):
            self.expect(*words, parameters=sample, design=design)
        self.expect("/design/runs: unknown", design={"method": "factorial", "runs": 3})
        random = {"method": "random", "runs": 4, "seed": 1}
        for words, rows in ((("/correlations/0: found ['a', 'a', 0.5]",), [["a", "a", 0.5]]),
                            (("/correlations/0: found ['a', 'b', 1]",), [["a", "b", 1]]),
                            (("/correlations/1: found b and a again",), [["a", "b", 0.5], ["b", "a", 0.5]])):
            self.expect(*words, parameters=both, design=random, correlations=rows)
        three = both | {"c": {"set": "mpm.json:/time/dt", "uniform": [1, 2]}}
        self.expect("contradict each other", parameters=three, design=random,
                    correlations=[["a", "b", 0.9], ["b", "c", 0.9], ["a", "c", -0.9]])

    def test_the_plan_of_the_page(self) -> None:
        page = (ROOT / "docs" / "studies.md").read_text()
        text = re.search(r"^```json\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[1]
        (self.folder / "configs").symlink_to(ROOT / "configs")
        study = Study(read_plan(self.write("plans/plan.json", text)), self.out, None)
        self.assertEqual(len(study.outcomes), json.loads(text)["design"]["runs"])

    def test_files_that_are_no_plan(self) -> None:
        for text, words in (("{", "not JSON"), ("[]", "an object"),
                            ('{"scene": "a", "scene": "b"}', "found the key 'scene' twice")):
            with self.subTest(text), self.assertRaisesRegex(PlanError, words):
                read_plan(self.write("plan.json", text))
        with self.assertRaisesRegex(PlanError, "no such plan"):
            read_plan(self.folder / "nothing.json")


if __name__ == "__main__":
    unittest.main()
