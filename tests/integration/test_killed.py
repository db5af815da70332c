#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Programs that are killed or stopped in mid-run take the run down at once, named; what was written stays."""

import json
import os
import signal
import time
from pathlib import Path

import launch
from launch import PROGRAMS, Ended, IntegrationCase, Launch, endless, free_endpoint, read_table

SILENCE = 40  # [s] long enough that a death which is named was noticed without it
PARTICIPANT = {"mpm_solver": "soil", "fem_solver": "structure"}


class Killed(IntegrationCase):
    def start_endless(self, in_contact: bool) -> Launch:
        files = endless(in_contact)
        files["coupler"]["protocol"] = {"silence_deadline": SILENCE}
        self.write_scene(files)
        return self.start_and_step()

    def strike(self, run: Launch, program: str, number: signal.Signals) -> Ended:
        """Send the signal; every program must end."""
        pid = run.pid_of(program)
        os.kill(pid, number)
        seconds = run.wait_programs_gone()
        begin = time.monotonic()
        ended = run.wait()
        print(f"{program}: all programs gone after {seconds:.2f} s, mpirun {time.monotonic() - begin:.2f} s later")
        self.assertNotEqual(ended.code, 0)
        run.wait_none_left()
        return ended

    def check_results(self, in_contact: bool) -> None:
        steps = read_table(self.out / "steps.csv")
        self.assertGreaterEqual(len(steps), 49)
        self.assertEqual(steps[40]["status"], "converged" if in_contact else "inactive")
        probes, iterations = read_table(self.out / "probes.csv"), read_table(self.out / "iterations.csv")
        self.assertIn(len(probes) - 1 - len(steps), (0, -1))
        self.assertGreaterEqual(len(iterations), len(steps))
        soil = self.assert_frames_open(self.out / "mpm", "soil")
        structure = self.assert_frames_open(self.out / "fem", "structure")
        self.assertEqual(soil[0], 0)
        self.assertGreaterEqual(len(soil), 2)
        self.assertLessEqual(abs(len(soil) - len(structure)), 1)

    def kill_solver(self, program: str, in_contact: bool) -> None:
        run = self.start_endless(in_contact)
        pid = run.pid_of(program)
        ended = self.strike(run, program, signal.SIGKILL)
        self.assertEqual(ended.code, 128 + signal.SIGKILL, ended.text)
        words = ("error: ", f'participant "{PARTICIPANT[program]}"', f"({program}, pid {pid}) has died",
                 "last sign of life", "in phase")
        self.assert_says(ended.text, "[cpl]", *words)
        self.assert_says((self.out / "coupler.log").read_text(), *words)
        self.assertRegex((self.out / "summary.json").read_text(), '"completed": false')
        self.check_results(in_contact)

    def kill_coupler(self, in_contact: bool) -> None:
        run = self.start_endless(in_contact)
        pid = run.pid_of("coupler")
        ended = self.strike(run, "coupler", signal.SIGKILL)
        self.assertEqual(ended.code, 128 + signal.SIGKILL, ended.text)
        for prefix in ("mpm", "fem"):
            self.assert_says(ended.text, f"[{prefix}] error: the coupler (pid {pid}) has died")
        self.check_results(in_contact)

    def test_soil_killed_in_contact(self) -> None:
        self.kill_solver("mpm_solver", in_contact=True)

    def test_soil_killed_out_of_contact(self) -> None:
        self.kill_solver("mpm_solver", in_contact=False)

    def test_structure_killed_in_contact(self) -> None:
        self.kill_solver("fem_solver", in_contact=True)

    def test_structure_killed_out_of_contact(self) -> None:
        """Nobody solves with it then: it is told of accepted steps only."""
        self.kill_solver("fem_solver", in_contact=False)

    def test_coupler_killed_in_contact(self) -> None:
        self.kill_coupler(in_contact=True)

    def test_coupler_killed_out_of_contact(self) -> None:
        self.kill_coupler(in_contact=False)

    def test_second_rank_killed(self) -> None:
        self.write_scene(endless(in_contact=True))
        run = self.start_and_step(ranks={"mpm_solver": 2})
        os.kill(max(pid for pid, name in run.alive().items() if name == "mpm_solver"), signal.SIGKILL)
        run.wait_programs_gone()
        self.assertEqual(run.wait().code, 128 + signal.SIGKILL)
        self.check_results(in_contact=True)

    def test_stopped_solver_is_named_after_the_silence_deadline(self) -> None:
        files = endless(in_contact=True)
        files["coupler"]["protocol"] = {"silence_deadline": 1, "heartbeat": 0.2}
        self.write_scene(files)
        run = self.start_and_step()
        os.kill(run.pid_of("mpm_solver"), signal.SIGSTOP)
        seconds = run.wait_programs_gone()
        ended = run.wait()
        print(f"stopped: all programs gone after {seconds:.2f} s, silence deadline 1 s")
        self.assertGreater(seconds, 0.8)
        self.assertEqual(ended.code, 4, ended.text)
        words = ("error: ", 'participant "soil"', "is silent for", "limit 1 s, option protocol/silence_deadline",
                 "its process is stopped", "last sign of life", "in phase")
        self.assert_says(ended.text, "[cpl]", *words)
        self.assert_says((self.out / "coupler.log").read_text(), *words)
        self.check_results(in_contact=True)

    def test_shared_memory_has_no_names(self) -> None:
        """Shared memory without a name is gone with the processes, whatever ends them and mpirun."""
        self.write_scene(endless(in_contact=True))
        run = self.start_and_step(ranks={"mpm_solver": 2})
        for pid, name in run.alive().items():
            if name not in PROGRAMS:
                continue
            maps = [line for line in Path(f"/proc/{pid}/maps").read_text().splitlines() if "/dev/shm/" in line]
            self.assertTrue(all(line.endswith("(deleted)") for line in maps), maps)

    def start_each_alone(self) -> dict[str, Launch]:
        """Each program without mpirun, which would wake or kill the others at the end of one; after 50 steps."""
        endpoint = free_endpoint()
        started = {}
        for program in PROGRAMS:
            started[program] = Launch([str(launch.binaries / program), str(self.scene), "--output", str(self.out),
                                       "--coupler", endpoint], self.folder)
            self.addCleanup(started[program].end)
            started[program].wait_until(self.out.exists, "the folder of results")
        rows = self.out / "steps.csv"
        started["coupler"].wait_until(lambda: rows.exists() and rows.read_text().count("\n") > 50, "50 steps")
        return started

    def test_stopped_coupler_says_that_it_was_stopped(self) -> None:
        """The solvers give it up; what it says when it runs again does not blame them."""
        files = endless(in_contact=True)
        files["coupler"]["protocol"] = {"silence_deadline": 2, "heartbeat": 0.2}
        self.write_scene(files)
        started = self.start_each_alone()
        coupler = started.pop("coupler")
        os.kill(coupler.process.pid, signal.SIGSTOP)
        for each in started.values():
            ended = each.wait()
            self.assertEqual(ended.code, 4, ended.text)
            self.assert_says(ended.text, "error: the coupler", "is silent for", "its process is stopped")
        os.kill(coupler.process.pid, signal.SIGCONT)
        self.assertEqual(coupler.wait().code, 4, coupler.text())
        words = "the coupler's own process did not run for"
        self.assertIn(words, json.loads((self.out / "summary.json").read_text())["reason"])
        self.assert_says((self.out / "coupler.log").read_text(), "error: ", words, "it was stopped")
        self.check_results(in_contact=True)


