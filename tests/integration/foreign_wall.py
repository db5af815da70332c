# SPDX-License-Identifier: BSD-3-Clause
"""The wall of meeting() by a foreign structural code: what the tests of structures/ share."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, free_endpoint, meeting, read_table

ROOT = Path(__file__).resolve().parent.parent.parent


class ForeignWall(IntegrationCase):
    """The soil is at the wall sooner; the code is started beside coupler and soil, at `endpoint`."""

    def setUp(self) -> None:
        super().setUp()
        self.files = meeting()
        self.fem = self.files.pop("fem")
        self.files["coupler"]["time"] |= {"end": 0.004, "dt": 2e-4}
        self.files["mpm"]["bodies"][0]["mesh"]["box"].update(low=[0.163, 0], high=[0.243, 0.06])
        self.endpoint = free_endpoint()
        self.files["coupler"]["protocol"] = {"endpoint": self.endpoint}
        self.write_scene(self.files)

    def launch_structure(self, program: str, *options: str) -> Launch:
        os.environ["PYTHONPATH"] = str(ROOT / "protocol" / "python")
        started = Launch([program, "--coupler", self.endpoint, *options], self.folder)
        self.addCleanup(started.end)
        return started

    def pass_the_check(self, start_structure: Callable[[], Launch], *options: str) -> str:
        """The text of a coupler's --check-participant in which all is exact."""
        coupler = Launch([str(launch.binaries / "coupler"), str(self.scene), "--output", str(self.out),
                          "--check-participant", "structure", *options], self.folder)
        self.addCleanup(coupler.end)
        structure = start_structure()
        text = coupler.wait().text
        self.assertEqual(structure.wait().code, 0, structure.text())
        for verdict in ("FAILED", "inexact"):
            self.assertNotIn(verdict, text)
        for check in ("the same bits after reject_step ", "half of dt, rejected: the same bits again",
                      "the same steps after save, other steps and load", "the end"):
            self.assert_says(text, check, "passed")
        return text

    def couple(self, start_structure: Callable[[], Launch], *options: str) -> None:
        """A run to its end."""
        run = self.start(*options, programs=("coupler", "mpm_solver"))
        structure = start_structure()
        for each in (run, structure):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        structure.wait_none_left()

    def result(self) -> tuple[float, float]:
        """The largest displacement of A [m], and the mean iterations of accepted steps."""
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual(summary["accepted_unconverged"], 0)
        self.assertGreater(summary["steps_in_contact"], 5)
        counts = [int(row["iterations"]) for row in read_table(self.out / "steps.csv") if row["status"] == "converged"]
        way = [float(row["structure.A.ux"]) for row in read_table(self.out / "probes.csv")]
        return max(way), sum(counts) / len(counts)

    def result_of_finite_elements(self, cells: list[int]) -> tuple[float, float]:
        """`result` of the same scene with fem_solver, in place of the results so far."""
        del self.files["coupler"]["protocol"]
        self.fem["mesh"]["box"]["cells"] = cells
        self.write_scene(self.files | {"fem": self.fem})
        shutil.rmtree(self.out, ignore_errors=True)
        self.run_launch(code=0)
        expected = self.result()
        self.assertGreater(expected[0], 1e-5)
        return expected
