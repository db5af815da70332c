#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A step that cannot be solved: the run ends with exit code 3, its reason, and the last accepted state."""

import json

import launch
from launch import ALONE, IntegrationCase, meeting, read_table


class FailedStep(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        files = meeting()
        files["coupler"]["time"]["dt_min"] = 4e-4  # the first cut, some steps after contact, needs less
        files["coupler"]["coupling"]["max_iterations"] = 9
        self.write_scene(files)

    def test_reason_and_last_state_are_kept(self) -> None:
        ended = self.run_launch(code=3)
        steps = read_table(self.out / "steps.csv")
        last = steps[-1]
        reason = f"step {int(last['step']) + 1} at time {last['time']} s failed with dt = 0.0005 s and no smaller dt"
        self.assertEqual(last["status"], "converged")
        self.assert_says(ended.text, "[cpl] error: ", reason, "dt_min")
        self.assert_says((self.out / "coupler.log").read_text(), "[cpl] error: ", reason)
        for prefix in ("mpm", "fem"):
            self.assert_says(ended.text, f"[{prefix}] error: the coupler ended the run: {reason}")
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertIs(summary["completed"], False)
        self.assertTrue(summary["reason"].startswith(reason))
        self.assertEqual((summary["steps"], summary["end_time"]), (len(steps), float(last["time"])))
        for folder, name in (("mpm", "soil"), ("fem", "structure")):
            self.assertEqual(self.assert_frames_open(self.out / folder, name)[-1], float(last["time"]))
        rejected = [row for row in read_table(self.out / "iterations.csv") if int(row["step"]) > int(last["step"])]
        self.assertEqual(len(rejected), summary["coupling_iterations"]["rejected"])

    def test_exit_code_is_that_of_the_cause(self) -> None:
        """All programs end at the same moment, the solvers with another code; the coupler's must win every time."""
        for ranks in ({}, {}, {}, {"mpm_solver": 2}, {"fem_solver": 2}):
            with self.subTest(ranks=ranks):
                self.run_launch(code=3, ranks=ranks)


class FailedStepAlone(IntegrationCase):
    """Soil without coupler that needs more iterations than it may take as soon as it meets its wall."""

    def setUp(self) -> None:
        super().setUp()
        files = {"mpm": {**meeting()["mpm"], **ALONE}}
        files["mpm"]["time"].update(end=0.2, dt_min=4e-4)
        files["mpm"]["output"]["interval"] = 1.0  # no frame is due but the first
        files["mpm"].update(gravity=[0, 0], newton={"max_iterations": 1})
        self.write_scene(files)

    def test_reason_and_last_state_are_kept(self) -> None:
        ended = self.run_program("mpm_solver", self.scene, "--output", self.out, code=3)
        summary = json.loads((self.out / "summary.json").read_text())
        steps, probes = read_table(self.out / "steps.csv"), read_table(self.out / "probes.csv")
        self.assertIs(summary["completed"], False)
        for words in ("dt_min", "iteration limit reached", "worst grid node", "most strained material point"):
            self.assertIn(words, summary["reason"])
            self.assert_says(ended.text, "[mpm] error: ", words)
        self.assertGreater(len(steps), 0)
        self.assertEqual((summary["steps"], summary["end_time"]), (len(steps), float(steps[-1]["time"])))
        self.assertEqual(probes[-1]["time"], steps[-1]["time"])
        self.assertEqual(self.assert_frames_open(self.out / "mpm", "soil"), [0, summary["end_time"]])
        self.assertEqual(summary["solver"]["newton"]["failures"], {"iteration_limit": summary["cuts"] + 1})


if __name__ == "__main__":
    launch.main()
