# SPDX-License-Identifier: BSD-3-Clause
"""Participant: for codes that keep their own time loop. The picture is in docs/foreign_codes.md."""

import atexit
import os
import sys
import time
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .connection import Connection
from .errors import ProtocolError, UsageError, text_of
from .handshake import Introduction, ParticipantSettings, check_interfaces, put_values, solved
from .message import Message
from .own_loop import ME, OwnLoop
from .solver import END_OF_STEP, InterfaceFacets, InterfaceMesh, InterfaceValues, StepReport, StepRequest
from .state_machine import StateMachine

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
        self._start: InterfaceValues = {}  # displacements in the initial state [m]
        self._connection: Connection | None = None
        self._loop = OwnLoop()
        self._machine: StateMachine | None = None  # after initialize()
        self._begin = 0.0  # of the current request
        self._finished = False
        self._process = os.getpid()

    def __enter__(self) -> "Participant":
        return self

    def __exit__(self, _kind: type | None, problem: BaseException | None, _trace: Any) -> None:
        self._leave(problem)

    def set_interface(self, name: str, coordinates: np.ndarray, facets: np.ndarray | None = None,
                      force_kind: str = END_OF_STEP) -> None:
        """Set a coupled surface; see InterfaceMesh for shapes and units. Call it before initialize()."""
        self._before_initialize("set_interface")
        self._meshes.append(InterfaceMesh(name, coordinates, facets, force_kind))

    def set_start_displacement(self, interface: str, values: np.ndarray) -> None:
        """Set the displacements of an interface in the initial state [m], num_vertices x dim, of a structure that
        begins displaced, such as in equilibrium with its weight. Call it before initialize(), after set_interface()."""
        self._before_initialize("set_start_displacement")
        if self._settings.sends != "displacement":
            raise UsageError(f"set_start_displacement: found a participant that sends {self._settings.sends}, "
                             "allowed: one that sends displacement")
        mesh, array = self._mesh(interface), np.array(values, dtype="<f8")
        if array.shape != mesh.coordinates.shape:
            raise UsageError(f'set_start_displacement: found shape {list(array.shape)} for "{interface}", '
                             f"allowed: {list(mesh.coordinates.shape)}")
        if not np.isfinite(array).all():
            raise UsageError(f'set_start_displacement: found NaN or infinity for "{interface}", '
                             "allowed: finite values")
        self._start[interface] = array

    def on_set_start(self, take: Callable[[InterfaceValues], None]) -> None:
        """Set the function `take(displacements)` of a soil, which gets the displacements [m] of all interfaces where
        the structures begin. It is called in initialize(), only where one of them is displaced, not in a restart; it
        calls set_probes() where they change. Displacements of read_data() remain total, from the reference. `take`
        raises where the soil cannot begin so, which ends the run. Call it before initialize()."""
        self._before_initialize("on_set_start")
        if self._settings.receives != "displacement":
            raise UsageError(f"on_set_start: found a participant that receives {self._settings.receives}, "
                             "allowed: one that receives displacement")
        self._loop.take_start = take

    def set_facets_may_change(self, interface: str) -> None:
        """Declare that facets of an interface of a structure may leave it, or come, where cells fail. Its vertices are
        all that a facet may ever have. Call it before initialize(), after set_interface()."""
        self._before_initialize("set_facets_may_change")
        if self._settings.sends != "displacement":
            raise UsageError(f"set_facets_may_change: found a participant that sends {self._settings.sends}, "
                             "allowed: one that sends displacement")
        self._loop.facets.let_change(self._mesh(interface))

    def write_facets(self, interface: str, facets: np.ndarray) -> None:
        """Set all facets, num_facets x 2, 3 or 4, that such an interface has from the step on that was just accepted.
        Call it when is_time_window_complete(), before the next is_coupling_ongoing(), where they change; and within
        `load` of set_state(), for each of these interfaces."""
        self._loop.write_facets(self._mesh(interface), facets)

    def on_set_facets(self, take: Callable[[InterfaceFacets], None]) -> None:
        """Set the function `take(facets)` of a soil, which lets these interfaces have other facets from now on, of the
        same vertices; a saved state has them. It is called between two steps. `take` raises where the soil cannot go
        on so, which ends the run. Call it before initialize()."""
        self._before_initialize("on_set_facets")
        if self._settings.receives != "displacement":
            raise UsageError(f"on_set_facets: found a participant that receives {self._settings.receives}, "
                             "allowed: one that receives displacement")
        self._loop.take_facets = take

    def set_probes(self, values: Mapping[str, float]) -> None:
        """Numbers that the run shall record. Before initialize() in the initial state, later, always with the
        same names, before advance(), at the end of the step."""
        if self._connection and list(values) != list(self._loop.probes):
            raise UsageError(f"set_probes: found {list(values)}, allowed: the names given at first, "
                             f"{list(self._loop.probes)}")
        self._loop.probes = dict(values)

    def set_output(self, write: Callable[[float], None]) -> None:
        """Set the function `write(time)` [s], which is called when the coupler wants the accepted state on disk; this
        is then the code's current state. Without it the code writes when it likes, such as after
        is_time_window_complete()."""
        self._before_initialize("set_output")
        self._loop.output = write

    def set_state(self, save: Callable[[], bytes], load: Callable[[bytes], None]) -> None:
        """Set the functions with which a run with this code can be restarted (optional). Call it before initialize().

        `save()` gives all of the accepted state, which then is the code's current state, that later steps
        depend on, in a form of the code's own. `load(state)` goes on from what `save` gave, in an earlier run
        perhaps, and calls set_probes(); each later step then gives the bits that it would have given there.
        It is called in initialize() already, or between two steps, and calls write_facets() of each interface whose
        facets may change.
        """
        self._before_initialize("set_state")
        self._loop.save, self._loop.load = save, load

    def set_summary(self, summary: dict[str, Any]) -> None:
        """Set the entry of this participant in summary.json."""
        self._loop.summary = dict(summary)

    def initialize(self) -> None:
        """Connect, introduce, and wait for the first step."""
        self._before_initialize("initialize")
        check_interfaces(self._meshes, self._settings.dimension)
        self._connection = Connection(self._settings)
        self._machine = StateMachine(self._loop, self._settings.receives, self._meshes, ME)
        atexit.register(self._leave_at_exit)
        self._loop.accepted_probes = list(self._loop.probes.values())
        names = list(self._loop.probes)
        introduction = Introduction(self._meshes, names, self._loop.accepted_probes,
                                    keeps_state=self._loop.save is not None,
                                    takes_force_kinds=self._settings.receives == "force",
                                    start=self._start, takes_start=self._loop.take_start is not None,
                                    takes_facets=self._loop.take_facets is not None,
                                    changing=list(self._loop.facets.now))
        self._guarded(lambda: self._connection.handshake(introduction))
        self._loop.must_write = True
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
        return self._loop.window_complete

    def get_max_time_step_size(self) -> float:
        """[s] that are left of the open step; 0 after the end."""
        self._settle()
        return self._loop.remaining

    def get_time(self) -> float:
        """[s] of the accepted state from which the open step starts."""
        return self._open_step("get_time").time

    def requires_writing_checkpoint(self) -> bool:
        """Whether to save the current, accepted state. To ask is the promise to do so."""
        self._settle()
        answer, self._loop.must_write = self._loop.must_write and not self._finished, False
        return answer

    def requires_reading_checkpoint(self) -> bool:
        """Whether to go back to the state that was saved. To ask is the promise to do so."""
        self._after_initialize()
        answer, self._loop.must_read = self._loop.must_read, False
        return answer

    def force_kind(self, interface: str) -> str:
        """Kind of force that read_data() gives on this interface: END_OF_STEP, or STEP_MEAN, the mean force, which is
        to act as a constant load over the step. It does not change during a run."""
        self._settle()
        self._loop.asked_force_kind = True
        return self._loop.force_kinds.get(self._mesh(interface).name, END_OF_STEP)

    def read_data(self, interface: str) -> np.ndarray:
        """The received values at the end of the step, num_vertices x dim: force [N] or displacement [m]."""
        self._open_step("read_data")
        self._mesh(interface)
        if self._loop.received:
            return self._loop.received[interface].copy()
        if self._settings.receives == "force":  # a free surface carries no force
            return np.zeros_like(self._mesh(interface).coordinates)
        raise ProtocolError(
            f'the coupler gives no displacement of "{interface}" in this step: the interface is free')

    def write_data(self, interface: str, values: np.ndarray) -> None:
        """Set the values to send at the end of the step, num_vertices x dim: displacement [m] or force [N]."""
        self._open_step("write_data")
        mesh = self._mesh(interface)
        array = np.array(values, dtype="<f8")
        if array.shape != mesh.coordinates.shape:
            raise UsageError(f'write_data: found shape {list(array.shape)} for "{interface}", '
                             f"allowed: {list(mesh.coordinates.shape)}")
        self._loop.written[interface] = array

    def advance(self, dt: float, report: StepReport | None = None) -> None:
        """Note that the code has advanced by `dt` [s], at most get_max_time_step_size(). At the end of the step: send
        what was written, and wait for the verdict."""
        request = self._checked_step("advance")
        for name in self._loop.unnoticed_means():
            warnings.warn(f'interface "{name}": its forces are means over the step; this code does not ask '
                          "force_kind(), so it may take them as those of its end", stacklevel=2)
        if not 0 < dt <= self._loop.remaining + SAME_TIME * request.dt:
            raise UsageError(f"advance: found dt {dt} s, allowed: > 0 and at most {self._loop.remaining} s")
        self._loop.window_complete = False
        self._loop.remaining -= dt
        if self._loop.remaining > SAME_TIME * request.dt:
            return
        reply = solved(report or StepReport())
        put_values(reply, self._settings.sends, self._meshes, self._loop.written)
        self._answer_step(reply)
        self._machine.solved(request)
        self._guarded(self._await_verdict)

    def fail_step(self, reason: str) -> None:
        """Call it instead of advance() when the open step has no solution. The coupler will try a smaller one; go back
        to the saved state."""
        self._checked_step("fail_step")
        self._loop.window_complete = False
        self._answer_step(Message("failed", fields={"reason": reason}))
        self._guarded(self._await_verdict)

    def finalize(self) -> None:
        """Close; before the end of the coupling, tell the coupler that this participant gives up."""
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

    # The methods below wait for requests and answer them.

    def _settle(self) -> None:
        """Let a step be open, or the run finished."""
        self._after_initialize()
        if self._loop.request or self._finished:
            return
        if self._loop.must_read:
            raise UsageError(
                "the last step was not accepted: call requires_reading_checkpoint() and go back first")
        self._guarded(self._await_step)

    def _await_step(self) -> None:
        if self._loop.pending:
            self._reply(self._loop.pending)
            self._loop.pending = None
        while not self._loop.request and not self._finished:
            self._do_next_request()

    def _await_verdict(self) -> None:
        """Serve after an answer to solve_step until the coupler accepts it, rejects it or asks again."""
        while self._loop.awaits_verdict and not self._finished:
            self._do_next_request()

    def _do_next_request(self) -> None:
        request = self._connection.next_request()
        self._begin = time.monotonic()
        answer = self._machine.handle(request)
        if answer:
            self._reply(answer)
        if self._machine.is_finished:
            self._finished = True
            self._connection.close()

    def _reply(self, message: Message) -> None:
        if message.type == "accepted":
            self._loop.facets.put_changed(message)
        message.fields["busy_seconds"] = time.monotonic() - self._begin
        self._connection.reply(message)

    def _answer_step(self, message: Message) -> None:
        self._guarded(lambda: self._reply(message))
        self._loop.close_step()

    def _guarded(self, action: Callable[[], None]) -> None:
        """Whatever fails is told to the coupler."""
        try:
            action()
        except BaseException as problem:
            self._connection.abort(text_of(problem))
            raise

    # The methods below check the order of calls.

    def _before_initialize(self, call: str) -> None:
        if self._connection:
            raise UsageError(f"{call}: allowed before initialize() only, once")

    def _after_initialize(self) -> Connection:
        if not self._connection:
            raise UsageError("initialize() comes first")
        return self._connection

    def _open_step(self, call: str) -> StepRequest:
        self._settle()
        if not self._loop.request:
            raise UsageError(f"{call}: the coupling has ended; ask is_coupling_ongoing()")
        return self._loop.request

    def _checked_step(self, call: str) -> StepRequest:
        request = self._open_step(call)
        for due, name in ((self._loop.must_read, "requires_reading_checkpoint"),
                          (self._loop.must_write, "requires_writing_checkpoint")):
            if due:
                raise UsageError(
                    f"{call}: call {name}() in this step first, or repeated steps are spoilt")
        return request

    def _mesh(self, name: str) -> InterfaceMesh:
        for mesh in self._meshes:
            if mesh.name == name:
                return mesh
        raise UsageError(
            f'found interface "{name}", allowed: {", ".join(mesh.name for mesh in self._meshes)}')
