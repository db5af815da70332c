#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Participant: a foreign time loop, its checkpoints, and calls in the wrong order."""

import struct
import subprocess
import sys
import unittest
import warnings
from pathlib import Path

import numpy as np
from fake_coupler import SEGMENTS, SQUARE, ParticipantCase
from gabion_participant import Participant, StepReport, UsageError

STEP = 0.1  # [s] of the coupler


class Loop:
    """A code with a loop of its own: du/dt = f / 4 at every vertex, explicit Euler with steps of at most
    `own_dt`."""

    def __init__(self, settings, own_dt: float = 1.0, writes: bool = True, keeps: bool = False) -> None:
        self.u, self.saved = 0.0, 0.0
        self.own_dt = own_dt
        self.calls: list[str] = []
        self.fails_above = np.inf  # [N]
        self.participant = Participant(settings)
        self.participant.set_interface("wall", SQUARE, SEGMENTS)
        self.participant.set_probes({"u": 0.0})
        self.participant.set_summary({"method": "Euler"})
        if writes:
            self.participant.set_output(lambda time: self.calls.append(f"write {time:g} u {self.u:g}"))
        if keeps:
            self.participant.set_state(lambda: struct.pack("<d", self.u), self.load)

    def load(self, state: bytes) -> None:
        self.u, = struct.unpack("<d", state)
        self.participant.set_probes({"u": self.u})
        self.calls.append(f"load {self.u:g}")

    def run(self) -> None:
        participant = self.participant
        participant.initialize()
        while participant.is_coupling_ongoing():
            if participant.requires_writing_checkpoint():
                self.saved = self.u
                self.calls.append(f"save {self.u:g}")
            dt = min(self.own_dt, participant.get_max_time_step_size())
            force = participant.read_data("wall")
            self.step(dt, force)
            if participant.requires_reading_checkpoint():
                self.u = self.saved
                self.calls.append(f"restore {self.u:g}")
            if participant.is_time_window_complete():
                self.calls.append("complete")
        participant.finalize()

    def step(self, dt: float, force: np.ndarray) -> None:
        self.u += dt * force[0, 0] / 4
        self.participant.write_data("wall", np.full((3, 2), self.u))
        self.participant.set_probes({"u": self.u})
        if force[0, 0] > self.fails_above:
            self.participant.fail_step("too much")
        else:
            self.participant.advance(dt, StepReport(newton_iterations=7))


class AskingLoop(Loop):
    """Asks which forces it reads."""

    def step(self, dt: float, force: np.ndarray) -> None:
        self.calls.append(self.participant.force_kind("wall"))
        super().step(dt, force)


