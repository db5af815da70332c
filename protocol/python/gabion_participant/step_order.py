# SPDX-License-Identifier: BSD-3-Clause
"""The order of the coupler's requests."""

import sys

from .errors import ProtocolError
from .solver import StepRequest


class StepOrder:
    """Checks that a step starts where the last accepted one ended, and that the accepted step is the solved one. All
    functions that check raise ProtocolError."""

    def __init__(self) -> None:
        self._accepted: StepRequest | None = None  # None before the first accepted step
        self._solution: StepRequest | None = None

    @property
    def has_solution(self) -> bool:
        return self._solution is not None

    @property
    def has_begun(self) -> bool:
        """Whether a step was accepted, since the last state was loaded."""
        return self._accepted is not None

    def check(self, request: StepRequest) -> None:
        """Check the request before a solution, and before a step that is accepted without one."""
        if not self._accepted:
            return
        last = self._accepted
        if request.step != last.step + 1:
            raise ProtocolError(f"the coupler asks for step {request.step} after step {last.step} was accepted, "
                                f"expected step {last.step + 1}")
        end = last.time + last.dt
        allowed = 1e-6 * request.dt + 8 * sys.float_info.epsilon * abs(request.time)  # times are rounded sums
        if abs(request.time - end) > allowed:
            raise ProtocolError(f"the coupler asks for step {request.step} from {request.time} s, but the "
                                f"accepted state is that of {end} s")

    def solved(self, request: StepRequest) -> None:
        """Note that `request` has a solution."""
        self._solution = request

    def accept(self, request: StepRequest, with_solution: bool) -> None:
        """Note an accepted step; `with_solution` false: the participant was skipped."""
        self.check(request)
        if with_solution:
            found = self._solution
            if found is None:
                raise ProtocolError(f"the coupler accepts step {request.step}, which has no solution")
            if (request.step, request.time, request.dt) != (found.step, found.time, found.dt):
                raise ProtocolError(f"the coupler accepts step {request.step} with dt {request.dt} s, but the "
                                    f"solution is that of step {found.step} with dt {found.dt} s")
        self._accepted, self._solution = request, None

    def reject(self) -> None:
        """Forget the last solution."""
        self._solution = None

    def forget(self) -> None:
        """Forget the order: the accepted state was loaded, and is one of any step."""
        self._accepted = self._solution = None
