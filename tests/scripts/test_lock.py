#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scripts that write in a results folder: not two of one name, not while a run moves the folder, but beside a run."""

import fcntl
import json
import os
import unittest
from pathlib import Path

from made_up_results import write_kind
from script_case import ScriptCase

from plotting import lock
from plotting.results import ResultsError


class Lock(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.results = write_kind(self.folder / "results", "finished")
        self.write("results/.gabion_results", "coupler\n")

    def hold(self, name: str, operation: int) -> None:
        """A lock on a file in the results, as another program holds it."""
        file = os.open(self.results / name, os.O_RDWR | os.O_CREAT, 0o666)
        self.addCleanup(os.close, file)
        fcntl.flock(file, operation)

    def sign(self, name: str, program: str) -> None:
        text = {"program": program, **lock.process.this_process().to_fields(), "since": "2026-01-02 03:04:05 UTC"}
        (self.results / name).write_text(json.dumps(text), encoding="utf-8")

    def test_each_script_is_refused_while_a_run_begins(self) -> None:
        self.hold(".gabion_lock", fcntl.LOCK_EX)
        self.sign(".gabion_lock", "coupler")
        for script in ("plot", "deposit", "report"):
            done = self.python_script(script, self.results)
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"in use by coupler (pid {os.getpid()} on ", done.stderr)
            self.assertIn("since 2026-01-02 03:04:05 UTC; ", done.stderr)
            self.assertIn(str(self.results / ".gabion_lock"), done.stderr)
        self.assertFalse((self.results / "report.html").exists())

    def test_beside_a_run_under_way(self) -> None:
        self.hold(".gabion_lock", fcntl.LOCK_SH)
        self.assertEqual(self.python_script("report", self.results).returncode, 0)
        self.assertTrue((self.results / "report.html").exists())
        self.assertFalse((self.results / ".gabion_lock_report").exists())

    def test_the_same_script_twice(self) -> None:
        with lock.writing(self.results, "report"):
            done = self.python_script("report", self.results)
            self.assertEqual(done.returncode, 2)
            self.assertIn("in use by scripts/report (pid", done.stderr)
            with lock.writing(self.results, "plot"):  # another one writes other files
                pass
        self.assertEqual(self.python_script("report", self.results).returncode, 0)

    def test_a_killed_script_leaves_a_file_that_is_not_in_the_way(self) -> None:
        self.sign(".gabion_lock_report", "scripts/report")  # nobody holds it
        self.assertEqual(self.python_script("report", self.results).returncode, 0)

    def test_a_run_that_moves_the_folder_is_kept_off(self) -> None:
        with lock.writing(self.results, "plot"), (self.results / ".gabion_lock").open("r+") as file:
            with self.assertRaises(BlockingIOError):
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def test_elsewhere_nothing_is_locked(self) -> None:
        self.hold(".gabion_lock", fcntl.LOCK_EX)
        page = self.folder / "elsewhere" / "page.html"
        self.assertEqual(self.python_script("report", self.results, "--out", page).returncode, 0)
        self.assertTrue(page.exists())

    def test_a_folder_that_is_no_results_is_left_as_it_is(self) -> None:
        folder = self.folder / "letters"
        folder.mkdir()
        for script in ("plot", "deposit"):
            self.assertEqual(self.python_script(script, folder).returncode, 2)
        self.assertEqual(list(folder.iterdir()), [])

    def test_no_such_folder(self) -> None:
        with self.assertRaisesRegex(ResultsError, "no such results folder"), lock.writing(Path("/nowhere"), "plot"):
            pass


if __name__ == "__main__":
    unittest.main()
