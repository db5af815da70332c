#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/study with the real programs: stopped in the middle of a run and resumed, and as a job array."""

import json
import os
import signal
import subprocess
from pathlib import Path

import launch
from launch import Launch
from test_python import soil_of
from test_restart_script import ROOT, ScriptCase

SCRIPT = ROOT / "scripts" / "templates" / "slurm" / "study.sbatch"
TABLES = ("runs.csv", "answers.csv", "band_front.csv", "rank_correlations.csv")


class Studies(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.write_scene({"mpm": soil_of(end=0.2)})
        self.plan = self.folder / "plan.json"
        material = "mpm.json:/bodies/0/material"
        self.plan.write_text(json.dumps({
            "scene": "scene",
            "parameters": {"friction": {"set": f"{material}/friction_angle", "uniform": [15, 35]},
                           "stiffness": {"set": f"{material}/young_modulus",
                                         "lognormal": {"mean": 8e5, "variation": 0.3}}},
            "design": {"method": "random", "runs": 3, "seed": 1},
            "answers": {"front": {"column": "front", "take": "last"}, "newton": {"summary": "/newton_iterations"}},
            "bands": {"front": {"column": "front"}}}))

    def words(self, out: str, *options: str) -> list[str]:
        return [str(ROOT / "scripts" / "study"), str(self.plan), "--output", str(self.folder / out), *options]

    def study(self, out: str, *options: str) -> str:
        done = subprocess.run(self.words(out, *options), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=launch.TIMEOUT, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def rows_of(self, out: str) -> list[Path]:
        return [path for path in (self.folder / out / "runs").glob("*/steps.csv") if path.read_text().count("\n") > 2]

    def assert_same(self, out: str) -> None:
        for table in TABLES:
            found, whole = ((self.folder / name / table).read_bytes() for name in (out, "whole"))
            self.assertEqual(found, whole, table)

    def test_a_study_stopped_in_a_run_goes_on_as_the_unbroken_one(self) -> None:
        study = Launch(self.words("out", "--at-once", "1"), self.folder)
        self.addCleanup(study.end)
        study.wait_until(lambda: len(self.rows_of("out")) > 1, "steps of the second run")
        os.kill(study.process.pid, signal.SIGTERM)
        ended = study.wait()
        self.assertEqual(ended.code, 128 + signal.SIGTERM, ended.text)
        self.assertIn("the same command goes on from here", ended.text)
        said = self.study("out")
        self.assertEqual(said.count(": running"), 2)  # not the first one
        self.study("whole")
        self.assert_same("out")

    def test_a_job_array(self) -> None:
        environment = os.environ | {"PLAN": str(self.plan), "OUTPUT": str(self.folder / "out"),
                                    "STUDY": str(ROOT / "scripts" / "study")}
        tasks = [subprocess.Popen(["bash", str(SCRIPT)], env=environment | {"SLURM_ARRAY_TASK_ID": str(k)},
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for k in range(3)]
        for task in tasks:
            text, _ = task.communicate(timeout=launch.TIMEOUT)
            self.assertEqual(task.returncode, 0, text)
        self.assertNotIn(": running", self.study("out"))
        self.study("whole")
        self.assert_same("out")


if __name__ == "__main__":
    launch.main()
