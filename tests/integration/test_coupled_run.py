#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The whole launch on a tiny scene: consistent results, the same twice, the same on two ranks."""

import json
import math
import shutil

import launch
from launch import IntegrationCase, meeting, read_table


class CoupledRun(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = meeting()
        self.files["coupler"]["coupling"]["max_iterations"] = 9  # several steps in contact need more, and are cut
        self.write_scene(self.files)

    def table(self, name: str) -> list[dict[str, str]]:
        return read_table(self.out / f"{name}.csv")

    def test_results_are_complete_and_consistent(self) -> None:
        ended = self.run_launch(code=0)
        self.assert_says(ended.text, "[cpl] done:")
        summary = json.loads((self.out / "summary.json").read_text())
        steps, iterations, probes = (self.table(name) for name in ("steps", "iterations", "probes"))
        self.check_steps(summary, steps)
        self.check_iterations(summary, steps, iterations)
        self.check_balance(iterations)
        self.check_probes(steps, probes)
        self.check_frames(steps)
        self.check_settings()
        self.assertIn("done", (self.out / "coupler.log").read_text().splitlines()[-1])
        self.assertFalse(list(self.out.rglob("*.part")))

    def check_steps(self, summary: dict, steps: list[dict]) -> None:
        self.assertIs(summary["completed"], True)
        self.assertEqual(summary["steps"], len(steps))
        self.assertEqual(summary["accepted_unconverged"], 0)
        self.assertEqual([int(row["step"]) for row in steps], list(range(1, len(steps) + 1)))
        time = 0.0
        for row in steps:
            time += float(row["dt"])
            self.assertAlmostEqual(float(row["time"]), time, delta=1e-15)
        self.assertEqual(float(steps[-1]["time"]), self.files["coupler"]["time"]["end"])
        statuses = [row["status"] for row in steps]
        free = statuses.index("converged")
        self.assertGreater(free, 5)  # the approach ...
        self.assertLess(free, 30)
        self.assertEqual(set(statuses[:free]), {"inactive"})
        self.assertEqual(set(statuses[free:]), {"converged"})  # ... and contact till the end
        self.assertEqual(summary["steps_in_contact"], len(steps) - free)
        self.assertEqual(sum(int(row["cuts"]) for row in steps), summary["cuts"])
        self.assertGreater(summary["cuts"], 0)  # so that rejected steps are part of this test
        self.assertTrue(all(row["skipped"] == "structure" for row in steps[1:free]))
        self.assertTrue(all(float(row["fx"]) > 0 for row in steps[free:]))  # the soil pushes the wall to +x

    def check_iterations(self, summary: dict, steps: list[dict], iterations: list[dict]) -> None:
        by_attempt: dict[tuple, list[dict]] = {}
        for row in iterations:
            by_attempt.setdefault((int(row["step"]), float(row["dt"])), []).append(row)
        for rows in by_attempt.values():
            self.assertEqual([int(row["iteration"]) for row in rows], list(range(len(rows))))
        for step in steps:
            rows = by_attempt[int(step["step"]), float(step["dt"])]
            self.assertEqual(len(rows), int(step["iterations"]))
            last = rows[-1]
            self.assertEqual(last["status"], "converged")
            self.assertEqual(last["displacement_residual"], step["displacement_residual"])
            self.assertEqual(last["structure_fx"], step["fx"])
            self.assertEqual(sum(int(row["soil_newton"]) for row in rows), int(step["soil_newton"]))
            if step["status"] == "converged":
                self.assertLessEqual(float(last["displacement_residual"]), float(last["displacement_limit"]))
                self.assertLessEqual(float(last["force_residual"]), float(last["force_limit"]))
        counts = summary["coupling_iterations"]
        self.assertEqual(counts["total"], len(iterations))
        self.assertEqual(counts["rejected"], len(iterations) - sum(int(row["iterations"]) for row in steps))
        self.assertEqual(counts["max"], max(int(row["iterations"]) for row in steps))

    def check_balance(self, iterations: list[dict]) -> None:
        """Both sides have the same resultant force and moment at every exchange."""
        lever = math.hypot(0.26, 0.05)  # [m] farthest point of the wall from the origin
        with_force = 0
        for row in iterations:
            force = math.hypot(float(row["soil_fx"]), float(row["soil_fy"]))
            with_force += force > 0
            self.assertLessEqual(float(row["mismatch_force"]), 1e-10 * force, row)
            self.assertLessEqual(float(row["mismatch_moment"]), 1e-10 * force * lever, row)
        self.assertGreater(with_force, 20)

    def check_probes(self, steps: list[dict], probes: list[dict]) -> None:
        self.assertEqual([row["time"] for row in probes], ["0"] + [row["time"] for row in steps])
        masses = {row["soil.mass"] for row in probes}
        self.assertEqual(len(masses), 1)  # to the last bit
        self.assertAlmostEqual(float(masses.pop()), 2650 * 0.08 * 0.06, delta=1e-12)
        momentum = [float(row["soil.momentum_x"]) for row in probes]
        self.assertAlmostEqual(momentum[0], 0.5 * 2650 * 0.08 * 0.06, delta=1e-12)
        self.assertLess(momentum[-1], 0.9999 * momentum[0])
        # The forces are those at the ends of the steps: 6 % from the integral while contact builds up.
        impulse = sum(float(row["fx"]) * float(row["dt"]) for row in steps)
        self.assertAlmostEqual(momentum[0] - momentum[-1], impulse, delta=0.15 * impulse)
        self.assertGreater(max(float(row["structure.A.ux"]) for row in probes), 1e-5)

    def check_frames(self, steps: list[dict]) -> None:
        interval = self.files["coupler"]["output"]["interval"]
        expected, multiple = [0.0], 1
        for time in (float(row["time"]) for row in steps):
            if time >= multiple * interval * (1 - 1e-9):
                expected.append(time)
                multiple = math.floor(time / interval * (1 + 1e-9)) + 1
        for folder, name in (("mpm", "soil"), ("fem", "structure")):
            self.assertEqual(self.assert_frames_open(self.out / folder, name), expected)
            self.assertEqual(len(list((self.out / folder).glob(f"{name}_*.h5"))), len(expected))

    def check_settings(self) -> None:
        resolved = json.loads((self.out / "resolved_config.json").read_text())["coupler.json"]
        time = self.files["coupler"]["time"]
        self.assertEqual(resolved["time"], {**time, "dt_max": time["dt"]})
        self.assertEqual(resolved["coupling"]["acceleration"]["method"], "mvqn")  # a default

    def test_two_runs_are_equal_to_the_bit(self) -> None:
        self.run_launch(code=0)
        first = {name: self.table(name) for name in ("steps", "iterations", "probes")}
        shutil.rmtree(self.out)
        self.run_launch(code=0)
        for name, rows in first.items():
            again = self.table(name)
            clocks = [column for column in rows[0] if column.endswith("_seconds")]
            self.assertEqual(list(rows[0])[len(rows[0]) - len(clocks):], clocks)  # they stand last
            for row in rows + again:
                for column in clocks:
                    del row[column]
            self.assertEqual(rows, again)

    def test_two_ranks_agree_with_one(self) -> None:
        """On two ranks sums have another order, and the structure's LU is another one (relative 1e-16 each); 13
        quasi-Newton iterations and two steps amplify that to 4e-11 of a column's largest value."""
        self.files["coupler"]["time"]["end"] = 0.01  # 3 steps in contact
        self.files["coupler"]["coupling"]["max_iterations"] = 20  # no cut that could hide a jump
        self.files["mpm"]["newton"] = {"residual_tolerance": 1e-8}  # linear systems are solved otherwise, too
        self.write_scene(self.files)
        self.run_launch(code=0)
        probes, steps = self.table("probes"), self.table("steps")
        for program in ("mpm_solver", "fem_solver"):
            with self.subTest(program):
                self.run_launch(code=0, ranks={program: 2})
                self.assert_close(probes, self.table("probes"))
                again = self.table("steps")
                for column in ("status", "iterations", "cuts"):
                    self.assertEqual([row[column] for row in steps], [row[column] for row in again])

    def test_parallel_scheme_comes_through_the_approach(self) -> None:
        """Facets see soil that is near: contact is possible in steps before the first force."""
        self.files["coupler"]["coupling"].update(scheme="parallel_implicit", max_iterations=20)
        self.files["coupler"]["time"].update(dt=2e-4, end=0.02)
        for key in ("method", "penalty"):
            del self.files["mpm"]["interfaces"][0][key]
        self.write_scene(self.files)
        self.run_launch(code=0)
        steps = self.table("steps")
        near = [row for row in steps if row["status"] == "converged" and float(row["fx"]) == float(row["fy"]) == 0]
        self.assertGreater(len(near), 3)
        self.assertEqual({(row["iterations"], row["skipped"]) for row in near}, {("2", "none")})
        self.assertGreater(float(steps[-1]["fx"]), 0)

    def assert_close(self, one: list[dict], two: list[dict]) -> None:
        self.assertEqual(len(one), len(two))
        for column in one[0]:
            # The remainder of a balance is compared by the size of its terms.
            terms = {"momentum_error": "soil.momentum_x", "soil.momentum_y": "soil.momentum_x",
                     "energy_balance": "soil.kinetic_energy",
                     "created_energy": "soil.kinetic_energy", "transfer_loss": "soil.kinetic_energy",
                     "time_damping": "soil.kinetic_energy", "wall_loss": "soil.kinetic_energy",
                     "quadrature_loss": "soil.kinetic_energy"}
            sized_by = next((by for name, by in terms.items() if name in column), column)
            scale = max(abs(float(row[sized_by])) for row in one)
            difference = max(abs(float(a[column]) - float(b[column])) for a, b in zip(one, two))
            self.assertLessEqual(difference, 1e-9 * scale, column)


if __name__ == "__main__":
    launch.main()
