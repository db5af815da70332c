#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The lines of docs/python.md as they stand there, and runs that are followed, stopped or fail."""

import os
import re
import subprocess
import sys

import launch
from launch import endless
from test_restart_script import ROOT, ScriptCase

sys.path.insert(0, str(ROOT))
import gabion  # noqa: E402

BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def soil_of(end: float) -> dict:
    """mpm.json of a column of 100 points that falls until `end` [s], in steps of 2 ms."""
    def box(high: list[float], cells: list[int]) -> dict:
        return {"box": {"low": [0, 0], "high": high, "cells": cells, "type": "quad4"}}

    material = {"law": "mohr_coulomb", "density": 2000, "young_modulus": 840e3, "poisson_ratio": 0.3,
                "friction_angle": 20, "dilation_angle": 0, "cohesion": 0}
    return {"dimension": 2, "grid": box([0.4, 0.2], [20, 10]), "gravity": [0, -9.81],
            "walls": [{"group": "left", "condition": "slip"}, {"group": "bottom", "condition": "fixed"}],
            "bodies": [{"name": "soil", "points_per_cell": 4, "mesh": box([0.1, 0.1], [5, 5]), "material": material}],
            "time": {"end": end, "dt": 2e-3, "dt_min": 1e-5}, "output": {"interval": end}}


class Page(ScriptCase):
    def test_the_lines_of_the_page_draw_the_curve(self) -> None:
        lines = BLOCK.search((ROOT / "docs" / "python.md").read_text(encoding="utf-8"))[1]
        self.assertLessEqual(len([line for line in lines.splitlines() if line and not line.startswith("import")]), 10)
        (self.folder / "configs").symlink_to(ROOT / "configs")
        environment = os.environ | {"PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
        done = subprocess.run(["/usr/bin/python3", "-c", lines], cwd=self.folder, env=environment, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=launch.TIMEOUT, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertGreater((self.folder / "front.png").stat().st_size, 5000)
        fronts = [gabion.Results(self.folder / "results" / f"python_{angle}").probes["front"] for angle in (15, 30)]
        self.assertGreater(fronts[0][-1], fronts[1][-1])  # less friction: farther


class Runs(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.write_scene({"mpm": soil_of(end=0.02)})
        self.short = gabion.Scene(self.scene)

    def test_a_run_is_followed_and_read(self) -> None:
        job = self.short.start(self.out)
        seen = list(job.follow(0.05))
        results = job.wait()
        self.assertTrue(results.completed)
        self.assertEqual(seen[-1].state.value, "completed")
        self.assertEqual((seen[-1].steps, seen[-1].share), (10, 1.0))
        times = [now.time for now in seen]
        self.assertEqual(times, sorted(times))
        self.assertIn("mpm_solver completed", job.log)
        self.assertEqual(gabion.stack(results.soil, "velocity").shape, (2, 100, 3))
        self.assertEqual(results.settings("mpm.json")["basis"], "gimp")

    def test_changes_hold_for_the_run_and_not_for_the_files(self) -> None:
        before = (self.scene / "mpm.json").read_text()
        self.short["mpm.json:/time/end"] = 0.01
        self.assertIn("valid", self.short.check())
        self.assertFalse(self.out.exists())
        self.assertEqual(self.short.run(self.out).probes["time"][-1], 0.01)
        self.assertEqual((self.scene / "mpm.json").read_text(), before)

    def test_a_run_that_fails_says_what_the_programs_said(self) -> None:
        self.short["mpm.json:/bodies/0/mesh/box/high"] = [0.5, 0.1]  # beyond the grid
        with self.assertRaisesRegex(gabion.RunError, r"out: exit code \d: .*\[mpm\] error: ") as raised:
            self.short.run(self.out)
        self.assertNotIn("\n[mpm] warning", str(raised.exception))

    def test_a_run_that_is_refused_has_failed(self) -> None:
        self.out.mkdir()
        (self.out / "notes.txt").write_text("mine")
        job = self.short.start(self.out)
        *_, last = job.follow(0.05)
        self.assertEqual((last.state.value, last.reason), ("failed", "exit code 2"))
        with self.assertRaisesRegex(gabion.RunError, "out: exit code 2: .* allowed: a new or empty folder"):
            job.wait()

    def test_what_an_earlier_run_left_is_not_taken_for_this_one(self) -> None:
        self.short.run(self.out)
        job = self.short.start(self.out)
        first = job.progress()
        job.wait()
        self.assertEqual((first.steps, first.state.value), (0, "running"))

    def test_a_run_is_stopped_in_order(self) -> None:
        self.write_scene(endless(in_contact=True))
        job = gabion.Scene(self.scene).start(self.out)
        self.addCleanup(job.stop)
        for now in job.follow(0.05):
            if now.steps >= 2:
                break
        job.stop()
        self.assertEqual(job.progress().state.value, "stopped")
        with self.assertRaisesRegex(gabion.RunError, "exit code 143"):
            job.wait()


if __name__ == "__main__":
    launch.main()
