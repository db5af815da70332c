#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A wall as matrices in a coupled run: against the wall with a mesh that they are from; restart; the checks of
participants; errors."""

import json
import shutil

import launch
from launch import IntegrationCase, meeting, read_table
from restart_rows import rows_of_steps, rows_without_seconds

END = 0.0125  # [s] of the meeting, in contact from step 18 on


def linear_meeting() -> dict[str, dict]:
    files = meeting()
    files["fem"]["material"]["law"] = "linear_elastic"
    files["coupler"]["time"]["end"] = END
    return files


class Matrices(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = linear_meeting()
        self.write_scene(self.files)

    def write_matrices(self, **changes: object) -> None:
        """The scene with its wall as matrices. `changes`: keys of "matrices"."""
        written = self.folder / "matrices"
        ended = self.run_program("fem_solver", self.scene, "--write-matrices", written, code=0)
        self.assert_says(ended.text, "written as matrices to", str(written))
        shutil.copytree(written, self.scene, dirs_exist_ok=True)
        settings = json.loads((written / "fem.json").read_text())
        settings["matrices"] |= changes
        self.write_scene({"fem": settings})

    def run_to_end(self, name: str, *options: str):
        self.out = self.folder / name
        self.run_launch(*options, code=0)
        return self.out

    def test_moves_as_the_wall_with_a_mesh(self) -> None:
        mesh = read_table(self.run_to_end("mesh") / "probes.csv")
        self.write_matrices()
        out = self.run_to_end("as_matrices")
        matrices = read_table(out / "probes.csv")
        self.assertEqual(len(matrices), len(mesh))
        peak = max(abs(float(row["structure.A.ux"])) for row in mesh)
        self.assertGreater(peak, 1e-5)
        for one, other in zip(mesh, matrices):
            self.assertEqual(one["time"], other["time"])
            self.assertLess(abs(float(one["structure.A.ux"]) - float(other["structure.A.ux"])), 1e-6 * peak)
        self.assertGreater(json.loads((out / "summary.json").read_text())["steps_in_contact"], 5)
        self.assertGreater(len(self.assert_frames_open(out / "fem", "structure")), 2)

    def test_restart_of_a_reduced_wall_gives_the_same_rows(self) -> None:
        self.write_matrices(modes=4)
        straight = self.run_to_end("straight")
        steps = rows_without_seconds(straight / "steps.csv")
        times = [float(row[steps[0].index("time")]) for row in steps[1:]]
        stop = sum(time < 0.01 + 1e-9 for time in times)
        self.assertLess(stop, len(times))
        first = self.run_to_end("first", "--set", "coupler.json:/time/end=0.01")
        second = self.run_to_end("second", "--restart", str(first))
        for table in ("steps", "probes", "iterations"):
            self.assertEqual(rows_of_steps(second, table, stop + 1, len(times), whole=True),
                             rows_of_steps(straight, table, stop + 1, len(times)), table)
        matrix = self.scene / "K.mtx"
        matrix.write_text(matrix.read_text() + "% another file\n")
        self.out = self.folder / "third"
        ended = self.run_launch("--restart", str(first), code=2)
        self.assert_says(ended.text, "fem.json: at /matrices/stiffness: found", "the contents of that file")

    def test_a_good_participant_on_two_ranks(self) -> None:
        self.write_matrices()
        ended = self.run_launch(code=0, programs=("coupler", "fem_solver"), ranks={"fem_solver": 2},
                                own={"coupler": ["--check-participant", "structure"]})
        self.assert_says(ended.text, "the same steps after save, other steps and load", "passed")
        self.assertNotIn("FAILED", ended.text)
        self.assertNotIn("inexact", ended.text)

    def test_a_broken_file(self) -> None:
        self.write_matrices()
        lines = (self.scene / "M.mtx").read_text().splitlines()
        lines[4] = lines[4].replace(" ", " x", 1)
        (self.scene / "M.mtx").write_text("\n".join(lines))
        ended = self.run_program("fem_solver", self.scene, "--check", code=2)
        self.assert_says(ended.text, "M.mtx:5: found", "finite number")


if __name__ == "__main__":
    launch.main()
