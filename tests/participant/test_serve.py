#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""serve(): handshake, requests, failures, deadlines."""

import io
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import zmq
from fake_coupler import ROOT, SEGMENTS, SQUARE, ParticipantCase
from gabion_participant import (AcceptReport, ConvergenceError, InterfaceMesh, ProtocolError, Solver, StepReport,
                                UsageError, interrupt, serve, serve_ranks)
from gabion_participant.connection import Connection
from gabion_participant.keys import PUBLIC, SECRET
from gabion_participant.message import Message
from gabion_participant.process import ProcessIdentity, read_stat, this_host
from gabion_participant.service import introduce, serve_over


GONE = ProcessIdentity(this_host(), 2**22 + 1, 1).to_fields()  # no process has such a number
PATIENT = {**os.environ, "OMPI_MCA_odls_base_sigkill_timeout": "40"}  # [s] from a signal to the end, in interrupt.py


class Spring(Solver):
    """u = f / stiffness + what the accepted steps have added."""

    def __init__(self) -> None:
        self.accepted, self.trial = 0.0, 0.0
        self.calls: list[str] = []
        self.may_solve = threading.Event()
        self.may_solve.set()
        self.answer = None  # instead of the right one
        self.problem: Exception | None = None

    def interfaces(self) -> list[InterfaceMesh]:
        return [InterfaceMesh("wall", SQUARE, SEGMENTS)]

    def solve_step(self, request, received):
        self.may_solve.wait(50)
        if self.problem:
            raise self.problem
        self.trial = self.accepted + request.dt
        u = np.full((3, 2), self.accepted) + (received["wall"] / 4 if received else 0)
        answer = {"wall": u} if self.answer is None else self.answer
        return answer, StepReport(2, 5, True, {"energy": np.float64("nan")})

    def accept_step(self, request, solved):
        self.calls.append(f"accept {solved}")
        if solved:
            self.accepted = self.trial
        return AcceptReport(at_rest=not solved, proposed_dt=0.25)

    def reject_step(self):
        self.calls.append("reject")

    def write_output(self, time):
        self.calls.append(f"write {time}")

    def probe_names(self):
        return ["tip"]

    def probes(self):
        return [self.accepted]

    def summary(self):
        return {"steps": np.int64(2)}


class KeepingSpring(Spring):
    """Keeps its state, eight bytes and the name of the method."""

    def save_state(self):
        return b"spring" + struct.pack("<d", self.accepted)

    def load_state(self, state):
        if state[:6] != b"spring":
            raise ValueError("not the state of a spring")
        self.accepted, = struct.unpack("<d", state[6:])


class KindSpring(Spring):
    """Wants to know which forces it receives."""

    def set_force_kinds(self, kinds):
        self.calls.append(f"kinds {kinds}")


class DisplacedSpring(Spring):
    """Starts in equilibrium with a load: displaced."""

    def start_displacements(self):
        return {"wall": np.full((3, 2), 0.25)}


class PlacedSoil(Spring):
    """Wants to know where its interfaces begin."""

    def set_start(self, displacements):
        self.calls.append(f"start {displacements['wall'].tolist()}")


