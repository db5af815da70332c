#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/run with the real programs: commands that die at their start, a folder in use, Ctrl-C, what is left
behind."""

import json
import os
import signal
import sys
from unittest import mock

import launch
from launch import Launch, endless, meeting
from test_restart_script import ScriptCase


class CommandThatDies(ScriptCase):
    """A command whose participant has not met the coupler, which waits for it."""

    def failed(self, *command: str) -> str:
        files = meeting()
        files["coupler"]["participants"]["structure"]["command"] = list(command)
        del files["fem"]
        self.write_scene(files)
        text = self.run_script(self.scene, "out", code=2)
        self.assertNotIn("interrupted by signal", text)
        self.assertIn('"completed": false', (self.out / "summary.json").read_text())
        return text

    def expect(self, text: str, program: str, *words: str) -> None:
        line = (f'participant "structure" ({program}) cannot begin: its command ended with exit code', *words)
        self.assert_says(text, "[cpl] error: ", *line)
        self.assert_says((self.out / "coupler.log").read_text(), "error: ", *line)

    def test_missing_program(self) -> None:
        text = self.failed("no_such_program")
        self.expect(text, "no_such_program", "exit code 127", "no_such_program: no such program")
        self.assertIn("structure ended with exit code 127", text.splitlines())

    def test_missing_import(self) -> None:
        program = self.folder / "structure.py"
        program.write_text("print('first words')\nimport no_such_module\n")
        text = self.failed(sys.executable, str(program))
        self.expect(text, sys.executable, "exit code 1", "ModuleNotFoundError: No module named 'no_such_module'")
        self.assertIn("first words", text.splitlines())  # what it prints is shown as well


class Run(ScriptCase):
    def test_folder_in_use_is_refused_before_anything_starts(self) -> None:
        self.write_scene(endless(in_contact=True))
        self.start_and_step(2)
        text = self.run_script(self.scene, "out", code=2)
        self.assert_says(text, "[cpl] error: ", f"output folder {self.out}: in use by coupler")
        self.assertNotIn("mpirun", text)
        self.run_script(self.scene, "out", options=("--check",))  # writes nothing

    def test_interrupt_from_a_terminal_is_named(self) -> None:
        self.write_scene(endless(in_contact=True))
        run = Launch(self.command(self.scene, "out"), self.folder)
        self.addCleanup(run.end)
        rows = self.out / "steps.csv"
        run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > 2, "steps")
        os.kill(run.process.pid, signal.SIGINT)
        ended = run.wait()
        self.assertEqual(ended.code, 128 + signal.SIGINT, ended.text)
        self.assertIn("interrupted by signal 2", json.loads((self.out / "summary.json").read_text())["reason"])
        self.assertNotIn("signal 15", (self.out / "coupler.log").read_text())

    def test_refused_scenes_leave_no_files(self) -> None:
        scratch = self.folder / "scratch"
        scratch.mkdir()
        files = meeting()
        files["coupler"]["time"]["end"] = -1
        self.write_scene(files)
        with mock.patch.dict(os.environ, {"TMPDIR": str(scratch), "CDPATH": f"{self.folder}:{launch.binaries}:/"}):
            text = self.run_script(self.scene, "out", code=2)
        self.assert_says(text, "[cpl] error: ", "/time/end")
        left = [path.name for path in scratch.iterdir() if not path.name.startswith("ompi.")]  # mpirun's, for all runs
        self.assertEqual(left, [])


if __name__ == "__main__":
    launch.main()