class OwnLoop(ParticipantCase):
    def begin(self, **how) -> Loop:
        loop = Loop(self.settings(), **how)
        self.start(loop.run)
        hello = self.coupler.welcome()
        self.assertEqual(hello.fields["probe_names"], ["u"])
        return loop

    def test_the_kind_of_the_forces(self) -> None:
        for kinds, expected in (({}, "end_of_step"), ({"wall": "step_mean"}, "step_mean")):
            loop = AskingLoop(self.settings())
            self.start(loop.run)
            self.assertIs(self.coupler.welcome().fields["takes_force_kinds"], True)
            if kinds:
                self.assertEqual(self.coupler.ask("set_force_kinds", kinds=kinds).type, "force_kinds_set")
            self.coupler.solve(1, 2.0)
            self.coupler.accept(1)
            self.coupler.ask("finish")
            self.assertEqual(self.end(), "")
            self.assertIn(expected, loop.calls)
            self.coupler.begin_again()

    def test_mean_forces_that_nobody_asked_for_are_a_warning(self) -> None:
        loop = self.begin()
        self.coupler.ask("set_force_kinds", kinds={"wall": "step_mean"})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            for step in (1, 2):
                self.coupler.solve(step, 2.0)
                self.coupler.accept(step)
        self.assertEqual(len(caught), 1)
        self.assertIn('interface "wall": its forces are means over the step', str(caught[0].message))
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertIn("complete", loop.calls)

    def test_force_kinds_of_a_soil(self) -> None:
        participant = Participant(self.settings(receives="displacement"))
        participant.set_interface("wall", SQUARE, SEGMENTS, "step_mean")
        self.start(participant.initialize)
        hello = self.coupler.welcome()
        self.assertEqual(hello.fields["interfaces"][0]["force_kind"], "step_mean")
        self.assertIs(hello.fields["takes_force_kinds"], False)
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        participant = Participant(self.settings(receives="displacement"))
        participant.set_interface("wall", SQUARE, SEGMENTS, "late")
        self.assertRaisesRegex(UsageError, 'found force_kind "late"', participant.initialize)

    def test_the_next_step_behind_the_acceptance(self) -> None:
        loop, coupler = self.begin(), self.coupler
        coupler.solve(1, 2.0)
        for step in (2, 3):  # a loop of its own proposes no dt, which is above all bounds
            replies = coupler.accept_and_solve(step, 2.0, proposed_dt_from=0.3)
            self.assertEqual([reply.type for reply in replies], ["accepted", "solved"])
        replies = coupler.accept_and_solve(4, 2.0, proposed_dt_from=0.1, proposed_dt_below=0.3)
        self.assertEqual([reply.type for reply in replies], ["accepted", "passed"])
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.calls.count("complete"), 3)

    def displacement(self, reply) -> float:
        self.assertEqual(reply.type, "solved")
        values = reply.arrays["displacement:wall"]
        np.testing.assert_array_equal(values, np.full((3, 2), values[0, 0]))
        return values[0, 0]

    def test_repeat_reject_cut_and_accept(self) -> None:
        loop, coupler = self.begin(), self.coupler
        self.assertEqual(coupler.ask("write_output", time=0.0).type, "written")
        first = coupler.solve(1, 8.0)
        self.assertEqual(first.fields["newton_iterations"], 7)
        self.assertEqual(self.displacement(first), 0.2)
        self.assertEqual(self.displacement(coupler.solve(1, 4.0, 1)), 0.1)
        self.assertEqual(self.displacement(coupler.solve(1, 8.0, 2)), 0.2)
        self.assertEqual(coupler.ask("reject_step").type, "rejected")
        self.assertEqual(coupler.ask("write_output", time=0.0).type, "written")  # the accepted state, u = 0
        self.assertEqual(self.displacement(coupler.solve(1, 8.0, dt=0.05)), 0.1)
        accepted = coupler.accept(1)
        self.assertEqual((accepted.type, accepted.arrays["probes"][0]), ("accepted", 0.1))
        self.assertEqual(coupler.ask("write_output", time=0.05).type, "written")
        self.assertEqual(coupler.ask("reject_step").type, "rejected")  # nothing to forget
        self.assertAlmostEqual(self.displacement(coupler.solve(2, 4.0)), 0.2, delta=1e-16)
        self.assertEqual(coupler.ask("summarize").fields["summary"], {"method": "Euler"})
        accepted = coupler.accept(2)
        self.assertAlmostEqual(accepted.arrays["probes"][0], 0.2, delta=1e-16)
        self.assertEqual(coupler.ask("finish").type, "finished")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.calls, ["write 0 u 0", "save 0", "restore 0", "restore 0", "restore 0", "write 0 u 0",
                                      "complete", "write 0.05 u 0.1", "save 0.1", "complete"])

    def test_save_and_load_between_steps(self) -> None:
        loop, coupler = self.begin(keeps=True), self.coupler
        coupler.solve(1, 8.0)
        coupler.accept(1)
        saved = coupler.ask("save")
        self.assertEqual((saved.type, saved.fields["state"]), ("saved", {"bytes": 8}))
        for _ in range(2):
            answer = self.displacement(coupler.solve(2, 4.0))
            coupler.accept(2)
            self.displacement(coupler.solve(3, 8.0))
            self.assertEqual(coupler.ask("reject_step").type, "rejected")
            loaded = coupler.ask("load", saved.arrays, state=saved.fields["state"])
            self.assertEqual((loaded.type, loaded.arrays["probes"].tolist()), ("loaded", [0.2]))
        self.assertEqual(self.displacement(coupler.solve(2, 4.0)), answer)
        coupler.ask("reject_step")
        self.assertEqual(self.displacement(coupler.solve(2, 4.0)), answer)
        coupler.accept(2)
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.calls[:9], ["save 0", "complete", "save 0.2", "complete", "save 0.3", "restore 0.3",
                                          "load 0.2", "save 0.2", "complete"])

    def test_load_before_the_first_step(self) -> None:
        loop, coupler = self.begin(keeps=True), self.coupler
        state = np.frombuffer(struct.pack("<d", 0.7), dtype="<i8")
        loaded = coupler.ask("load", {"integer:bytes": state}, state={"bytes": 8})
        self.assertEqual(loaded.arrays["probes"].tolist(), [0.7])
        self.assertEqual(self.displacement(coupler.solve(9, 4.0)), 0.7 + 0.1 * 4.0 / 4)
        coupler.accept(9)
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.calls, ["load 0.7", "save 0.7", "complete"])

    def test_wrong_saves_and_loads_end_the_run(self) -> None:
        for keeps, solves, kind, fields, words in (
                (False, False, "save", {}, 'asked for "save", which this participant does not know'),
                (True, True, "save", {}, 'asked for "save" in the middle of a step'),
                (True, False, "load", {"state": {"bytes": 80}}, "an array of 80 bytes, found 1 values"),
                (True, False, "load", {"state": {"scheme": "Euler"}}, '"bytes": expected a signed 64-bit integer')):
            with self.subTest(words):
                self.problem = None
                loop = self.begin(keeps=keeps)
                self.addCleanup(loop.participant.finalize)
                if solves:
                    self.coupler.solve(1, 8.0)
                reply = self.coupler.ask(kind, {"integer:bytes": np.zeros(1, dtype="<i8")}, **fields)
                self.assertEqual(reply.type, "abort")
                self.assertIn(words, self.end())

    def test_steps_that_do_not_follow_one_another_end_the_run(self) -> None:
        step = {"step": 2, "iteration": 0, "time": 0.1, "dt": 0.1}
        for wrong, words in (({"step": 3}, "step 3 after step 1 was accepted, expected step 2"),
                             ({"time": 0.0}, "step 2 from 0.0 s, but the accepted state is that of 0.1 s")):
            with self.subTest(words):
                self.problem = None
                self.coupler.begin_again()
                loop = self.begin()
                self.addCleanup(loop.participant.finalize)
                self.coupler.solve(1, 8.0)
                self.coupler.accept(1)
                reply = self.coupler.ask("solve_step", {}, **(step | wrong))
                self.assertEqual(reply.type, "abort")
                self.assertIn(words, self.end())

    def test_a_skipped_step_changes_nothing(self) -> None:
        loop, coupler = self.begin(), self.coupler
        coupler.solve(1, 8.0)
        coupler.accept(1)
        self.assertEqual(coupler.accept(2, solved=False).arrays["probes"][0], 0.2)
        coupler.solve(3, 4.0)
        self.assertEqual(coupler.accept(3, solved=False).arrays["probes"][0], 0.2)  # asked, but not taken
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.u, 0.2)

    def test_a_failed_step_is_repeated(self) -> None:
        loop, coupler = self.begin(), self.coupler
        loop.fails_above = 5.0
        reply = coupler.solve(1, 8.0)
        self.assertEqual((reply.type, reply.fields["reason"]), ("failed", "too much"))
        self.assertEqual(coupler.ask("reject_step").type, "rejected")
        self.assertAlmostEqual(self.displacement(coupler.solve(1, 4.0, dt=0.05)), 0.05, delta=1e-16)
        coupler.accept(1)
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.calls, ["save 0", "restore 0", "complete"])

    def test_steps_of_its_own(self) -> None:
        loop, coupler = self.begin(own_dt=0.03), self.coupler
        for _ in range(2):  # four sub-steps, and none is left over from round-off
            self.assertAlmostEqual(self.displacement(coupler.solve(1, 8.0)), 0.2, delta=1e-15)
        coupler.accept(1)
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(loop.calls, ["save 0", "restore 0", "complete"])

    def test_free_interfaces_carry_no_force(self) -> None:
        self.begin()
        self.assertEqual(self.displacement(self.coupler.solve(1, None)), 0.0)
        self.coupler.accept(1)
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_writing_in_the_middle_of_a_step(self) -> None:
        for writes, answer in ((False, "written"), (True, "abort")):
            with self.subTest(writes=writes):
                self.problem = None
                self.begin(writes=writes)
                self.coupler.solve(1, 8.0)
                self.assertEqual(self.coupler.ask("write_output", time=0.0).type, answer)
                if not writes:
                    self.coupler.accept(1)
                    self.coupler.ask("finish")
                self.assertIn("between steps only" if writes else "", self.end())

    def test_the_code_gives_up(self) -> None:
        def give_up() -> None:
            participant = Participant(self.settings())
            participant.set_interface("wall", SQUARE)
            participant.initialize()
            participant.finalize()

        self.start(give_up)
        hello = self.coupler.welcome()
        self.assertEqual(hello.fields["interfaces"], [
            {"name": "wall", "vertices_per_facet": 0, "force_kind": "end_of_step"}])
        self.coupler.request("solve_step", {"force:wall": np.zeros((3, 2))}, step=1, iteration=0, time=0.0, dt=STEP)
        reply = self.coupler.receive()
        self.assertEqual(reply.type, "abort")
        self.assertEqual(reply.fields["reason"], "the participant ended before the run was finished")
        self.assertEqual(self.end(), "")

    def test_the_end_of_a_block_is_told(self) -> None:
        for problem, words in ((KeyError("wall"), "KeyError: 'wall'"), (ValueError(), "ValueError"),
                               (UsageError("too late"), "too late"),
                               (None, "the participant ended before the run was finished")):
            def run(problem=problem) -> None:
                with Participant(self.settings()) as participant:
                    participant.set_interface("wall", SQUARE)
                    participant.initialize()
                    if problem:
                        raise problem

            with self.subTest(words):
                self.problem = None
                self.coupler.begin_again()
                self.start(run)
                self.coupler.welcome()
                self.coupler.request("solve_step", {"force:wall": np.zeros((3, 2))}, step=1, iteration=0, time=0.0,
                                     dt=STEP)
                reply = self.coupler.receive()
                self.assertEqual((reply.type, reply.fields["reason"]), ("abort", words))
                self.end()
                self.assertIs(self.problem, problem)

    def test_a_block_around_a_whole_run(self) -> None:
        loop = Loop(self.settings())

        def run() -> None:
            with loop.participant:
                loop.run()

        self.start(run)
        self.coupler.welcome()
        self.coupler.solve(1, 8.0)
        self.coupler.accept(1)
        self.assertEqual(self.coupler.ask("finish").type, "finished")
        self.assertEqual(self.end(), "")

    def test_a_program_that_ends_without_a_word(self) -> None:
        """Neither a block nor finalize(): an exception, sys.exit, a copy of the process that ends first."""
        for how, code, words in (("raise", 1, "KeyError: 'wall'"),
                                 ("exit", 3, "the participant ended before the run was finished"),
                                 ("fork", 1, "KeyError: 'wall'")):
            with self.subTest(how):
                self.coupler.begin_again()
                program = subprocess.Popen([sys.executable, str(Path(__file__).parent / "leaver.py"),
                                            self.coupler.endpoint, how], stderr=subprocess.PIPE, text=True)
                try:
                    self.coupler.welcome()
                    self.coupler.request("solve_step", {"force:wall": np.zeros((3, 2))}, step=1, iteration=0,
                                         time=0.0, dt=STEP)
                    reply = self.coupler.receive()
                    self.assertEqual((reply.type, reply.fields["reason"]), ("abort", words))
                    self.assertEqual(program.wait(50), code)
                finally:
                    program.kill()
                    program.wait()
                    program.stderr.close()