class Serve(ParticipantCase):
    def begin(self, solver: Spring | None = None, **changes) -> Message:
        self.solver = solver or Spring()
        self.start(lambda: serve(self.solver, self.settings(**changes)))
        return self.coupler.welcome()

    def test_signs_of_life_may_come_before_the_welcome(self) -> None:
        self.start(lambda: serve(Spring(), self.settings()))
        self.coupler.welcome(alive_before=3)
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_endpoints_of_ipv6_are_understood(self) -> None:
        try:
            self.coupler.move("tcp://[::1]")
        except zmq.ZMQError as problem:
            self.skipTest(f"no IPv6 on this machine: {problem}")
        self.start(lambda: serve(Spring(), self.settings()))
        self.coupler.welcome()
        self.coupler.listen_for("waiting")  # over the socket of the heartbeat
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_texts_of_the_coupler_cannot_rule_a_terminal(self) -> None:
        self.begin()
        self.coupler.request("abort", reason="\x1b[2Jgone\r\n[cpl] done")
        self.assertEqual(self.end(), "ProtocolError: the coupler ended the run: \\x1b[2Jgone\\r\n    [cpl] done")

    def test_force_kinds_are_told_to_those_who_ask(self) -> None:
        hello = self.begin(KindSpring())
        self.assertIs(hello.fields["takes_force_kinds"], True)
        self.assertEqual(hello.fields["interfaces"][0]["force_kind"], "end_of_step")
        reply = self.coupler.ask("set_force_kinds", kinds={"wall": "step_mean"})
        self.assertEqual(reply.type, "force_kinds_set")
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(self.solver.calls, ["kinds {'wall': 'step_mean'}"])

    def test_force_kinds_that_cannot_be_are_refused(self) -> None:
        for solver, kinds, text in ((KindSpring(), {"roof": "step_mean"}, 'interface "roof" is none of this'),
                                    (KindSpring(), {"wall": "late"}, "expected force_kind"),
                                    (Spring(), {"wall": "step_mean"}, "of a participant that takes none")):
            hello = self.begin(solver)
            self.assertIs(hello.fields["takes_force_kinds"], isinstance(solver, KindSpring))
            self.coupler.request("set_force_kinds", kinds=kinds)
            self.assertIn(text, self.coupler.receive().fields["reason"])
            self.assertIn(text, self.end())
            self.coupler.begin_again()

    def test_a_structure_says_where_it_starts(self) -> None:
        hello = self.begin(DisplacedSpring())
        np.testing.assert_array_equal(hello.arrays["displacement:wall"], np.full((3, 2), 0.25))
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.coupler.begin_again()
        self.assertNotIn("displacement:wall", self.begin().arrays)
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_a_soil_is_told_where_it_starts(self) -> None:
        hello = self.begin(PlacedSoil(), receives="displacement")
        self.assertIs(hello.fields["takes_start"], True)
        start = {"displacement:wall": np.array([[0.0, 0.5], [1.0, 1.5], [2.0, 2.5]])}
        reply = self.coupler.ask("set_start", start)
        self.assertEqual(reply.type, "start_set")
        self.assertIn("probes", reply.arrays)
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual(self.solver.calls, ["start [[0.0, 0.5], [1.0, 1.5], [2.0, 2.5]]"])

    def test_a_start_that_cannot_be_is_refused(self) -> None:
        for solver, arrays, text in ((Spring(), np.zeros((3, 2)), "of a participant that takes none"),
                                     (PlacedSoil(), np.zeros((2, 2)), "shape")):
            hello = self.begin(solver, receives="displacement")
            self.assertIs(hello.fields["takes_start"], isinstance(solver, PlacedSoil))
            self.coupler.request("set_start", {"displacement:wall": arrays})
            self.assertIn(text, self.coupler.receive().fields["reason"])
            self.assertIn(text, self.end())
            self.coupler.begin_again()

    def test_a_whole_run(self) -> None:
        hello = self.begin(program="spring", program_version="3")
        self.assertEqual(hello.fields["receives"], {"quantity": "force", "unit": "N"})
        self.assertEqual(hello.fields["sends"], {"quantity": "displacement", "unit": "m"})
        self.assertEqual((hello.fields["program"], hello.fields["program_version"]), ("spring", "3"))
        np.testing.assert_array_equal(hello.arrays["coordinates:wall"], SQUARE)
        np.testing.assert_array_equal(hello.arrays["facets:wall"], SEGMENTS)
        coupler = self.coupler
        self.assertEqual(coupler.ask("write_output", time=0.0).type, "written")
        reply = coupler.solve(1, 2.0)
        np.testing.assert_array_equal(reply.arrays["displacement:wall"], np.full((3, 2), 0.5))
        self.assertEqual(reply.type, "solved")
        self.assertEqual((reply.fields["newton_iterations"], reply.fields["linear_iterations"]), (2, 5))
        self.assertEqual(reply.fields["details"], {"energy": None})
        self.assertGreaterEqual(reply.fields["busy_seconds"], 0)
        self.assertEqual(coupler.ask("reject_step").type, "rejected")
        self.assertEqual(coupler.solve(1, 2.0, dt=0.05).type, "solved")
        reply = coupler.accept(1)
        self.assertEqual(coupler.ask("write_output", time=0.05).type, "written")
        self.assertEqual((reply.type, reply.arrays["probes"][0], reply.fields["proposed_dt"]), ("accepted", 0.05, 0.25))
        np.testing.assert_array_equal(coupler.solve(2, None).arrays["displacement:wall"], np.full((3, 2), 0.05))
        self.assertTrue(coupler.accept(2, solved=False).fields["at_rest"])
        self.assertEqual(coupler.ask("summarize").fields["summary"], {"steps": 2})
        self.assertEqual(coupler.ask("finish").type, "finished")
        self.assertEqual(self.end(), "")
        self.assertEqual(self.solver.calls, ["write 0.0", "reject", "accept True", "write 0.05", "accept False"])

    def test_the_next_step_behind_the_acceptance(self) -> None:
        hello, coupler = self.begin(), self.coupler  # it proposes 0.25
        self.assertIs(hello.fields["takes_next_step"], True)
        coupler.solve(1, 2.0)
        for step, (bounds, kind) in enumerate((({"proposed_dt_from": 0.1}, "solved"),
                                               ({"proposed_dt_from": 0.3}, "passed"),
                                               ({"proposed_dt_from": 0.1, "proposed_dt_below": 0.25}, "passed"),
                                               ({"proposed_dt_from": 0.25, "proposed_dt_below": 0.5}, "solved")), 2):
            replies = coupler.accept_and_solve(step, 2.0, **bounds)
            self.assertEqual([reply.type for reply in replies], ["accepted", kind])
            if kind == "passed":  # nothing was done
                self.assertEqual(coupler.solve(step, 2.0).type, "solved")
        coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_save_and_load(self) -> None:
        hello = self.begin(KeepingSpring())
        self.assertIs(hello.fields["keeps_state"], True)
        coupler = self.coupler
        coupler.solve(1, 2.0)
        coupler.accept(1)
        saved = coupler.ask("save")
        self.assertEqual((saved.type, saved.fields["state"]), ("saved", {"bytes": 14}))
        coupler.solve(2, 2.0)
        coupler.accept(2)
        loaded = coupler.ask("load", saved.arrays, state=saved.fields["state"])
        self.assertEqual((loaded.type, loaded.arrays["probes"].tolist()), ("loaded", [0.1]))
        np.testing.assert_array_equal(coupler.solve(2, None).arrays["displacement:wall"], np.full((3, 2), 0.1))
        coupler.ask("reject_step")
        reply = coupler.ask("load", {"integer:bytes": np.zeros(2, dtype="<i8")}, state={"bytes": 14})
        self.assertEqual((reply.type, reply.fields["reason"]),
                         ("abort", "ValueError: not the state of a spring (in load_state)"))
        self.assertEqual(self.end(), "ValueError: not the state of a spring")

    def test_who_keeps_its_state_has_both_functions(self) -> None:
        self.assertIs(self.begin().fields["keeps_state"], False)
        self.assertEqual(self.coupler.ask("save").type, "abort")
        self.assertIn('asked for "save" of a participant that keeps no state', self.end())

        class Half(Spring):
            def save_state(self):
                return b""

        with self.assertRaisesRegex(UsageError, "found one of them, allowed: both, or neither"):
            serve(Half(), self.settings())

    def test_a_signal_leaves_time_for_the_last_checkpoint(self) -> None:
        """SIGTERM to the process; the coupler asks for the state, then ends the run. Then one without checkpoints."""
        for keeps, code, words in ((True, 4, "the coupler ended the run: by signal"), (False, 143, "by signal 15")):
            with self.subTest(keeps):
                command = [sys.executable, str(Path(__file__).parent / "sleeper.py"), self.coupler.endpoint]
                program = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=PATIENT)
                try:
                    self.coupler.welcome(run={"checkpoints": keeps})
                    self.coupler.ask("reject_step")
                    program.terminate()
                    if keeps:
                        self.coupler.listen(0.3)
                        self.assertEqual(self.coupler.ask("save").type, "saved")
                        self.coupler.send(Message("abort", 0, {"reason": "by signal"}))
                    self.assertEqual(program.wait(50), code)
                    self.assertIn(words, program.stderr.read())
                finally:
                    program.kill()
                    program.wait()
                    program.stderr.close()

    def test_a_step_without_solution_is_the_couplers_business(self) -> None:
        self.begin()
        self.solver.problem = ConvergenceError("dt too large")
        reply = self.coupler.solve(1, 1.0)
        self.assertEqual((reply.type, reply.fields["reason"]), ("failed", "dt too large"))
        self.solver.problem = None
        self.assertEqual(self.coupler.solve(1, 1.0).type, "solved")
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_any_other_exception_ends_the_run(self) -> None:
        self.begin()
        self.solver.problem = ZeroDivisionError("no stiffness")
        reply = self.coupler.solve(1, 1.0)
        self.assertEqual((reply.type, reply.fields["reason"]),
                         ("abort", "ZeroDivisionError: no stiffness (in solve_step)"))
        self.assertEqual(self.end(), "ZeroDivisionError: no stiffness")

    def test_the_type_of_an_exception_is_told(self) -> None:
        for problem, words in ((KeyError("wall"), "KeyError: 'wall' (in solve_step)"),
                               (ValueError(), "ValueError (in solve_step)"),
                               (SystemExit(3), "SystemExit: 3 (in solve_step)")):
            with self.subTest(words):
                self.begin()
                self.solver.problem = problem
                self.assertEqual(self.coupler.solve(1, 1.0).fields["reason"], words)
                self.end()

    def test_answers_of_another_type_are_named(self) -> None:
        values = {"wall": SQUARE}
        for function, answer, words in (
                ("solve_step", None, "solve_step: found NoneType as its answer, allowed: (values, StepReport)"),
                ("solve_step", values, "solve_step: found dict as its answer, allowed: (values, StepReport)"),
                ("solve_step", (SQUARE, StepReport()), "solve_step: found (ndarray, StepReport) as its answer"),
                ("solve_step", (values, {}), "solve_step: found (dict, dict) as its answer"),
                ("accept_step", None, "accept_step: found NoneType as its answer, allowed: an AcceptReport"),
                ("save_state", "text", "saved state: found str, allowed: bytes")):
            with self.subTest(words):
                self.problem = None
                self.coupler.begin_again()
                self.begin(KeepingSpring())
                with mock.patch.object(self.solver, function, lambda *_, answer=answer: answer):
                    if function == "save_state":
                        reply = self.coupler.ask("save")
                    else:
                        reply = self.coupler.solve(1, 1.0)
                    if function == "accept_step":
                        reply = self.coupler.accept(1)
                    self.assertEqual(reply.type, "abort")
                    self.assertIn(words, reply.fields["reason"])
                    self.assertIn("UsageError: " + words, self.end())

    def test_wrong_answers_are_not_sent(self) -> None:
        nan = np.zeros((3, 2))
        nan[1, 0] = np.nan
        for answer, words in (({"wall": nan}, '"displacement:wall" is nan at vertex 1, component 0'),
                              ({"wall": np.zeros(6)}, "found shape [6], allowed: [3, 2]"),
                              ({}, "found values of interfaces [], allowed: ['wall']")):
            with self.subTest(words):
                self.problem = None
                self.begin()
                self.solver.answer = answer
                reply = self.coupler.solve(1, 1.0)
                self.assertEqual(reply.type, "abort")
                self.assertIn(words, reply.fields["reason"])
                self.assertIn(words, self.end())

    def test_wrong_requests_end_the_run(self) -> None:
        force = {"force:wall": np.zeros((3, 2))}
        step = {"step": 1, "iteration": 0, "time": 0.0, "dt": 0.1}
        for kind, arrays, fields, words in (
                ("solve_step", {"force:wall": np.zeros((2, 2))}, step, "shape [3, 2]"),
                ("solve_step", {"force:wall": np.full((3, 2), np.inf)}, step, "is inf at vertex 0"),
                ("solve_step", force | {"force:roof": np.zeros((3, 2))}, step, "expected 1 arrays, found 2"),
                ("solve_step", force, step | {"dt": 0.0}, "a number > 0"),
                ("solve_step", force, {"step": 1}, '"iteration"'),
                ("accept_step", {}, step | {"solved": True, "write_output": False}, "step 1, which has no solution"),
                ("accept_step", {}, step | {"solved": False, "write_output": True, "output_time": 0.1},
                 'asks for output by "accept_step", allowed: by "write_output"'),
                ("dance", {}, {}, 'asked for "dance"')):
            with self.subTest(words):
                self.problem = None
                self.begin()
                reply = self.coupler.ask(kind, arrays, **fields)
                self.assertEqual(reply.type, "abort")
                self.assertIn(words, reply.fields["reason"])
                self.assertIn(words, self.end())

    def test_steps_that_do_not_follow_one_another_end_the_run(self) -> None:
        step = {"step": 2, "iteration": 0, "time": 0.1, "dt": 0.1}
        for kind, fields, words in (
                ("solve_step", {"step": 3}, "step 3 after step 1 was accepted, expected step 2"),
                ("solve_step", {"time": 0.0}, "step 2 from 0.0 s, but the accepted state is that of 0.1 s"),
                ("accept_step", {"solved": False, "write_output": False, "step": 1}, "expected step 2"),
                ("accept_step", {"solved": True, "write_output": False}, "step 2, which has no solution")):
            with self.subTest(words):
                self.problem = None
                self.coupler.begin_again()
                self.begin()
                self.coupler.solve(1, 2.0)
                self.coupler.accept(1)
                reply = self.coupler.ask(kind, {}, **(step | fields))
                self.assertEqual(reply.type, "abort")
                self.assertIn(words, self.end())

    def test_what_is_accepted_is_what_was_solved(self) -> None:
        self.begin()
        self.coupler.solve(1, 2.0)
        reply = self.coupler.ask("accept_step", {}, step=1, iteration=0, time=0.0, dt=0.05, solved=True,
                                 write_output=False)
        self.assertEqual(reply.type, "abort")
        self.assertIn("with dt 0.05 s, but the solution is that of step 1 with dt 0.1 s", self.end())

    def test_a_repeated_sequence_number_ends_the_run(self) -> None:
        self.begin()
        self.coupler.ask("reject_step")
        self.coupler.send(Message("reject_step", 1))
        self.assertEqual(self.coupler.receive().type, "abort")
        self.assertIn('"reject_step" with sequence number 1 after 1', self.end())

    def test_broken_frames_end_the_run(self) -> None:
        self.begin()
        self.coupler.send_frames([b"{"])
        self.assertEqual(self.coupler.receive().type, "abort")
        self.assertIn("sent a message that is not understood: header frame is not JSON", self.end())

    def test_the_couplers_abort_is_told(self) -> None:
        self.begin()
        self.coupler.send(Message("abort", 0, {"reason": "disk full"}))
        self.assertEqual(self.end(), "ProtocolError: the coupler ended the run: disk full")


