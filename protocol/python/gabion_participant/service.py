# SPDX-License-Identifier: BSD-3-Clause
"""serve(solver): for codes that offer a few functions."""

import time
from collections.abc import Callable
from typing import Any

from .connection import Connection
from .errors import ConvergenceError, ProtocolError, UsageError, says_all, text_of
from .facets import ChangingFacets, checked_facets
from .handshake import (PROTOCOL_VERSION, Introduction, ParticipantSettings, accepted, loaded, plain,
                        put_values, read_state, saved, solved, start_set)
from .message import Message
from .solver import (AcceptReport, InterfaceFacets, InterfaceMesh, InterfaceValues, Solver, StepReport,
                     StepRequest)
from .state_machine import RequestHandler, StateMachine


def keeps_state(solver: Solver) -> bool:
    """Whether the solver has functions of its own in place of those that only raise."""
    own = [getattr(type(solver), name) is not getattr(Solver, name) for name in ("save_state", "load_state")]
    if own[0] != own[1]:
        raise UsageError("save_state, load_state: found one of them, allowed: both, or neither")
    return own[0]


def takes_force_kinds(solver: Solver) -> bool:
    """Whether the solver has a function of its own in place of that which only raises."""
    return type(solver).set_force_kinds is not Solver.set_force_kinds


def takes_start(solver: Solver) -> bool:
    """Whether the solver has a function of its own in place of that which only raises."""
    return type(solver).set_start is not Solver.set_start


def takes_facets(solver: Solver) -> bool:
    """Whether the solver has a function of its own in place of that which only raises."""
    return type(solver).set_facets is not Solver.set_facets


def checked_solution(answer: Any) -> tuple[InterfaceValues, StepReport]:
    """Check the values that solve_step returned. Raises UsageError."""
    allowed = "allowed: (values, StepReport), values a dict of interface name -> array"
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise UsageError(f"solve_step: found {type(answer).__name__} as its answer, {allowed}")
    values, report = answer
    if not isinstance(values, dict) or not isinstance(report, StepReport):
        found = f"({type(values).__name__}, {type(report).__name__})"
        raise UsageError(f"solve_step: found {found} as its answer, {allowed}")
    return values, report


def checked_report(answer: Any) -> AcceptReport:
    """Check the report that accept_step returned. Raises UsageError."""
    if not isinstance(answer, AcceptReport):
        found = type(answer).__name__
        raise UsageError(f"accept_step: found {found} as its answer, allowed: an AcceptReport")
    return answer


