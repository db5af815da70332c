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
        self.write_scene({"mpm": soil_of(end=0.1)})
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

    def test_a_stopped_study_goes_on_and_equals_a_job_array(self) -> None:
        study = Launch(self.words("stopped", "--at-once", "1"), self.folder)
        self.addCleanup(study.end)
        study.wait_until(lambda: len(self.rows_of("stopped")) > 1, "steps of the second run")
        os.kill(study.process.pid, signal.SIGTERM)
        ended = study.wait()
        self.assertEqual(ended.code, 128 + signal.SIGTERM, ended.text)
        self.assertIn("the same command goes on from here", ended.text)
        self.assertEqual(self.study("stopped").count(": running"), 2)  # not the first one
        self.run_array("array")
        self.assertNotIn(": running", self.study("array"))
        for table in TABLES:
            found, whole = ((self.folder / name / table).read_bytes() for name in ("stopped", "array"))
            self.assertEqual(found, whole, table)

    def run_array(self, out: str) -> None:
        """Run an array as Slurm does: a task a run, all at the same time."""
        environment = os.environ | {"PLAN": str(self.plan), "OUTPUT": str(self.folder / out),
                                    "STUDY": str(ROOT / "scripts" / "study")}
        tasks = [subprocess.Popen(["bash", str(SCRIPT)], env=environment | {"SLURM_ARRAY_TASK_ID": str(k)},
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for k in range(3)]
        for task in tasks:
            text, _ = task.communicate(timeout=launch.TIMEOUT)
            self.assertEqual(task.returncode, 0, text)


if __name__ == "__main__":
    launch.main()
