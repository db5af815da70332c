#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The folder of results: foreign files are never touched, failed writes are errors."""

import json
import resource
import subprocess
from pathlib import Path

import launch
from launch import Ended, IntegrationCase, endless, meeting, read_table

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


class OutputFolder(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.write_scene(meeting())

    def test_foreign_files_are_refused(self) -> None:
        self.out.mkdir()
        (self.out / "thesis.txt").write_text("mine")
        ended = self.run_launch(code=2)
        self.assert_says(ended.text, "[cpl] error: ", f"output folder {self.out}", "not Gabion results",
                         "allowed: a new or empty folder")
        self.assertEqual([path.name for path in self.out.iterdir()], ["thesis.txt"])
        self.assertEqual((self.out / "thesis.txt").read_text(), "mine")

    def test_earlier_results_are_kept_once(self) -> None:
        short = ("--set", "coupler.json:/time/end=0.001")
        self.run_launch(*short, code=0)
        first = (self.out / "steps.csv").read_text()
        ended = self.run_launch(*short, code=0)
        self.assert_says(ended.text, "earlier results moved to", "out.previous")
        self.assertEqual((self.folder / "out.previous" / "steps.csv").read_text(), first)
        self.assertEqual(len(read_table(self.out / "steps.csv")), 2)

    def test_a_file_in_place_of_the_folder(self) -> None:
        self.out.write_text("mine")
        ended = self.run_launch(code=2)
        self.assert_says(ended.text, "[cpl] error: ", f"output folder {self.out}", "is not a folder")
        self.assertEqual(self.out.read_text(), "mine")

    def test_nothing_is_kept_of_what_programs_and_scripts_wrote(self) -> None:
        """Only a file of the user's is kept, when the results that it was added to are replaced."""
        short = ("--set", "coupler.json:/time/end=0.001", "--set", 'coupler.json:/checkpoint={"steps": 1}')
        kept = self.folder / "out.kept"
        self.run_launch(*short, code=0)
        for script in ("plot", "report", "deposit"):
            command = [str(SCRIPTS / script), str(self.out), *(["--animate"] if script == "plot" else [])]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(list(self.out.glob("plots/*.png")) and list(self.out.glob("deposit/*")))
        self.run_launch(*short, code=0)
        self.run_launch(*short, code=0)
        self.assertFalse(kept.exists(), [str(path) for path in kept.rglob("*")])
        (self.out / "notes.txt").write_text("mine")
        self.run_launch(*short, code=0)
        self.assertTrue((self.folder / "out.previous" / "notes.txt").exists())
        ended = self.run_launch(*short, code=0)
        self.assert_says(ended.text, "have not written are kept in", str(kept))
        self.assertEqual([path.name for path in kept.iterdir()], ["notes.txt"])
        self.assertFalse((self.folder / "out.previous" / "notes.txt").exists())


class InUse(IntegrationCase):
    """A second run into one folder, while the first one lives and after it was killed."""

    def test_second_coupled_run(self) -> None:
        self.write_scene(endless(in_contact=True))
        run = self.start_and_step()
        pids = {name: pid for pid, name in run.alive().items()}
        ended = self.run_launch(code=2)
        self.assert_says(ended.text, "[cpl] error: ", f"output folder {self.out}: in use by coupler",
                         f"(pid {pids['coupler']} on ", f"{self.out}/.gabion_lock")
        self.assertFalse((self.folder / "out.previous").exists())
        for program, folder in (("coupler", "."), ("mpm_solver", "mpm"), ("fem_solver", "fem")):
            signed = json.loads((self.out / folder / ".gabion_lock").read_text())
            self.assertEqual((signed["program"], signed["pid"]), (program, pids[program]))
        rows = len(read_table(self.out / "steps.csv"))
        run.wait_until(lambda: (self.out / "steps.csv").read_text().count("\n") > rows + 2, "more steps")

        run.end()  # by SIGKILL
        run.wait_none_left()
        self.assertIn('"coupler"', (self.out / ".gabion_lock").read_text())
        self.run_launch("--set", "coupler.json:/time/end=0.001", code=0)
        self.assertGreater(len(read_table(self.folder / "out.previous" / "steps.csv")), rows)
        self.assertEqual((self.out / ".gabion_lock").read_text(), "")
        self.assertEqual((self.out / "mpm" / ".gabion_lock").read_text(), "")

    def test_solvers_that_run_alone(self) -> None:
        """Solvers are started by hand, without scripts/run; the second one on two ranks."""
        files = endless(in_contact=False)
        self.write_scene({"mpm": {**files["mpm"], **launch.ALONE, "interfaces": []}})
        options = ("--set", "mpm.json:/time/end=1000")
        run = self.start(*options, programs=("mpm_solver",))
        rows = self.out / "steps.csv"
        run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > 2, "steps")
        for ranks in (1, 2):
            ended = self.run_launch(*options, code=2, programs=("mpm_solver",), ranks={"mpm_solver": ranks})
            self.assert_says(ended.text, "[mpm] error: ", "in use by mpm_solver", f"{self.out}/.gabion_lock")
        self.assertIsNone(run.process.poll())


class NoSpace(IntegrationCase):
    """A limit on the size of files stands in for a full disk: writes of a run under way fail with EFBIG instead
    of ENOSPC. SIGXFSZ is ignored, so that the program sees the failed write."""

    def start_and_limit(self, program: str, size: int) -> Ended:
        """Start a run in which `program`, from some step on, cannot write a file beyond `size` bytes."""
        self.write_scene(endless(in_contact=True))
        run = self.start_and_step(ignored_signal="XFSZ")
        resource.prlimit(run.pid_of(program), resource.RLIMIT_FSIZE, (size, size))
        ended = run.wait()
        self.assertEqual(ended.code, 4, ended.text)
        run.wait_none_left()
        self.assertGreater(len(read_table(self.out / "steps.csv")), 48)
        return ended

    def test_row_that_does_not_fit(self) -> None:
        ended = self.start_and_limit("coupler", 1_000_000)
        words = ("error: ", f"{self.out}/iterations.csv: row could not be written (disk full?)")
        self.assert_says(ended.text, "[cpl]", *words)
        self.assert_says((self.out / "coupler.log").read_text(), *words)
        # Both are told; mpirun, which the coupler's exit wakes, may end one of them before it has said so.
        self.assert_says(ended.text, "] error: the coupler ended the run:", "iterations.csv")
        self.assertIn('"completed": false', (self.out / "summary.json").read_text())

    def check_frame(self, program: str, participant: str, prefix: str, name: str) -> None:
        ended = self.start_and_limit(program, 1000)
        frame = f"{self.out}/{prefix}/"
        self.assert_says(ended.text, f"[{prefix}] error: ", frame)
        self.assert_says((self.out / "coupler.log").read_text(), "[cpl] error: ", f'participant "{participant}"', frame)
        times = self.assert_frames_open(self.out / prefix, name)  # without the one that failed
        self.assertGreaterEqual(len(times), 2)

    def test_frame_of_the_soil_that_does_not_fit(self) -> None:
        self.check_frame("mpm_solver", "soil", "mpm", "soil")

    def test_frame_of_the_structure_that_does_not_fit(self) -> None:
        self.check_frame("fem_solver", "structure", "fem", "structure")


if __name__ == "__main__":
    launch.main()
