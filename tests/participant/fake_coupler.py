# SPDX-License-Identifier: BSD-3-Clause
"""A coupler that says whatever a test wants, and a participant in a thread of the test."""

import sys
import threading
import time
import unittest
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import zmq

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "protocol" / "python")]
from gabion_participant import ParticipantSettings  # noqa: E402
from gabion_participant.message import Message, decode, encode  # noqa: E402
from gabion_participant.process import this_process  # noqa: E402

SQUARE = np.array([[0.26, 0.0], [0.26, 0.05], [0.25, 0.05]])
SEGMENTS = np.array([[0, 1], [1, 2]])
PATIENCE = 50000  # [ms] for any message of these tests: none of them passes, however loaded the machine is


class FakeCoupler:
    """One ROUTER socket, one participant."""

    def __init__(self) -> None:
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.setsockopt(zmq.LINGER, 0)
        port = self._socket.bind_to_random_port("tcp://127.0.0.1")
        self.endpoint = f"tcp://127.0.0.1:{port}"
        self.route = b""
        self.alive: list[Message] = []  # signs of life so far
        self._sequence = 0
        self._time, self._dt = 0.0, 0.1  # [s] of the accepted state, and of the step

    def move(self, address: str) -> None:
        """Listen at a free port of another address."""
        self._socket.setsockopt(zmq.IPV6, "[" in address)
        port = self._socket.bind_to_random_port(address)
        self.endpoint = f"{address}:{port}"

    def begin_again(self) -> None:
        """Begin again at time 0, for another participant."""
        self._sequence, self._time, self._dt = 0, 0.0, 0.1

    def begin_again_at(self, step: int) -> None:
        """Go on from the end of a step that was accepted earlier, after its state was loaded."""
        self._time = step * self._dt

    def close(self) -> None:
        self._socket.close()
        self._context.term()

    def receive(self) -> Message:
        """The next message that is no sign of life."""
        while self._socket.poll(PATIENCE):
            route, *frames = self._socket.recv_multipart()
            message = decode(frames)
            if message.type != "alive":
                self.route = route
                return message
            self.alive.append(message)
        raise AssertionError("the participant sent nothing")

    def listen_for(self, phase: str, count: int = 1) -> None:
        """Take signs of life until so many came from this phase."""
        while sum(message.fields["phase"] == phase for message in self.alive) < count:
            assert self._socket.poll(PATIENCE), f'no sign of life in phase "{phase}"'
            self.alive.append(decode(self._socket.recv_multipart()[1:]))

    def listen(self, seconds: float) -> None:
        """Take signs of life only."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if self._socket.poll(int(1000 * left) + 1):
                self.alive.append(decode(self._socket.recv_multipart()[1:]))

    def send(self, message: Message) -> None:
        self.send_frames(encode(message))

    def send_frames(self, frames: list[bytes]) -> None:
        self._socket.send_multipart([self.route, *frames])

    def welcome(self, alive_before: int = 0, **changes: Any) -> Message:
        """Take the hello and welcome it, after so many signs of life; returns the hello."""
        hello = self.receive()
        for _ in range(alive_before):
            self.send(Message("alive", 1, {"phase": "handshake", "seconds": 0.0}))
        process = this_process().to_fields()
        self.send(Message("welcome", fields={
            "protocol": "1.4", "program_version": "test", "process": process, "silence_deadline": 50.0,
            "idle_deadline": 50.0, "heartbeat": 0.1, "run": {"end": 1.0}} | changes))
        return hello

    def request(self, kind: str, arrays: dict[str, np.ndarray] | None = None, **fields: Any) -> None:
        self._sequence += 1
        self.send(Message(kind, self._sequence, fields, arrays or {}))

    def ask(self, kind: str, arrays: dict[str, np.ndarray] | None = None, **fields: Any) -> Message:
        """A request and its reply, which must have the request's number."""
        self.request(kind, arrays, **fields)
        reply = self.receive()
        assert reply.sequence == self._sequence, f"answered {reply.sequence} to {self._sequence}"
        return reply

    def solve(self, step: int, force: float | None, iteration: int = 0, dt: float = 0.1) -> Message:
        """Ask for a solution under an equal force [N] on every component; None: free interfaces."""
        arrays = {} if force is None else {"force:wall": np.full((3, 2), force)}
        self._dt = dt
        return self.ask("solve_step", arrays, step=step, iteration=iteration, time=self._time, dt=dt)

    def accept(self, step: int, solved: bool = True, **fields: Any) -> Message:
        """Accept a step with the dt of the last solution; time goes on by it."""
        begin, self._time = self._time, self._time + self._dt
        return self.ask("accept_step", step=step, iteration=0, time=begin, dt=self._dt, solved=solved,
                        **({"write_output": False} | fields))


    def accept_and_solve(self, step: int, force: float, **bounds: float) -> list[Message]:
        """Accept the step before and solve this one, which is asked for at once; both replies."""
        begin, self._time = self._time, self._time + self._dt
        self.request("accept_step", step=step - 1, iteration=0, time=begin, dt=self._dt, solved=True,
                     write_output=False)
        self.request("solve_step", {"force:wall": np.full((3, 2), force)}, step=step, iteration=0, time=self._time,
                     dt=self._dt, **bounds)
        replies = [self.receive(), self.receive()]
        assert [reply.sequence for reply in replies] == [self._sequence - 1, self._sequence]
        return replies


class ParticipantCase(unittest.TestCase):
    """Has a coupler, and runs the participant's side in a thread."""

    def setUp(self) -> None:
        self.coupler = FakeCoupler()
        self.addCleanup(self.coupler.close)
        self.problem: BaseException | None = None
        self._thread: threading.Thread | None = None

    def settings(self, **changes: Any) -> ParticipantSettings:
        values = {"name": "structure", "endpoint": self.coupler.endpoint, "dimension": 2, "connect_deadline": 50.0,
                  "exit_when_coupler_is_lost": False} | changes
        return ParticipantSettings(**values)

    def start(self, action: Callable[[], None]) -> None:
        def run() -> None:
            try:
                action()
            except BaseException as problem:  # noqa: BLE001: the test looks at it
                self.problem = problem

        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()

    def end(self) -> str:
        """Wait for the participant's end; the text of what it raised, "" for nothing."""
        self._thread.join(PATIENCE / 1000)
        self.assertFalse(self._thread.is_alive(), "the participant has not ended")
        return f"{type(self.problem).__name__}: {self.problem}" if self.problem else ""