class FakeComm:
    """A communicator as of mpi4py, for ranks that are threads: what rank 0 sends the other one receives."""

    size = 2

    def __init__(self, rank: int, orders: queue.Queue, words: queue.Queue) -> None:
        self.rank = rank
        self.sent, self.received = (orders, words) if rank == 0 else (words, orders)
        self.aborted: int | None = None

    def send(self, order: Any, rank: int, tag: int) -> None:
        self.sent.put(pickle.loads(pickle.dumps(order)))

    def iprobe(self, source: int, tag: int) -> bool:
        return not self.received.empty()

    def recv(self, source: int, tag: int) -> Any:
        return self.received.get()

    def Abort(self, code: int) -> None:
        self.aborted = code


class RankSpring(KeepingSpring):
    def begin_run(self, run):
        self.calls.append(f"begins {run['end']}")


class Ranks(ParticipantCase):
    def begin(self) -> None:
        self.solvers = RankSpring(), RankSpring()
        orders, words = queue.Queue(), queue.Queue()
        self.comms = FakeComm(0, orders, words), FakeComm(1, orders, words)
        self.follower = threading.Thread(
            target=lambda: serve_ranks(self.solvers[1], self.settings(), self.comms[1]))
        self.follower.start()
        self.start(lambda: serve_ranks(self.solvers[0], self.settings(), self.comms[0]))
        self.coupler.welcome()

    def test_all_ranks_answer_and_one_speaks(self) -> None:
        self.begin()
        coupler = self.coupler
        reply = coupler.solve(1, 2.0)
        np.testing.assert_array_equal(reply.arrays["displacement:wall"], np.full((3, 2), 0.5))
        coupler.ask("reject_step")
        coupler.solve(1, 2.0)
        coupler.accept(1)
        state = coupler.ask("save")
        coupler.solve(2, 2.0)
        coupler.accept(2)
        coupler.ask("load", dict(state.arrays), state=state.fields["state"])
        coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.follower.join(50)
        calls = ["begins 1.0", "reject", "accept True", "accept True"]
        for solver, comm in zip(self.solvers, self.comms):
            self.assertEqual((solver.calls, solver.accepted, comm.aborted), (calls, 0.1, None))

    def test_an_error_of_another_rank_ends_all(self) -> None:
        self.begin()
        self.solvers[1].problem = KeyError("lost")
        with mock.patch("sys.stderr", io.StringIO()) as printed, mock.patch("gabion_participant.ranks.ANSWER_TIME", 0):
            self.coupler.solve(1, 2.0)
            self.follower.join(50)
        self.assertEqual((self.comms[0].aborted, self.comms[1].aborted), (None, 3))
        self.assertIn("error: rank 1: KeyError: 'lost'", printed.getvalue())
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_a_rank_that_dies_ends_rank_0(self) -> None:
        other = subprocess.Popen(["sleep", "1000"])
        self.addCleanup(other.wait)
        self.addCleanup(other.kill)
        state = read_stat(other.pid)
        identity = repr((this_host(), other.pid, state[1]))
        leader = ("import time\nfrom gabion_participant.process import ProcessIdentity\n"
                  "from gabion_participant.rank_watch import RankWatch\n"
                  f"with RankWatch('wall', [ProcessIdentity(*{identity})]):\n    print('here', flush=True)\n"
                  "    time.sleep(1000)\n")
        led = subprocess.Popen([sys.executable, "-c", leader], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True,
                               env={**os.environ, "PYTHONPATH": str(ROOT / "protocol" / "python")})
        self.addCleanup(led.kill)
        self.assertEqual(led.stdout.readline(), "here\n")
        other.kill()
        _, text = led.communicate(timeout=600)
        self.assertEqual(led.returncode, -signal.SIGKILL)
        self.assertIn(f"[wall] error: rank 1 (pid {other.pid}) has died", text)

    def test_no_solution_is_no_error(self) -> None:
        self.begin()
        for solver in self.solvers:
            solver.problem = ConvergenceError("too steep")
        self.assertEqual(self.coupler.solve(1, 2.0).fields["reason"], "too steep")
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.follower.join(50)
        self.assertEqual(self.comms[1].aborted, None)


