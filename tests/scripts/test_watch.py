# SPDX-License-Identifier: BSD-3-Clause
"""scripts/watch: what it says of a run under way, done or failed."""

import json
import os
import unittest

from made_up_results import KINDS, pid_of_the_dead, write_kind
from script_case import ScriptCase

CONFIG = json.dumps({"coupler.json": {"time": {"end": 0.5}}})
STEPS = """step,time,dt,iterations,cuts,soil.busy_seconds,soil.message_seconds,soil.waiting_seconds,wall_seconds
1,0.1,0.1,2,0,0.6,0.1,0.3,1
2,0.2,0.1,4,1,0.8,0,0.2,1
"""
ITERATIONS = """step,iteration,status,displacement_residual,displacement_limit,force_residual,force_limit,omega,columns
2,0,going_on,1e-3,1e-5,,1e-2,0.5,0
2,1,converged,1e-6,1e-5,5e-3,1e-2,0,1
3,0,going_on,2e-4,1e-5,,1e-2,0,1
"""


class WatchTest(ScriptCase):
    def show(self) -> tuple[int, str]:
        shown = self.python_script("watch", self.folder, "--once")
        return shown.returncode, shown.stdout + shown.stderr

    def test_run_under_way(self) -> None:
        self.write("resolved_config.json", CONFIG)
        self.write("steps.csv", STEPS + "3,0.3,0.1,7")  # a row that is being written
        self.write("iterations.csv", ITERATIONS)
        code, text = self.show()
        self.assertEqual(code, 0)
        self.assertIn("running", text)
        self.assertIn("step 2   0.2 s   dt 0.1 s   cuts 1", text)
        self.assertIn("40 % of 0.5 s   about 3 s left", text)
        self.assertIn("step 3, residual by limit", text)
        self.assertRegex(text, r"(?m)^  0 +20 +- +0 +1   going_on +▪▪▪▪▪$")
        self.assertNotIn("converged ", text.split("status")[1])  # of the step before
        self.assertIn("last 2 steps, at most 4:  ▄█", text)
        self.assertIn("1e+03 ms a step", text)
        self.assertRegex(text, r"soil: +70 % computing, +5 % messages, +25 % waiting")

    def test_durations(self) -> None:
        from plotting.words import duration  # noqa: PLC0415
        for seconds, text in ((0.2, "0 s"), (100, "100 s"), (119.6, "2 min 0 s"), (150.2, "2 min 30 s"),
                              (3599.4, "59 min 59 s"), (3599.6, "1.0 h"), (5400, "1.5 h"), (400000, "5 days")):
            self.assertEqual(duration(seconds), text)

    def test_rows_are_read_once_and_only_when_complete(self) -> None:
        from plotting.live import Tail  # noqa: PLC0415
        path = self.write("t.csv", "a,b\n1,2\n3,")
        tail = Tail(path)
        self.assertEqual(tail.rows(), [{"a": "1", "b": "2"}])
        self.assertEqual(tail.rows(), [])
        with path.open("a", encoding="utf-8") as file:
            file.write("4\n5,6\n")
        self.assertEqual(tail.rows(), [{"a": "3", "b": "4"}, {"a": "5", "b": "6"}])

    def test_end_of_a_run(self) -> None:
        self.write("steps.csv", STEPS)
        self.write("summary.json", '{"completed": true}')
        self.assertIn("completed", self.show()[1])
        finished = self.python_script("watch", self.folder)
        self.assertEqual(finished.returncode, 0)
        self.write("summary.json", '{"completed": false, "reason": "dt below dt_min"}')
        failed = self.python_script("watch", self.folder)
        self.assertEqual(failed.returncode, 1)
        self.assertIn("Failed after 2 steps to t = 0.2 s: dt below dt_min.", failed.stdout)

    def write_owner(self, **changes: object) -> None:
        """Signature of the run, as the programs write it; without changes of this process."""
        from plotting.lock import process  # noqa: PLC0415
        self.write(".gabion_results", "mpm_solver\n")
        self.write(".gabion_lock", json.dumps({"program": "mpm_solver", "since": "2026-01-02 03:04:05 UTC",
                                               **process.this_process().to_fields(), **changes}))

    def test_ends_when_the_process_is_gone(self) -> None:
        """There is neither a summary nor a coupler's log; the run is old or new, its process number given away or
        not."""
        self.write("steps.csv", STEPS)
        for changes in ({"pid": pid_of_the_dead()}, {"start_time": 1}):
            self.write_owner(**changes)
            killed = self.python_script("watch", self.folder)
            self.assertEqual(killed.returncode, 1)
            self.assertIn("Killed: 2 steps to t = 0.2 s, no summary.json", killed.stdout)

    def test_a_long_step_is_not_an_end(self) -> None:
        rows = self.write("steps.csv", STEPS)
        self.write_owner()
        os.utime(rows, (0, 0))
        code, text = self.show()
        self.assertEqual(code, 0)
        self.assertIn("running, no new row for", text)
        self.write_owner(host="elsewhere/boot/pid:[1]")  # nobody can be asked
        self.assertIn("silent", self.show()[1])

    def test_a_run_that_ended_without_summary(self) -> None:
        """The run could not begin: its lock is cleared, the log says why."""
        self.write_owner()
        self.write(".gabion_lock", "")
        self.write("coupler.log", "2026-01-02 03:04:05.678 [cpl] error: participants did not connect\n")
        failed = self.python_script("watch", self.folder)
        self.assertEqual(failed.returncode, 1)
        self.assertIn("Failed after 0 steps to t = 0 s: participants did not connect.", failed.stdout)

    def test_words_of_the_verdict(self) -> None:
        """The sentences of the page of scripts/report, one after the other, a mark in front of each."""
        from plotting.live import Run  # noqa: PLC0415
        from plotting.terminal import MARKS, words  # noqa: PLC0415
        from plotting.verdict import verdict  # noqa: PLC0415
        for kind in KINDS:
            run = Run(write_kind(self.folder / kind, kind))
            run.read_on()
            lines = words(run)
            self.assertLessEqual(max(map(len, lines)), 100)
            self.assertEqual(" ".join(line.strip() for line in lines),
                             " ".join(f"{MARKS[each.kind]} {each.text}" for each in verdict(run)))
            shown = self.python_script("watch", self.folder / kind, "--once").stdout
            self.assertIn("\n".join(lines), shown)

    def test_nothing_there(self) -> None:
        for name in ("", "notes.txt"):  # a folder of somebody else
            if name:
                self.write(name, "mine")
            for options in ((), ("--once",)):
                empty = self.python_script("watch", self.folder, *options)
                self.assertEqual((empty.returncode, empty.stdout), (2, ""))
                self.assertIn("nothing of a run here", empty.stderr)
        self.write_owner()  # a run has just made it
        self.assertEqual(self.show()[0], 0)
        missing = self.python_script("watch", self.folder / "none", "--once")
        self.assertEqual(missing.returncode, 2)
        self.assertIn("no such results folder", missing.stderr)


if __name__ == "__main__":
    unittest.main()
