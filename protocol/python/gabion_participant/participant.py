# SPDX-License-Identifier: BSD-3-Clause
"""Participant: for codes that keep their own time loop. The picture is in docs/foreign_codes.md."""

import atexit
import os
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .connection import Connection
from .errors import ProtocolError, UsageError, text_of
from .handshake import (ParticipantSettings, accepted, check_interfaces, loaded, plain, put_values,
                        read_state, read_step_request, read_values, saved, solved)
from .message import Message
from .solver import AcceptReport, InterfaceMesh, InterfaceValues, StepReport, StepRequest
from .step_order import StepOrder

SAME_TIME = 1e-12  # of a step: smaller remainders are round-off of a sum of sub-steps


class Participant:
    """One coupler, driven by the foreign code's own loop:

        with Participant(settings) as participant:
            participant.set_interface("wall", coordinates, facets)
            participant.initialize()
            while participant.is_coupling_ongoing():
                if participant.requires_writing_checkpoint(): save()
                dt = min(own_dt, participant.get_max_time_step_size())
                solve(dt, participant.read_data("wall"))
                participant.write_data("wall", displacement)
                participant.advance(dt)
                if participant.requires_reading_checkpoint(): restore()

    The end of the block is finalize(); an exception that ends it is told to the coupler. Without a block call
    finalize() yourself; when the program ends without it, the coupler is told why.
    """

    def __init__(self, settings: ParticipantSettings) -> None:
        self._settings = settings
        self._meshes: list[InterfaceMesh] = []
        self._connection: Connection | None = None
        self._output: Callable[[float], None] | None = None
        self._save: Callable[[], bytes] | None = None  # None: does not keep its state
        self._load: Callable[[bytes], None] | None = None
        self._summary: dict[str, Any] = {}
        self._probes: dict[str, float] = {}
        self._accepted_probes: list[float] = []
        self._request: StepRequest | None = None  # the open solve_step
        self._pending: Message | None = None  # answer that waits until the foreign code has done its part
        self._received: InterfaceValues = {}
        self._written: InterfaceValues = {}
        self._remaining = 0.0  # [s] of the open step
        self._begin = 0.0  # of the request under way
        self._must_write = self._must_read = False  # checkpoints that were not asked for yet
        self._order = StepOrder()
        self._window_complete = self._finished = False
        self._process = os.getpid()

    def __enter__(self) -> "Participant":
        return self

    def __exit__(self, _kind: type | None, problem: BaseException | None, _trace: Any) -> None:
        self._leave(problem)

    def set_interface(self, name: str, coordinates: np.ndarray, facets: np.ndarray | None = None) -> None:
        """A coupled surface; see InterfaceMesh for shapes and units. Before initialize()."""
        self._before_initialize("set_interface")
        self._meshes.append(InterfaceMesh(name, coordinates, facets))

    def set_probes(self, values: Mapping[str, float]) -> None:
        """Numbers that the run shall record. Before initialize() in the initial state, later, always with the
        same names, before advance(), at the end of the step."""
        if self._connection and list(values) != list(self._probes):
            raise UsageError(f"set_probes: found {list(values)}, allowed: the names given at first, "
                             f"{list(self._probes)}")
        self._probes = dict(values)

    def set_output(self, write: Callable[[float], None]) -> None:
        """`write(time)` [s] is called when the coupler wants the accepted state on disk, which then is the
        code's current state. Without it the code writes when it likes, such as after
        is_time_window_complete()."""
        self._before_initialize("set_output")
        self._output = write

    def set_state(self, save: Callable[[], bytes], load: Callable[[bytes], None]) -> None:
        """Optional, so that a run with this code can be restarted. Before initialize().

        `save()` gives all of the accepted state, which then is the code's current state, that later steps
        depend on, in a form of the code's own. `load(state)` goes on from what `save` gave, in an earlier run
        perhaps, and calls set_probes(); each later step then gives the bits that it would have given there.
        It is called in initialize() already, or between two steps.
        """
        self._before_initialize("set_state")
        self._save, self._load = save, load

    def set_summary(self, summary: dict[str, Any]) -> None:
        """What summary.json shall say of this participant."""
        self._summary = dict(summary)

    def initialize(self) -> None:
        """Connect, introduce, and wait for the first step."""
        self._before_initialize("initialize")
        check_interfaces(self._meshes, self._settings.dimension)
        self._connection = Connection(self._settings)
        atexit.register(self._leave_at_exit)
        self._accepted_probes = list(self._probes.values())
        names = list(self._probes)
        self._guarded(lambda: self._connection.handshake(self._meshes, names, self._accepted_probes,
                                                          self._save is not None))
        self._must_write = True
        self._settle()

    def run_settings(self) -> dict[str, Any]:
        """Settings of the run as the coupler gave them: end time, dt, folders."""
        return self._after_initialize().run_settings()

    def is_coupling_ongoing(self) -> bool:
        """Whether there is a step to solve. Tells the coupler that the last one is done with; waits for the
        next."""
        self._settle()
        return not self._finished

    def is_time_window_complete(self) -> bool:
        """Whether the last advance() ended with an accepted step."""
        self._after_initialize()
        return self._window_complete

    def get_max_time_step_size(self) -> float:
        """[s] that are left of the open step; 0 after the end."""
        self._settle()
        return self._remaining

    def get_time(self) -> float:
        """[s] of the accepted state from which the open step starts."""
        return self._open_step("get_time").time

    def requires_writing_checkpoint(self) -> bool:
        """Whether to save the current, accepted state. To ask is the promise to do so."""
        self._settle()
        answer, self._must_write = self._must_write and not self._finished, False
        return answer

    def requires_reading_checkpoint(self) -> bool:
        """Whether to go back to the state that was saved. To ask is the promise to do so."""
        self._after_initialize()
        answer, self._must_read = self._must_read, False
        return answer

    def read_data(self, interface: str) -> np.ndarray:
        """Received values at the end of the step, num_vertices x dim: force [N] or displacement [m]."""
        self._open_step("read_data")
        self._mesh(interface)
        if self._received:
            return self._received[interface].copy()
        if self._settings.receives == "force":  # a free surface carries no force
            return np.zeros_like(self._mesh(interface).coordinates)
        raise ProtocolError(
            f'the coupler gives no displacement of "{interface}" in this step: the interface is free')

    def write_data(self, interface: str, values: np.ndarray) -> None:
        """Values to send at the end of the step, num_vertices x dim: displacement [m] or force [N]."""
        self._open_step("write_data")
        mesh = self._mesh(interface)
        array = np.array(values, dtype="<f8")
        if array.shape != mesh.coordinates.shape:
            raise UsageError(f'write_data: found shape {list(array.shape)} for "{interface}", '
                             f"allowed: {list(mesh.coordinates.shape)}")
        self._written[interface] = array

    def advance(self, dt: float, report: StepReport | None = None) -> None:
        """The code has gone on by `dt` [s], at most get_max_time_step_size(). At the end of the step: send
        what was written, and wait for the verdict."""
        request = self._checked_step("advance")
        if not 0 < dt <= self._remaining + SAME_TIME * request.dt:
            raise UsageError(f"advance: found dt {dt} s, allowed: > 0 and at most {self._remaining} s")
        self._window_complete = False
        self._remaining -= dt
        if self._remaining > SAME_TIME * request.dt:
            return
        reply = solved(report or StepReport())
        put_values(reply, self._settings.sends, self._meshes, self._written)
        self._answer_step(reply)
        self._order.solved(request)
        self._guarded(self._await_verdict)

    def fail_step(self, reason: str) -> None:
        """Instead of advance(): the open step has no solution. The coupler will try a smaller one; go back to
        the saved state."""
        self._checked_step("fail_step")
        self._window_complete = False
        self._answer_step(Message("failed", fields={"reason": reason}))
        self._guarded(self._await_verdict)

    def finalize(self) -> None:
        """Close. Before the end of the coupling: tell the coupler that this participant gives up."""
        self._leave(None)

    def _leave(self, problem: BaseException | None) -> None:
        """Close; before the end of the coupling tell the coupler why."""
        atexit.unregister(self._leave_at_exit)
        if self._connection:
            if not self._finished:
                why = text_of(problem) if problem else "the participant ended before the run was finished"
                self._connection.abort(why)
            self._connection.close()

    def _leave_at_exit(self) -> None:
        """The program ends without finalize(), perhaps because of an exception that Python has printed."""
        if os.getpid() == self._process:  # a copy of the process has no say
            self._leave(getattr(sys, "last_value", None))

    # What follows waits for and answers requests.

    def _settle(self) -> None:
        """Let a step be open, or the run finished."""
        connection = self._after_initialize()
        if self._request or self._finished:
            return
        if self._must_read:
            raise UsageError(
                "the last step was not accepted: ask requires_reading_checkpoint() and go back first")
        self._guarded(lambda: self._await_step(connection))

    def _await_step(self, connection: Connection) -> None:
        if self._pending:
            self._reply(self._pending)
            self._pending = None
        while not self._request and not self._finished:
            request = self._next()
            if request.type == "accept_step":
                self._order.accept(read_step_request(request), request.boolean("solved"))
                self._write_if_asked(request)
                self._reply(accepted(AcceptReport(), self._accepted_probes))
            elif request.type == "reject_step":
                self._reply(Message("rejected"))
            else:
                self._other_request(request)

    def _await_verdict(self) -> None:
        """After an answer to solve_step: until the coupler accepts it, rejects it or asks again."""
        while not self._finished:
            request = self._next()
            if request.type == "accept_step":
                return self._accepted(request)
            if request.type == "reject_step":
                self._order.reject()
                self._pending, self._must_read = Message("rejected"), True
                return None
            if request.type == "write_output" and self._output:
                raise ProtocolError("the coupler wants the accepted state on disk in the middle of a step: "
                                    "this participant writes it between steps only")
            if request.type in ("save", "load"):
                raise ProtocolError(f'the coupler asked for "{request.type}" in the middle of a step')
            self._other_request(request)
            if self._request:
                self._must_read = True
                return None

    def _accepted(self, request: Message) -> None:
        solved_step = request.boolean("solved")
        self._order.accept(read_step_request(request), solved_step)
        if solved_step:
            self._accepted_probes = list(self._probes.values())
            self._must_write = self._window_complete = True
            self._write_if_asked(request)
        else:
            self._must_read = True  # asked, but accepted as if it had not been: the accepted state stays
        self._pending = accepted(AcceptReport(), self._accepted_probes)

    def _other_request(self, request: Message) -> None:
        match request.type:
            case "solve_step":
                step = read_step_request(request)
                self._received = read_values(request, self._settings.receives, self._meshes)
                self._order.check(step)
                self._order.reject()
                self._request, self._written, self._remaining = step, {}, step.dt
            case "write_output":
                if self._output:
                    self._output(request.number("time"))
                self._reply(Message("written"))
            case "save" if self._save:
                self._reply(saved(self._save()))
            case "load" if self._load:
                self._load(read_state(request))
                self._order.forget()
                self._accepted_probes = list(self._probes.values())
                self._must_write = True  # what the code saved for repeated steps is of another state
                self._reply(loaded(self._accepted_probes))
            case "summarize":
                self._reply(Message("summary", fields={"summary": plain(self._summary)}))
            case "finish":
                self._reply(Message("finished"))
                self._finished = True
                self._connection.close()
            case _:
                raise ProtocolError(
                    f'the coupler asked for "{request.type}", which this participant does not know')

    def _write_if_asked(self, request: Message) -> None:
        if request.boolean("write_output") and self._output:
            self._output(request.number("output_time"))

    def _next(self) -> Message:
        request = self._connection.next_request()
        self._begin = time.monotonic()
        return request

    def _reply(self, message: Message) -> None:
        message.fields["busy_seconds"] = time.monotonic() - self._begin
        self._connection.reply(message)

    def _answer_step(self, message: Message) -> None:
        self._guarded(lambda: self._reply(message))
        self._request, self._remaining = None, 0.0

    def _guarded(self, action: Callable[[], None]) -> None:
        """Whatever fails is told to the coupler."""
        try:
            action()
        except BaseException as problem:
            self._connection.abort(text_of(problem))
            raise

    # What follows checks the order of calls.

    def _before_initialize(self, call: str) -> None:
        if self._connection:
            raise UsageError(f"{call}: allowed before initialize() only, once")

    def _after_initialize(self) -> Connection:
        if not self._connection:
            raise UsageError("initialize() comes first")
        return self._connection

    def _open_step(self, call: str) -> StepRequest:
        self._settle()
        if not self._request:
            raise UsageError(f"{call}: the coupling has ended; ask is_coupling_ongoing()")
        return self._request

    def _checked_step(self, call: str) -> StepRequest:
        request = self._open_step(call)
        for due, name in ((self._must_read, "requires_reading_checkpoint"),
                          (self._must_write, "requires_writing_checkpoint")):
            if due:
                raise UsageError(
                    f"{call}: ask {name}() in this step first; not to do so would spoil repeated steps")
        return request

    def _mesh(self, name: str) -> InterfaceMesh:
        for mesh in self._meshes:
            if mesh.name == name:
                return mesh
        raise UsageError(
            f'found interface "{name}", allowed: {", ".join(mesh.name for mesh in self._meshes)}')
