# SPDX-License-Identifier: BSD-3-Clause
"""The state machine of a participant: which request is allowed when, and what carries it out (protocol/README.md,
section 5)."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from .errors import ProtocolError
from .facets import read_facets
from .handshake import is_asked_for, read_force_kinds, read_step_request, read_values
from .message import Message
from .solver import InterfaceFacets, InterfaceMesh, InterfaceValues, StepRequest
from .step_order import StepOrder


class RequestHandler(ABC):
    """Actions of one kind of participant at each request. The answer None: it follows later."""

    @abstractmethod
    def set_force_kinds(self, kinds: dict[str, str]) -> Message | None:
        """Take the kinds of the forces that will be received, by interface."""

    def set_start(self, displacements: InterfaceValues) -> Message | None:
        """Take the displacements with which the interfaces begin."""
        raise ProtocolError('the coupler asked for "set_start" of a participant that takes none')

    def set_facets(self, facets: InterfaceFacets) -> Message | None:
        """Take other facets of some interfaces."""
        raise ProtocolError('the coupler asked for "set_facets" of a participant that takes none')

    @abstractmethod
    def solve_step(self, step: StepRequest, received: InterfaceValues) -> Message | None:
        """Solve from the accepted state."""

    @abstractmethod
    def accept_step(self, step: StepRequest, was_solved: bool) -> Message | None:
        """Make the last solution the accepted state; not `was_solved`: only time advances."""

    @abstractmethod
    def reject_step(self) -> Message | None:
        """Forget the last solution."""

    @abstractmethod
    def write_output(self, time: float) -> Message | None:
        """Write the accepted state, at this time [s]."""

    @abstractmethod
    def save_state(self) -> Message | None:
        """Save the accepted state."""

    @abstractmethod
    def load_state(self, request: Message) -> Message | None:
        """Load another accepted state."""

    @abstractmethod
    def summarize(self) -> Message | None:
        """The participant's entry in summary.json."""

    def is_inside_step(self) -> bool:
        """Whether the code's current state may be another one than the accepted one."""
        return False


def unknown(kind: str, me: str) -> ProtocolError:
    """Refuse a request of an unknown type."""
    return ProtocolError(f'the coupler asked for "{kind}", which {me} does not know')


class StateMachine:
    """Serves all kinds of participants. `me`: name of this one in the message about an unknown request."""

    def __init__(self, handler: RequestHandler, receives: str, interfaces: Sequence[InterfaceMesh],
                 me: str) -> None:
        self._handler = handler
        self._receives, self._interfaces = receives, interfaces
        self._me = me
        self._order = StepOrder()
        self._proposed_dt = 0.0  # [s] by the last answer to accept_step
        self.is_finished = False  # "finish" was asked: there is no further request
        # type: (what does it, whether it is allowed while a solution waits for its verdict)
        self._rules = {
            "solve_step": (self._solve, True), "accept_step": (self._accept, True),
            "reject_step": (self._reject, True), "write_output": (self._write, True),
            "summarize": (lambda _: handler.summarize(), True),
            "save": (lambda _: handler.save_state(), False), "load": (self._load, False),
            "set_force_kinds": (self._set_force_kinds, False), "set_start": (self._set_start, False),
            "set_facets": (self._set_facets, False),
            "finish": (self._finish, True)}

    def handle(self, request: Message) -> Message | None:
        """Have the request carried out. Returns the answer; None: it follows later. Raises ProtocolError: not known,
        not allowed now, or not complete."""
        if request.type not in self._rules:
            raise unknown(request.type, self._me)
        action, inside_step = self._rules[request.type]
        if not inside_step and (self._order.has_solution or self._handler.is_inside_step()):
            raise ProtocolError(f'the coupler asked for "{request.type}" in the middle of a step')
        return action(request)

    def solved(self, step: StepRequest) -> None:
        """Note an answer "solved" that followed later."""
        self._order.solved(step)

    def _set_force_kinds(self, request: Message) -> Message | None:
        return self._handler.set_force_kinds(read_force_kinds(request, self._interfaces))

    def _set_start(self, request: Message) -> Message | None:
        if self._order.has_begun:
            raise ProtocolError('the coupler asked for "set_start" after an accepted step')
        return self._handler.set_start(read_values(request, self._receives, self._interfaces))

    def _set_facets(self, request: Message) -> Message | None:
        return self._handler.set_facets(read_facets(request, self._interfaces))

    def _solve(self, request: Message) -> Message | None:
        if not is_asked_for(request, self._proposed_dt):
            return Message("passed")
        step = read_step_request(request)
        received = read_values(request, self._receives, self._interfaces)
        self._order.check(step)
        self._order.reject()
        answer = self._handler.solve_step(step, received)
        if answer and answer.type == "solved":
            self._order.solved(step)
        return answer

    def _accept(self, request: Message) -> Message | None:
        step, was_solved = read_step_request(request), request.boolean("solved")
        if "write_output" in request.fields and request.boolean("write_output"):
            raise ProtocolError('the coupler asks for output by "accept_step", allowed: by "write_output"')
        self._order.accept(step, was_solved)
        answer = self._handler.accept_step(step, was_solved)
        self._proposed_dt = answer.number("proposed_dt") if answer else 0.0  # one that follows later has none
        return answer

    def _reject(self, _request: Message) -> Message | None:
        answer = self._handler.reject_step()
        self._order.reject()
        return answer

    def _write(self, request: Message) -> Message | None:
        return self._handler.write_output(request.number("time"))

    def _load(self, request: Message) -> Message | None:
        answer = self._handler.load_state(request)
        self._order.forget()
        return answer

    def _finish(self, _request: Message) -> Message:
        self.is_finished = True
        return Message("finished")
