#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plays restart_table.py: each scene runs in one piece, and in several, each of which goes on from the checkpoint of
the one before. Every row must be the same, byte for byte but for wall times."""

import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import launch
import restart_table
from launch import IntegrationCase
from restart_rows import rows_of_steps, rows_without_seconds

WORKERS = 4  # cases at once: half of the time goes into starting and ending programs


class Player(IntegrationCase):
    """One case, in a folder of its own."""

    def run_part(self, name: str, programs: tuple[str, ...], *options: str) -> Path:
        """One part of the run; its folder of results."""
        self.out = self.folder / name
        if len(programs) == 1:
            self.run_program(programs[0], self.scene, "--output", self.out, *options, code=0)
        else:
            self.run_launch(*options, code=0, programs=programs)
        return self.out

    def play(self, case: restart_table.Case) -> None:
        files = case.scene()
        owner = "coupler" if "coupler" in files else next(iter(files))  # of time
        programs = ("coupler", "mpm_solver", "fem_solver") if owner == "coupler" else (f"{owner}_solver",)
        self.write_scene(files)
        straight = self.run_part("straight", programs)
        steps = rows_without_seconds(straight / "steps.csv")
        times = [float(row[steps[0].index("time")]) for row in steps[1:]]
        self.require_shown(straight, case, times)
        begin, options = 1, []
        for end in (*case.stops, times[-1]):
            stop = sum(time < end + 1e-9 for time in times)  # accepted steps until then
            self.assertGreaterEqual(stop, begin, "the run is too short")
            part = self.run_part(f"to_{stop}", programs, *options, "--set", f"{owner}.json:/time/end={end}")
            for table in ("steps", "probes", *(["iterations"] if owner == "coupler" else [])):
                self.assertEqual(rows_of_steps(part, table, begin, stop, whole=begin > 1),
                                 rows_of_steps(straight, table, begin, stop), f"{table}, steps {begin} to {stop}")
            begin, options = stop + 1, ["--restart", str(part)]

    def require_shown(self, straight: Path, case: restart_table.Case, times: list[float]) -> None:
        column, least = case.shows
        num_rows = sum(time < case.stops[-1] + 1e-9 for time in times)
        found = []
        for table in ("steps", "probes"):
            names, *rows = rows_without_seconds(straight / f"{table}.csv")
            found += [float(row[names.index(name)]) for name in names if name.endswith(column)
                      for row in rows[:num_rows] if row[names.index(name)]]
        self.assertTrue(found, f"{case.name}: no column {column}")
        self.assertGreaterEqual(max(found), least, f"{case.name}: {column}")


class Table(unittest.TestCase):
    def test_every_case(self) -> None:
        with ThreadPoolExecutor(WORKERS) as pool:
            problems = list(pool.map(lambda case: (player := Player()).problem_of(lambda: player.play(case)),
                                     restart_table.CASES))
        for case, problem in zip(restart_table.CASES, problems):
            with self.subTest(case.name):
                self.assertEqual(problem, "")


if __name__ == "__main__":
    launch.main()