class Handshake(ParticipantCase):
    def test_refusal_is_told(self) -> None:
        self.start(lambda: serve(Spring(), self.settings()))
        self.coupler.receive()
        self.coupler.send(Message("refused", 0, {"reason": "dimension: coupler 3, participant 2", "mismatches": []}))
        self.assertIn('refused participant "structure": dimension: coupler 3, participant 2', self.end())

    def test_another_major_version(self) -> None:
        self.start(lambda: serve(Spring(), self.settings()))
        self.coupler.welcome(protocol="2.0")
        self.assertIn("protocol version: coupler 2.0, participant 1.4", self.end())

    def test_versions_that_are_none(self) -> None:
        for version in ("1" * 5000 + ".0", "2147483648.0", "-1.0", "\u0663.0", "1"):
            self.start(lambda: serve(Spring(), self.settings()))
            self.coupler.welcome(protocol=version)
            self.assertIn('protocol version: expected "major.minor"', self.end())

    def test_a_newer_minor_version_with_unknown_fields(self) -> None:
        self.start(lambda: serve(Spring(), self.settings()))
        self.coupler.welcome(protocol="1.7", more="of it")
        self.assertEqual(self.coupler.ask("finish").type, "finished")
        self.assertEqual(self.end(), "")

    def test_nobody_answers(self) -> None:
        self.start(lambda: serve(Spring(), self.settings(connect_deadline=0.3)))
        self.assertRegex(self.end(), r"no answer from a coupler at tcp://127.0.0.1:\d+ within 0.3 s")

    def test_a_hello_that_cannot_be_sent_does_not_hide_why(self) -> None:
        (public, secret), (coupler_public, _) = zmq.curve_keypair(), zmq.curve_keypair()
        files = {"own": f"{SECRET}{secret.decode()}", "coupler": f"{PUBLIC}{coupler_public.decode()}"}
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                path = Path(folder, name)
                path.touch(mode=0o600)
                path.write_text(text, encoding="ascii")
            settings = self.settings(key_file=f"{folder}/own", coupler_key_file=f"{folder}/coupler")
            refused = self.assertRaisesRegex(ProtocolError, "it uses no keys")
            with mock.patch.object(zmq.Socket, "send_multipart", side_effect=zmq.Again), refused, \
                    Connection(settings) as connection:
                introduce(Spring(), connection)

    def test_settings_are_checked(self) -> None:
        for change, words in (({"name": "a b"}, "letters, digits"), ({"dimension": 4}, "2 or 3"),
                              ({"receives": "heat"}, "displacement, force"), ({"connect_deadline": 0}, "> 0 s")):
            with self.subTest(words), self.assertRaisesRegex(UsageError, words):
                self.settings(**change)

    def test_meshes_are_checked_before_they_are_sent(self) -> None:
        for mesh, words in ((InterfaceMesh("wall", np.zeros((3, 3))), "num_vertices x 2"),
                            (InterfaceMesh("wall", SQUARE * np.nan), "finite"),
                            (InterfaceMesh("wall", SQUARE, [[0, 3]]), "vertices 0 to 3, allowed: 0 to 2"),
                            (InterfaceMesh("wall", SQUARE, [[0]]), "num_facets x 2, 3 or 4")):
            solver = Spring()
            solver.interfaces = lambda mesh=mesh: [mesh]
            with self.subTest(words), self.assertRaisesRegex(UsageError, words):
                serve(solver, self.settings())


