#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""OpenSees as the structure of a coupled run: checked alone, against fem_solver, restarted, and when it is killed.

Exit code 77, not run, where there is no openseespy (scripts/setup: tests_of_wheels).
"""

import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, free_endpoint, meeting, read_table
from restart_rows import rows_without_seconds

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "participant"))
from opensees_models import installed, line  # noqa: E402

PROGRAM = str(ROOT / "structures" / "opensees" / "opensees_structure")


class OpenSeesCase(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = meeting()
        self.fem = self.files.pop("fem")
        self.files["coupler"]["time"] |= {"end": 0.004, "dt": 2e-4}
        self.files["mpm"]["bodies"][0]["mesh"]["box"].update(low=[0.163, 0], high=[0.243, 0.06])  # sooner there
        self.endpoint = free_endpoint()
        self.files["coupler"]["protocol"] = {"endpoint": self.endpoint}
        self.write_scene(self.files)
        shutil.copy(ROOT / "configs" / "granular_obstacle_opensees" / "wall.py", self.scene / "model.py")

    def start_structure(self) -> Launch:
        path = self.scene / "structure.json"
        path.write_text(json.dumps({
            "model": "model.py", "interfaces": [line(nodes="AXIS", ends=[0, 4])],
            "probes": [{"name": "A", "interface": "wall", "point": [0.25, 0.05]}]}), encoding="utf-8")
        os.environ["PYTHONPATH"] = str(ROOT / "protocol" / "python")
        started = Launch([PROGRAM, "--coupler", self.endpoint, "--settings", str(path)], self.folder)
        self.addCleanup(started.end)
        return started

    def wait_for_steps(self, run: Launch, count: int) -> None:
        rows = self.out / "steps.csv"
        run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > count, f"{count} steps")

    def finish(self, *runs: Launch) -> None:
        for each in runs:
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)

    def way(self) -> list[float]:
        """Of A [m]; with contact."""
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual(summary["accepted_unconverged"], 0)
        self.assertGreater(summary["steps_in_contact"], 5)
        return [float(row["structure.A.ux"]) for row in read_table(self.out / "probes.csv")]

    def iterations(self) -> float:
        rows = [row for row in read_table(self.out / "steps.csv") if row["status"] == "converged"]
        return sum(int(row["iterations"]) for row in rows) / len(rows)


class OpenSees(OpenSeesCase):
    def test_check_participant(self) -> None:
        coupler = Launch([str(launch.binaries / "coupler"), str(self.scene), "--output", str(self.out),
                          "--check-participant", "structure"], self.folder)
        self.addCleanup(coupler.end)
        structure = self.start_structure()
        text = coupler.wait().text
        self.assertEqual(structure.wait().code, 0, structure.text())
        self.assertNotIn("FAILED", text)
        self.assertNotIn("inexact", text)
        for check in ("the same bits after reject_step ", "half of dt, rejected: the same bits again",
                      "the same steps after save, other steps and load", "the end"):
            self.assert_says(text, check, "passed")

    def test_goes_the_way_of_the_finite_elements(self) -> None:
        """To the first peak: in the blow itself a section gives way, which a beam's does not."""
        self.files["coupler"]["time"]["end"] = 0.03
        self.write_scene(self.files)
        run = self.start(programs=("coupler", "mpm_solver"))
        structure = self.start_structure()
        self.finish(run, structure)
        structure.wait_none_left()
        self.assertIn("time,node,x,y,ux,uy", (self.out / "structure" / "nodes.csv").read_text())
        peak, iterations = max(self.way()), self.iterations()
        del self.files["coupler"]["protocol"]
        self.fem["mesh"]["box"]["cells"] = [8, 80]
        self.write_scene(self.files | {"fem": self.fem})
        shutil.rmtree(self.out)
        self.run_launch(code=0)
        expected, expected_iterations = max(self.way()), self.iterations()
        self.assertGreater(expected, 1e-5)
        self.assertAlmostEqual(peak / expected, 1, delta=0.02)
        self.assertAlmostEqual(iterations, expected_iterations, delta=1)
        print(f"A: {peak:.6g}, {expected:.6g}; iterations {iterations:.2f}, {expected_iterations:.2f}")

    def test_a_run_goes_on_to_the_byte(self) -> None:
        def run(name: str, end: float, *options: str) -> Path:
            self.out = self.folder / name
            self.files["coupler"]["time"]["end"] = end
            self.write_scene(self.files)
            self.finish(self.start(*options, programs=("coupler", "mpm_solver")), self.start_structure())
            return self.out

        whole, first = run("whole", 0.008), run("first", 0.005)
        second = run("second", 0.008, "--restart", str(first))
        rows = rows_without_seconds(whole / "probes.csv")
        after = rows_without_seconds(second / "probes.csv")
        self.assertGreater(len(after), 10)
        self.assertEqual(rows[-len(after) + 1:], after[1:])
        self.assertNotEqual(rows[-1], rows[-2])

    def test_a_killed_model_ends_the_run_with_its_name(self) -> None:
        """In mid-step, and at once; no process is left."""
        self.files["coupler"]["time"]["end"] = 1.0
        self.write_scene(self.files)
        run = self.start(programs=("coupler", "mpm_solver"))
        structure = self.start_structure()
        self.wait_for_steps(run, 5)
        killed = time.monotonic()
        os.kill(max(structure.alive().keys() - {structure.process.pid}), signal.SIGKILL)
        self.assertEqual(structure.wait().code, 3, structure.text())
        self.assert_says(structure.text(), "[opensees] error: model.py: the process of ", "was ended by SIGKILL")
        ended = run.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "[cpl] error: ", 'participant "structure"', "was ended by SIGKILL")
        print(f"the run ended {time.monotonic() - killed:.2f} s after its model")
        run.wait_none_left()
        structure.wait_none_left()

    def test_a_killed_program_leaves_no_model(self) -> None:
        run = self.start(programs=("coupler", "mpm_solver"))
        structure = self.start_structure()
        self.wait_for_steps(run, 3)
        os.kill(structure.process.pid, signal.SIGKILL)
        ended = run.wait()
        self.assert_says(ended.text, "[cpl] error: ", 'participant "structure"')
        structure.wait_none_left()


if __name__ == "__main__":
    if not installed():
        print("no openseespy: not run")
        sys.exit(77)
    launch.main()
