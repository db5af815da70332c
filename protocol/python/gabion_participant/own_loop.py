# SPDX-License-Identifier: BSD-3-Clause
"""The coupler's requests for a code that keeps its own time loop."""

from collections.abc import Callable
from typing import Any

import numpy as np

from .errors import ProtocolError
from .facets import ChangingFacets
from .handshake import accepted, loaded, plain, read_state, saved, start_set
from .message import Message
from .solver import STEP_MEAN, AcceptReport, InterfaceFacets, InterfaceMesh, InterfaceValues, StepRequest
from .state_machine import RequestHandler, unknown

ME = "this participant"  # in messages


class OwnLoop(RequestHandler):
    """The current step, as the coupler asked for it and as the code has answered. An answer is pending while it waits
    for the code, which may have to go back first."""

    def __init__(self) -> None:
        self.output: Callable[[float], None] | None = None
        self.take_start: Callable[[InterfaceValues], None] | None = None  # None: does not take one
        self.take_facets: Callable[[InterfaceFacets], None] | None = None  # None: does not take others
        self.facets = ChangingFacets()
        self.save: Callable[[], bytes] | None = None  # None: does not keep its state
        self.load: Callable[[bytes], None] | None = None
        self.summary: dict[str, Any] = {}
        self.probes: dict[str, float] = {}  # of the code's current state
        self.accepted_probes: list[float] = []
        self.request: StepRequest | None = None  # the open solve_step
        self.force_kinds: dict[str, str] = {}  # of the received forces
        self.asked_force_kind = False
        self.received: InterfaceValues = {}
        self.written: InterfaceValues = {}
        self.remaining = 0.0  # [s] of the open step
        self.awaits_verdict = False  # the last solve_step was answered, neither accepted nor rejected
        self.pending: Message | None = None
        self.must_write = self.must_read = False  # checkpoints that were not asked for yet
        self.window_complete = False

    def is_inside_step(self) -> bool:
        return self.awaits_verdict

    def set_force_kinds(self, kinds: dict[str, str]) -> Message:
        self.force_kinds = kinds
        return Message("force_kinds_set")

    def set_start(self, displacements: InterfaceValues) -> Message:
        if not self.take_start:
            raise unknown("set_start", ME)
        self.take_start(displacements)
        self.accepted_probes = list(self.probes.values())
        self.must_write = True  # a state that the code may have saved began at the reference
        return start_set(self.accepted_probes)

    def set_facets(self, facets: InterfaceFacets) -> Message:
        if not self.take_facets:
            raise unknown("set_facets", ME)
        self.take_facets(facets)
        self.must_write = True  # a state that the code may have saved has the facets before
        return Message("facets_set")

    def write_facets(self, mesh: InterfaceMesh, facets: np.ndarray) -> None:
        self.facets.write(mesh, facets, accepted=self.pending is not None and self.window_complete)

    def unnoticed_means(self) -> list[str]:
        """Interfaces whose forces are means over the step, where the code never asked for that; once."""
        asked, self.asked_force_kind = self.asked_force_kind, True
        return [] if asked else [name for name, kind in self.force_kinds.items() if kind == STEP_MEAN]

    def solve_step(self, step: StepRequest, received: InterfaceValues) -> None:
        self.must_read |= self._had_trial()
        self.received, self.written = received, {}
        self.request, self.remaining = step, step.dt

    def close_step(self) -> None:
        """Note that the open solve_step is answered."""
        self.request, self.remaining, self.awaits_verdict = None, 0.0, True

    def accept_step(self, _step: StepRequest, was_solved: bool) -> Message | None:
        had_trial = self._had_trial()
        if had_trial and not was_solved:
            self.must_read = True  # accepted as if it had not been asked: the accepted state stays
        elif had_trial:
            self.accepted_probes = list(self.probes.values())
            self.must_write = self.window_complete = True
        return self._now_or_pending(accepted(AcceptReport(), self.accepted_probes), had_trial)

    def reject_step(self) -> Message | None:
        had_trial = self._had_trial()
        self.must_read |= had_trial
        return self._now_or_pending(Message("rejected"), had_trial)

    def write_output(self, time: float) -> Message:
        if self.awaits_verdict and self.output:
            raise ProtocolError("the coupler wants the accepted state on disk in the middle of a step: "
                                "this participant writes it between steps only")
        if self.output:
            self.output(time)
        return Message("written")

    def save_state(self) -> Message:
        if not self.save:
            raise unknown("save", ME)
        return saved(self.save())

    def load_state(self, request: Message) -> Message:
        if not self.load:
            raise unknown("load", ME)
        self.facets.while_loading(lambda: self.load(read_state(request)))
        self.accepted_probes = list(self.probes.values())
        self.must_write = True  # the state that the code saved for repeated steps is another one
        return loaded(self.accepted_probes)

    def summarize(self) -> Message:
        return Message("summary", fields={"summary": plain(self.summary)})

    def _had_trial(self) -> bool:
        """Whether a solution waited for its verdict, which has come now."""
        had, self.awaits_verdict = self.awaits_verdict, False
        return had

    def _now_or_pending(self, answer: Message, waits: bool) -> Message | None:
        if not waits:
            return answer
        self.pending = answer
        return None
