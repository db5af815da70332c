#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The job script for batch systems, with the signals that those send: a chain of jobs is the run in one piece."""

import os
import signal
import subprocess
import unittest
from pathlib import Path

import launch
from launch import LAUNCHER, ONE_THREAD, IntegrationCase, Launch, endless
from restart_rows import rows_of_steps, rows_without_seconds

ROOT = Path(__file__).resolve().parent.parent.parent
SCRIPT = ROOT / "scripts" / "templates" / "slurm" / "gabion.sbatch"
TABLES = ("steps", "probes", "iterations")
REQUEUED = "requeue 4711"


class Batch(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.asked = self.folder / "asked"  # of scontrol
        tools = self.folder / "tools"
        tools.mkdir()
        scontrol = tools / "scontrol"
        scontrol.write_text(f'#!/bin/sh\necho "$@" >>{self.asked}\n')
        scontrol.chmod(0o755)
        self.environment = {
            **os.environ, **ONE_THREAD, "PATH": f"{tools}:{os.environ['PATH']}", "SLURM_JOB_ID": "4711",
            "SCENE": str(self.scene), "OUTPUT": str(self.folder), "BIN": str(launch.binaries), "MPM_RANKS": "1",
            "LAUNCH": " ".join(LAUNCHER.words),
        }
        self.files = endless(in_contact=True)
        self.write_scene(self.files)

    def job(self) -> Launch:
        """A job as Slurm starts it: the script, with a process group of its own."""
        before = dict(os.environ)
        os.environ.update(self.environment)
        try:
            run = Launch(["bash", str(SCRIPT)], self.folder)
        finally:
            os.environ.clear()
            os.environ.update(before)
        self.addCleanup(run.end)
        return run

    def job_in_step(self, part: int, num_steps: int) -> Launch:
        run = self.job()
        table = self.folder / f"part_{part}" / "steps.csv"
        run.wait_until(lambda: table.exists() and table.read_text().count("\n") > num_steps, f"{num_steps} steps")
        return run

    def last_job(self, part: int) -> None:
        """The end of the run is some steps after the last part now."""
        table = self.folder / f"part_{part - 1}" / "steps.csv"
        names, *rows = rows_without_seconds(table)
        self.files["coupler"]["time"]["end"] = float(rows[-1][names.index("time")]) + 0.005
        self.write_scene(self.files)
        ended = self.job().wait()
        self.assertEqual(ended.code, 0, ended.text)
        self.assert_says(ended.text, "The run is complete:", f"part_{part}")

    def assert_stopped(self, run: Launch, part: int) -> None:
        """The run stopped in order: the checkpoint is that of the last step, and the next job is asked for."""
        ended = run.wait()
        self.assertEqual(ended.code, 0, ended.text)
        run.wait_none_left()
        self.assert_says(ended.text, "Stopped by a signal")
        last = rows_without_seconds(self.folder / f"part_{part}" / "steps.csv")[-1][0]
        checkpoints = [path.name for path in (self.folder / f"part_{part}" / "checkpoints").iterdir()]
        self.assertEqual(checkpoints, [f"step_{int(last):06}"])
        self.assertEqual(self.asked.read_text().split("\n")[-2], REQUEUED)

    def rows(self, part: int, table: str, first: int, last: int) -> list[tuple[str, ...]]:
        """Rows of a part without those that a later part has computed again."""
        names, *rows = rows_without_seconds(self.folder / f"part_{part}" / f"{table}.csv")
        if table == "probes":  # a row a step; the first part has one of time 0 before them
            return rows[:last - first + 1] if part > 1 else rows[1:last + 1]
        step = names.index("step")
        return [row for row in rows if int(row[step]) <= last]

    def assert_same_rows(self, parts: int) -> None:
        self.out = self.folder / "straight"
        self.run_launch(code=0)
        tables = [rows_without_seconds(self.folder / f"part_{k}" / "steps.csv") for k in range(1, parts + 1)]
        first = [int(table[1][0]) for table in tables] + [int(tables[-1][-1][0]) + 1]
        for table in TABLES:
            found = [self.rows(k + 1, table, first[k], first[k + 1] - 1) for k in range(parts)]
            expected = rows_of_steps(self.out, table, 1, first[-1] - 1)[1:]
            self.assertEqual([row for rows in found for row in rows], expected, table)

    def test_signal_to_the_batch_shell(self) -> None:
        """--signal=B:TERM: to the shell alone; twice, in contact and after it."""
        for part, steps in ((1, 30), (2, 10)):
            run = self.job_in_step(part, steps)
            os.kill(run.process.pid, signal.SIGTERM)
            self.assert_stopped(run, part)
        self.last_job(3)
        self.assert_same_rows(3)
        self.assertEqual(self.asked.read_text(), f"{REQUEUED}\n{REQUEUED}\n")
        ended = self.job().wait()
        self.assertEqual(ended.code, 0)
        self.assertFalse((self.folder / "part_4").exists())

    def test_signal_to_the_process_group(self) -> None:
        """A terminal or kill -- -PID sends such a signal; a second one while the checkpoint is written changes
        nothing."""
        run = self.job_in_step(1, 30)
        os.killpg(run.process.pid, signal.SIGTERM)
        os.killpg(run.process.pid, signal.SIGTERM)
        self.assert_stopped(run, 1)
        self.last_job(2)
        self.assert_same_rows(2)

    def test_killed_without_warning(self) -> None:
        """A node that fails: the next job goes on from the last checkpoint."""
        self.files["coupler"]["checkpoint"] = {"steps": 4}
        self.write_scene(self.files)
        run = self.job_in_step(1, 30)
        run.end()
        self.last_job(2)
        self.assert_same_rows(2)

    def test_several_nodes(self) -> None:
        """The coupler listens on the network then: what is launched says so."""
        self.environment |= {"SLURM_JOB_NUM_NODES": "2", "LAUNCH": "echo launch"}
        ended = self.job().wait()
        self.assertEqual(ended.code, 4, ended.text)  # nothing ran
        line = next(line for line in ended.text.splitlines() if line.startswith("launch "))
        coupler, soil, structure = line.split(" : ")
        self.assertRegex(coupler, r"^launch -n 1 .*/coupler .* --coupler tcp://[\d.]+:24711$")
        self.assertNotIn("--coupler", soil + structure)

    def test_run_that_fails_is_not_repeated(self) -> None:
        del self.files["mpm"]["bodies"][0]["material"]["density"]
        self.write_scene(self.files)
        ended = self.job().wait()
        self.assertNotEqual(ended.code, 0, ended.text)
        self.assert_says(ended.text, "error", "density")
        self.assertFalse(self.asked.exists())

    def test_names_what_is_missing(self) -> None:
        done = subprocess.run(["bash", str(SCRIPT)], capture_output=True, text=True, check=False,
                              env={"PATH": os.environ["PATH"]})
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("SCENE: folder of the scene", done.stderr)


if __name__ == "__main__":
    launch.main()