class Deadlines(ParticipantCase):
    def begin(self, **welcome) -> Spring:
        solver = Spring()
        self.start(lambda: serve(solver, self.settings()))
        self.coupler.welcome(**welcome)
        return solver

    def test_signs_of_life_while_it_computes(self) -> None:
        solver = self.begin()
        solver.may_solve.clear()
        self.coupler.request("solve_step", step=12, iteration=3, time=0.0, dt=0.1)
        self.coupler.listen_for("solve_step 12 iteration 3", count=2)
        solver.may_solve.set()
        self.assertEqual(self.coupler.receive().type, "solved")
        self.assertEqual({message.fields["participant"] for message in self.coupler.alive}, {"structure"})
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def test_a_silent_coupler(self) -> None:
        self.begin(silence_deadline=0.4)
        self.assertRegex(self.end(), r"the coupler \(pid \d+\) is silent for .* s \(limit 0.4 s, option "
                                     'protocol/silence_deadline in coupler.json.*phase "coupling"')

    def test_signs_of_life_keep_it_waiting(self) -> None:
        self.begin(silence_deadline=2.0)
        for _ in range(6):
            self.coupler.send(Message("alive", 0, {"phase": "acceleration", "seconds": 1.0}))
            self.coupler.listen(0.5)
        self.assertEqual(self.coupler.ask("finish").type, "finished")
        self.assertEqual(self.end(), "")

    def test_an_idle_coupler(self) -> None:
        self.begin(idle_deadline=0.3)
        self.assertRegex(self.end(),
                         r"alive but has asked nothing for .* s \(limit 0.3 s, option protocol/idle_deadline")

    def test_a_dead_coupler(self) -> None:
        self.begin(process=GONE)
        self.assertIn("has died: no process", self.end())

    def test_no_orphan_computes_on(self) -> None:
        """The coupler dies while the solver computes, which it does for longer than this test may take."""
        command = [sys.executable, str(Path(__file__).parent / "sleeper.py"), self.coupler.endpoint]
        stand_in = subprocess.Popen(["/bin/sleep", "60"])  # whose death is the coupler's
        orphan = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        try:
            identity = ProcessIdentity(this_host(), stand_in.pid, read_stat(stand_in.pid)[1])
            self.coupler.welcome(process=identity.to_fields())
            self.coupler.request("solve_step", step=5, iteration=2, time=0.0, dt=0.1)
            self.coupler.listen_for("solve_step 5 iteration 2")
            stand_in.kill()
            self.assertEqual(orphan.wait(50), 4)
            self.assertRegex(orphan.stderr.read(), "has died.*this process ends in phase .solve_step 5 iteration 2")
        finally:
            for process in (stand_in, orphan):
                process.kill()
                process.wait()
            orphan.stderr.close()