class Service(RequestHandler):
    """The solver as the coupler's requests drive it: every answer is there at once."""

    def __init__(self, solver: Solver, settings: ParticipantSettings) -> None:
        self._solver = solver
        self._settings = settings
        self._interfaces = solver.interfaces()
        self._keeps_state = keeps_state(solver)
        self._machine = StateMachine(self, settings.receives, self._interfaces,
                                     f"protocol {PROTOCOL_VERSION}")
        self._facets = ChangingFacets()
        for name in solver.facets() if settings.sends == "displacement" else ():
            self._facets.let_change(self._mesh(name))
        self.under_way = ""  # the solver's function that was called last

    @property
    def is_finished(self) -> bool:
        """Whether the run is over: there is no further request."""
        return self._machine.is_finished

    def answer(self, request: Message) -> Message:
        begin = time.monotonic()
        reply = self._machine.handle(request)
        reply.fields["busy_seconds"] = time.monotonic() - begin
        return reply

    def _call(self, name: str, *values: Any) -> Any:
        self.under_way = name
        return getattr(self._solver, name)(*values)

    def set_force_kinds(self, kinds: dict[str, str]) -> Message:
        if not takes_force_kinds(self._solver):
            raise ProtocolError('the coupler asked for "set_force_kinds" of a participant that takes none')
        self._call("set_force_kinds", kinds)
        return Message("force_kinds_set")

    def set_start(self, displacements: InterfaceValues) -> Message:
        if not takes_start(self._solver):
            raise ProtocolError('the coupler asked for "set_start" of a participant that takes none')
        self._call("set_start", displacements)
        return start_set(self._call("probes"))

    def set_facets(self, facets: InterfaceFacets) -> Message:
        if not takes_facets(self._solver):
            raise ProtocolError('the coupler asked for "set_facets" of a participant that takes none')
        self._call("set_facets", facets)
        return Message("facets_set")

    def _mesh(self, name: str) -> InterfaceMesh:
        for mesh in self._interfaces:
            if mesh.name == name:
                return mesh
        raise UsageError(f'facets: found interface "{name}", allowed: '
                         f"{', '.join(mesh.name for mesh in self._interfaces)}")

    def _put_changed_facets(self, reply: Message) -> None:
        """Add the facets of interfaces of a structure that got others than those that were sent last."""
        if self._settings.sends != "displacement":
            return
        facets = self._call("facets")
        if set(facets) != set(self._facets.now):
            raise UsageError(f"facets: found interfaces {sorted(facets)}, allowed: those of the beginning, "
                             f"{sorted(self._facets.now)}")
        for name, own in facets.items():
            self._facets.now[name] = checked_facets(self._mesh(name), own, "facets")
        self._facets.put_changed(reply)

    def solve_step(self, step: StepRequest, received: InterfaceValues) -> Message:
        try:
            values, report = checked_solution(self._call("solve_step", step, received))
        except ConvergenceError as problem:
            return Message("failed", fields={"reason": str(problem)})
        reply = solved(report)
        put_values(reply, self._settings.sends, self._interfaces, values)
        return reply

    def accept_step(self, step: StepRequest, was_solved: bool) -> Message:
        report = checked_report(self._call("accept_step", step, was_solved))
        reply = accepted(report, self._call("probes"))
        self._put_changed_facets(reply)
        return reply

    def reject_step(self) -> Message:
        self._call("reject_step")
        return Message("rejected")

    def write_output(self, time: float) -> Message:
        self._call("write_output", time)
        return Message("written")

    def save_state(self) -> Message:
        self._require_state("save")
        return saved(self._call("save_state"))

    def load_state(self, request: Message) -> Message:
        self._require_state("load")
        self._call("load_state", read_state(request))
        self._facets.forget()
        return loaded(self._call("probes"))

    def summarize(self) -> Message:
        return Message("summary", fields={"summary": plain(self._call("summary"))})

    def _require_state(self, kind: str) -> None:
        if not self._keeps_state:
            raise ProtocolError(f'the coupler asked for "{kind}" of a participant that keeps no state')


def serve(solver: Solver, settings: ParticipantSettings) -> None:
    """Carry out the coupler's requests until the run is finished.

    A ConvergenceError of solve_step is told to the coupler, which decides what to do. Any other exception is
    told to the coupler too, with its type and the function that raised it, ends the run and goes on to the
    caller. Raises ProtocolError: refused, coupler lost, run ended.
    """
    with Connection(settings) as connection:
        serve_over(solver, connection)


def introduce(solver: Solver, connection: Connection) -> None:
    """Do the handshake, with the solver's data."""
    sends_displacement = connection.settings.sends == "displacement"
    connection.handshake(Introduction(solver.interfaces(), solver.probe_names(), solver.probes(),
                                      keeps_state(solver), takes_force_kinds(solver),
                                      solver.start_displacements() if sends_displacement else {},
                                      takes_start(solver), takes_facets(solver),
                                      list(solver.facets()) if sends_displacement else ()))


def reason(problem: BaseException, under_way: str) -> str:
    """`KeyError: 'wall' (in solve_step)`; errors of this package name the function where that matters."""
    if says_all(problem) or not under_way:
        return text_of(problem)
    return f"{text_of(problem)} (in {under_way})"


def serve_over(solver: Solver, connection: Connection, give_on: Callable[[Message], None] | None = None) -> None:
    """Like serve(), over a connection that the caller made, so as to read run_settings() after its handshake. give_on:
    called with each request before it is answered (ranks.py)."""
    if connection.welcome is None:
        introduce(solver, connection)
    service = Service(solver, connection.settings)
    solver.begin_run(connection.run_settings())
    while True:
        request = connection.next_request()
        try:
            if give_on:
                give_on(request)
            reply = service.answer(request)
        except BaseException as problem:
            connection.abort(reason(problem, service.under_way))
            raise
        connection.reply(reply)
        if service.is_finished:
            break
    connection.close()