class Interrupted(IntegrationCase):
    def interrupt(self, number: signal.Signals, to_group: bool) -> None:
        self.write_scene(endless(in_contact=True))
        run = self.start_and_step()
        (os.killpg if to_group else os.kill)(run.process.pid, number)
        seconds = run.wait_programs_gone()
        ended = run.wait()
        print(f"{number.name}: all programs gone after {seconds:.2f} s")
        self.assertNotEqual(ended.code, 0)
        run.wait_none_left()
        log = (self.out / "coupler.log").read_text()
        self.assertTrue(log.endswith("\n"))
        self.assertRegex(log, r"error: .*interrupted by signal \d+")
        self.assertRegex((self.out / "summary.json").read_text(), '"reason": ".*interrupted by signal')
        self.assertGreaterEqual(len(read_table(self.out / "steps.csv")), 49)
        self.assert_frames_open(self.out / "mpm", "soil")

    def test_sigterm_of_the_launcher(self) -> None:
        self.interrupt(signal.SIGTERM, to_group=False)

    def test_sigint_of_the_launcher(self) -> None:
        self.interrupt(signal.SIGINT, to_group=False)

    def test_sigint_of_the_whole_group(self) -> None:
        """SIGINT to the whole group, as a terminal sends it for Ctrl-C."""
        self.interrupt(signal.SIGINT, to_group=True)


if __name__ == "__main__":
    launch.main()
