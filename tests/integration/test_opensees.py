#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""OpenSees as the structure of a coupled run: checked alone, against fem_solver, restarted, and when it is killed.

Exit code 77, not run, where there is no openseespy (scripts/setup: tests_of_wheels).
"""

import contextlib
import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

import launch
from foreign_wall import ROOT, ForeignWall
from launch import Launch
from restart_rows import rows_without_seconds

sys.path.insert(0, str(ROOT / "tests" / "participant"))
from opensees_models import installed, line  # noqa: E402

PROGRAM = str(ROOT / "structures" / "opensees" / "opensees_structure")


class OpenSees(ForeignWall):
    def setUp(self) -> None:
        super().setUp()
        shutil.copy(ROOT / "configs" / "granular_obstacle_opensees" / "wall.py", self.scene / "model.py")

    def start_structure(self) -> Launch:
        path = self.scene / "structure.json"
        path.write_text(json.dumps({
            "model": "model.py", "interfaces": [line(nodes="AXIS", ends=[0, 4])],
            "probes": [{"name": "A", "interface": "wall", "point": [0.25, 0.05]}]}), encoding="utf-8")
        return self.launch_structure(PROGRAM, "--settings", str(path))

    def wait_for_steps(self, run: Launch, count: int) -> None:
        rows = self.out / "steps.csv"
        run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > count, f"{count} steps")

    def test_check_participant(self) -> None:
        self.pass_the_check(self.start_structure)

    def test_goes_the_way_of_the_finite_elements(self) -> None:
        """The displacements agree until A has moved a fifth of the height: then a section yields, which a beam's does
        not."""
        self.files["coupler"]["time"]["end"] = 0.012
        self.write_scene(self.files)
        self.couple(self.start_structure)
        self.assertIn("time,node,x,y,ux,uy", (self.out / "structure" / "nodes.csv").read_text())
        peak, iterations = self.result()
        expected, expected_iterations = self.result_of_finite_elements([8, 80])
        self.assertAlmostEqual(peak / expected, 1, delta=0.02)
        self.assertAlmostEqual(iterations, expected_iterations, delta=1)
        print(f"A: {peak:.6g}, {expected:.6g}; iterations {iterations:.2f}, {expected_iterations:.2f}")

    def test_a_run_goes_on_to_the_byte(self) -> None:
        def run(name: str, end: float, *options: str) -> Path:
            self.out = self.folder / name
            self.files["coupler"]["time"]["end"] = end
            self.write_scene(self.files)
            self.couple(self.start_structure, *options)
            return self.out

        whole, first = run("whole", 0.008), run("first", 0.005)
        second = run("second", 0.008, "--restart", str(first))
        rows = rows_without_seconds(whole / "probes.csv")
        after = rows_without_seconds(second / "probes.csv")
        self.assertGreater(len(after), 10)
        self.assertEqual(rows[-len(after) + 1:], after[1:])
        self.assertNotEqual(rows[-1], rows[-2])

    def test_a_killed_model_ends_the_run_with_its_name(self) -> None:
        """The model is killed in mid-step, or at once; no process is left."""
        self.files["coupler"]["time"]["end"] = 1.0
        self.write_scene(self.files)
        run = self.start(programs=("coupler", "mpm_solver"))
        structure = self.start_structure()
        self.wait_for_steps(run, 5)
        killed = time.monotonic()
        while structure.process.poll() is None:  # a trial may end by itself before the signal comes
            for pid in sorted(structure.alive().keys() - {structure.process.pid})[-1:]:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            time.sleep(0.2)
        self.assertEqual(structure.wait().code, 3, structure.text())
        self.assert_says(structure.text(), "[opensees] error: model.py: the process of ", "ended")
        ended = run.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "[cpl] error: ", 'participant "structure"', "model.py: the process of ", "ended")
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
