#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""CalculiX as the structure of a coupled run: checked alone, against fem_solver, and when ccx is killed."""

import json
import os
import shutil
import signal
import sys

import launch
from foreign_wall import ROOT, ForeignWall
from launch import IntegrationCase, Launch, free_endpoint, read_table

PROGRAM = str(ROOT / "structures" / "calculix" / "calculix_structure")
ACROSS, UP = 4, 20  # halves of elements of the wall


def wall() -> str:
    """The wall of meeting(), as an input deck of quadratic elements. Node of (i, j): 1 + i + (ACROSS + 1) j."""
    def node(i: int, j: int) -> int:
        return 1 + i + (ACROSS + 1) * j

    nodes = [f"{node(i, j)}, {0.25 + 0.01 * i / ACROSS}, {0.05 * j / UP}"
             for j in range(UP + 1) for i in range(ACROSS + 1) if i % 2 == 0 or j % 2 == 0]
    shape = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    places = [(i, j) for j in range(0, UP, 2) for i in range(0, ACROSS, 2)]
    elements = [f"{number}, " + ", ".join(str(node(i + x, j + y)) for x, y in shape)
                for number, (i, j) in enumerate(places, 1)]
    return "\n".join([
        "*NODE", *nodes, "*ELEMENT, TYPE=CPE8, ELSET=WALL", *elements, "*NSET, NSET=FOOT, GENERATE", f"1, {ACROSS + 1}",
        "*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, NEO HOOKE", "2.5e5, 6e-6", "*DENSITY", "1100",
        "*SOLID SECTION, ELSET=WALL, MATERIAL=RUBBER", "*BOUNDARY", "FOOT, 1, 2",
        "*STEP, NLGEOM", "*STATIC", "*DLOAD", "WALL, GRAV, 9.81, 0, -1, 0", "*END STEP", ""])


class Calculix(ForeignWall):
    def setUp(self) -> None:
        super().setUp()
        (self.scene / "wall.inp").write_text(wall(), encoding="utf-8")

    def start_structure(self, **settings) -> Launch:
        path = self.scene / "structure.json"
        path.write_text(json.dumps({
            "deck": "wall.inp", "interfaces": [{"name": "wall", "element_set": "WALL"}],
            "probes": [{"name": "A", "node": 1 + (ACROSS + 1) * UP}]} | settings), encoding="utf-8")
        return self.launch_structure(PROGRAM, "--settings", str(path))

    def test_check_participant(self) -> None:
        self.pass_the_check(self.start_structure)

    def test_goes_the_way_of_the_finite_elements(self) -> None:
        self.couple(self.start_structure)
        frames = read_table(self.out / "structure" / "frames.csv")
        self.assertGreater((self.out / "structure" / frames[-1]["file"]).stat().st_size, 10000)
        peak, iterations = self.result()
        expected, expected_iterations = self.result_of_finite_elements([4, 40])
        self.assertAlmostEqual(peak / expected, 1, delta=0.02)
        self.assertAlmostEqual(iterations, expected_iterations, delta=1)
        print(f"A: {peak:.6g}, {expected:.6g}; iterations {iterations:.2f}, {expected_iterations:.2f}")

    def test_a_killed_ccx_ends_the_run_with_its_name(self) -> None:
        program = self.folder / "mortal_ccx"
        program.write_text(f"#!/bin/sh\necho run >> {self.folder}/runs\n[ $(wc -l < {self.folder}/runs) -lt 8 ] || "
                           f"kill -{signal.SIGKILL.value} $$\nexec ccx \"$@\"\n")
        program.chmod(0o755)
        run = self.start(programs=("coupler", "mpm_solver"))
        structure = self.start_structure(program=str(program))
        self.assertEqual(structure.wait().code, 3, structure.text())
        self.assert_says(structure.text(), "[calculix] error: ccx was ended by SIGKILL")
        print(f"ccx killed: all programs gone {run.wait_programs_gone():.2f} s after the structure")
        ended = run.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "[cpl] error: ", 'participant "structure"', "ccx was ended by SIGKILL")
        run.wait_none_left()
        structure.wait_none_left()


class Barrier(IntegrationCase):
    """configs/plate_barrier, its soil already at the plate: shells and beams of steel that yields, in 3D."""

    STEPS, DT = 4, 1e-3

    def setUp(self) -> None:
        super().setUp()
        shutil.copytree(ROOT / "configs" / "plate_barrier", self.scene)
        files = {name: json.loads((self.scene / f"{name}.json").read_text())
                 for name in ("coupler", "mpm", "structure")}
        self.endpoint = free_endpoint()
        files["coupler"] |= {"protocol": {"endpoint": self.endpoint}, "output": {"interval": 2 * self.DT},
                             "time": {"end": self.STEPS * self.DT, "dt": self.DT, "dt_min": 1e-6}}
        body = files["mpm"]["bodies"][0]
        body["mesh"]["box"].update(low=[0.4, 0, 0], high=[1.0, 0.8, 0.4])
        body["velocity"] = [2.0, 0, 0]
        files["structure"]["probes"] = [{"name": "left", "node": 90}, {"name": "right", "node": 98}]  # y = 0.2, 0.6
        self.write_scene(files)

    def test_first_steps_in_contact(self) -> None:
        run = self.start(programs=("coupler", "mpm_solver"))
        os.environ["PYTHONPATH"] = str(ROOT / "protocol" / "python")
        structure = Launch([PROGRAM, "--coupler", self.endpoint, "--settings", str(self.scene / "structure.json")],
                           self.folder)
        self.addCleanup(structure.end)
        for each in (run, structure):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        steps = read_table(self.out / "steps.csv")
        self.assertEqual([row["status"] for row in steps], ["converged"] * self.STEPS)
        exchanged = sum(abs(float(row["soil_work"])) for row in steps)
        self.assertGreater(exchanged, 0.1)  # [J]
        self.assertLess(abs(float(steps[-1]["work_sum"])), 1e-3 * exchanged)
        last = read_table(self.out / "probes.csv")[-1]
        left, right = float(last["structure.left.ux"]), float(last["structure.right.ux"])
        self.assertGreater(left, 1e-5)
        self.assertAlmostEqual(left / right, 1, delta=0.05)  # the scene is symmetric, the soil's yielding nearly so
        rows = read_table(self.out / "structure" / "reactions.csv")
        self.assertEqual([row["node"] for row in rows], ["5", "13"] * 2)
        self.assertTrue(all(float(row["fx"]) < -1 for row in rows[-2:]), rows)  # [N], uphill


if __name__ == "__main__":
    if shutil.which("ccx") is None:  # scripts/setup: tests_of_lacking
        print("ccx of CalculiX is not installed: not run")
        sys.exit(77)
    launch.main()