class LastWords(ParticipantCase):
    """Messages that have come count before a death: the coupler's process is gone while its words are in the queue. The
    sign of life before them makes the participant look for that process."""

    def hear(self, kind: str, signal_came: bool = False, **fields: Any) -> str:
        """How a participant ends whose last message is this."""
        def take_part() -> None:
            with Connection(self.settings()) as connection:
                introduce(Spring(), connection)
                with mock.patch.object(interrupt, "_came", signal.SIGTERM if signal_came else 0):
                    serve_over(Spring(), connection)

        self.start(take_part)
        self.coupler.welcome(process=GONE)
        self.coupler.send(Message("alive", 0, {"phase": "finish", "seconds": 0.0}))
        self.coupler.request(kind, **fields)
        return self.end()

    def test_who_is_told_to_finish_ends_well(self) -> None:
        self.assertEqual(self.hear("finish"), "")
        self.assertEqual(self.coupler.receive().type, "finished")

    def test_who_is_told_to_finish_ends_well_when_a_signal_comes_too(self) -> None:
        self.assertEqual(self.hear("finish", signal_came=True), "")

    def test_the_reason_is_told(self) -> None:
        self.assertEqual(self.hear("abort", reason="dt_min reached"),
                         "ProtocolError: the coupler ended the run: dt_min reached")

    def test_what_else_was_asked_nobody_awaits(self) -> None:
        self.assertIn("has died: no process", self.hear("summarize"))


if __name__ == "__main__":
    unittest.main()