class WrongCalls(ParticipantCase):
    """Each is an error with the name of what is allowed."""

    def expect(self, words: str, body) -> None:
        def run() -> None:
            participant = Participant(self.settings())
            participant.set_interface("wall", SQUARE, SEGMENTS)
            participant.set_probes({"u": 0.0})
            participant.initialize()
            try:
                body(participant)
            finally:
                participant.finalize()

        self.problem = None
        self.start(run)
        self.coupler.welcome()
        self.coupler.request("solve_step", {"force:wall": np.zeros((3, 2))}, step=1, iteration=0, time=0.0, dt=STEP)
        self.assertEqual(self.coupler.receive().type, "abort")
        self.assertRegex(self.end(), f"UsageError: .*{words}")

    def test_before_initialize(self) -> None:
        for call in ("is_coupling_ongoing", "get_max_time_step_size", "is_time_window_complete", "run_settings",
                     "requires_writing_checkpoint", "requires_reading_checkpoint"):
            with self.subTest(call), self.assertRaisesRegex(UsageError, "initialize.. comes first"):
                getattr(Participant(self.settings()), call)()
        with self.assertRaisesRegex(UsageError, "one or more"):
            Participant(self.settings()).initialize()

    def test_after_initialize(self) -> None:
        self.expect("set_interface: allowed before initialize", lambda p: p.set_interface("roof", SQUARE))
        self.expect("initialize: allowed before initialize", lambda p: p.initialize())
        self.expect("set_probes: found .'v'., allowed: the names given at first", lambda p: p.set_probes({"v": 1.0}))

    def test_steps(self) -> None:
        def ready(participant: Participant) -> Participant:
            participant.requires_writing_checkpoint()
            participant.write_data("wall", SQUARE)
            return participant

        self.expect("advance: call requires_writing_checkpoint", lambda p: p.advance(STEP))
        self.expect("found dt 0.11 s, allowed: > 0 and at most 0.1 s", lambda p: ready(p).advance(0.11))
        self.expect("found dt 0 s", lambda p: ready(p).advance(0))
        self.expect("found interface \"roof\", allowed: wall", lambda p: p.read_data("roof"))
        self.expect("found shape .6. for", lambda p: p.write_data("wall", np.zeros(6)))

        def silent(participant: Participant) -> None:
            participant.requires_writing_checkpoint()
            participant.advance(STEP)

        self.expect("displacement: found values of interfaces .., allowed: .'wall'.", silent)

    def test_going_on_without_going_back(self) -> None:
        problems = []

        def run() -> None:
            participant = Participant(self.settings())
            participant.set_interface("wall", SQUARE)
            participant.initialize()
            for _ in range(2):
                participant.requires_writing_checkpoint()
                participant.write_data("wall", SQUARE)
                try:
                    participant.advance(STEP)
                except UsageError as problem:
                    problems.append(str(problem))
            participant.finalize()

        self.start(run)
        self.coupler.welcome()
        self.coupler.solve(1, 1.0)
        self.coupler.request("solve_step", {"force:wall": np.zeros((3, 2))}, step=1, iteration=1, time=0.0, dt=STEP)
        self.assertEqual(self.coupler.receive().type, "abort")
        self.assertEqual(self.end(), "")
        self.assertRegex(problems[0], "call requires_reading_checkpoint")


if __name__ == "__main__":
    unittest.main()
