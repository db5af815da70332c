# SPDX-License-Identifier: BSD-3-Clause
"""A solver seen from outside: meshes, requests, reports (protocol/README.md, sections 3 to 5)."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


# Kinds of interface forces: that at the end of a step, or its mean, which is to act as a constant load over the step
# (protocol/README.md, section 3).
END_OF_STEP, STEP_MEAN = "end_of_step", "step_mean"


@dataclass
class InterfaceMesh:
    """The surface through which a solver is coupled, in its reference configuration.

    coordinates: [m], num_vertices x dim
    facets: num_facets x 2, 3 or 4 vertex numbers from 0; None for bare points. Normals point out of the structure: in
    2D to the right when going from the first vertex to the second, in 3D by the right hand force_kind: of the forces
    that a soil sends: END_OF_STEP or STEP_MEAN
    """

    name: str
    coordinates: np.ndarray
    facets: np.ndarray | None = None
    force_kind: str = END_OF_STEP

    def __post_init__(self) -> None:
        self.coordinates = np.array(self.coordinates, dtype="<f8", ndmin=2)
        if self.facets is not None:
            self.facets = np.array(self.facets, dtype="<i8", ndmin=2)


# Interface name -> values at its vertices, num_vertices x dim: displacement [m], total from the reference
# configuration, or nodal force [N] of the soil on the structure (2D: per metre of thickness).
InterfaceValues = dict[str, np.ndarray]
# Interface name -> its facets, num_facets x 2, 3 or 4 vertex numbers, as those of InterfaceMesh.
InterfaceFacets = dict[str, np.ndarray]


@dataclass(frozen=True)
class StepRequest:
    """One solution of one step: from the accepted state at `time` [s] to `time + dt` [s]."""

    step: int  # 1, 2, 3, ...
    iteration: int  # of the coupling, 0 = first solution of this step
    time: float
    dt: float


@dataclass
class StepReport:
    """A solver's report on one solution, for the tables of the run."""

    newton_iterations: int = 0
    linear_iterations: int = 0
    interface_active: bool = True  # false: the received values cannot change this solution, whatever they are
    details: dict[str, float] = field(default_factory=dict)  # numbers for the log, by name


@dataclass
class AcceptReport:
    """A solver's report on an accepted step."""

    at_rest: bool = False  # nothing moves and the load is balanced: steps without new load may be skipped
    proposed_dt: float = 0.0  # [s], 0 = no opinion
    details: dict[str, float] = field(default_factory=dict)


class Solver(ABC):
    """A time-stepping solver for serve().

    A step is a function of the accepted state: the same `solve_step` after accept_step or
    reject_step gives the same bits. Whatever a
    solution changes must be restored before the next one, except by `accept_step`.
    """

    @abstractmethod
    def interfaces(self) -> list[InterfaceMesh]:
        """The coupled surfaces."""

    @abstractmethod
    def solve_step(self, request: StepRequest,
                   received: InterfaceValues) -> tuple[InterfaceValues, StepReport]:
        """Solve from the accepted state. `received`: values at the end of the step; empty means free
        interfaces.

        Returns the values to send, of all interfaces. Raises ConvergenceError when there is no solution: the
        coupler repeats the step with a smaller dt.
        """

    @abstractmethod
    def accept_step(self, request: StepRequest, solved: bool) -> AcceptReport:
        """Make the last solution the accepted state. `solved` false: this solver was skipped, only time goes
        on."""

    def begin_run(self, run: Mapping[str, Any]) -> None:
        """Optional: comes once, after the handshake, with the settings of the run: "output", the folder of the
        results, "end" and "dt" [s]; "check", true where nothing shall be written (protocol/README.md, section 4)."""

    def set_force_kinds(self, kinds: Mapping[str, str]) -> None:
        """Kinds of the forces that a structure will receive, by interface: END_OF_STEP or STEP_MEAN. Optional. The call
        comes before the first step, unless all are END_OF_STEP. Without it STEP_MEAN forces are taken for those of the
        end of the step, and the coupler warns."""
        raise NotImplementedError

    def start_displacements(self) -> InterfaceValues:
        """Displacements of the interfaces in the initial state [m], of a structure that begins displaced, such as
        in equilibrium with its weight; interfaces without any may be missing. Optional."""
        return {}

    def set_start(self, displacements: InterfaceValues) -> None:
        """Displacements with which the interfaces of a soil begin [m]. Optional. The call comes before the first step
        of a run that is no restart (a saved state has it), and only if any is displaced. Displacements that solve_step
        receives remain those from the reference. Without it the soil learns of them in its first step, and the coupler
        warns."""
        raise NotImplementedError

    def facets(self) -> InterfaceFacets:
        """All facets in the accepted state of the interfaces of a structure whose facets may leave, or come, where
        cells fail; each time the same interfaces. Their vertices are all that a facet may ever have. Optional."""
        return {}

    def set_facets(self, facets: InterfaceFacets) -> None:
        """Let these interfaces of a soil have other facets from now on, of the same vertices. Optional. The call comes
        between two steps; a saved state has them. Without it the coupler refuses structures with facets()."""
        raise NotImplementedError

    def reject_step(self) -> None:
        """Forget the last solution. Nothing to do where solve_step starts from the accepted state anyway."""

    def write_output(self, time: float) -> None:
        """Write the accepted state to disk; called at time 0 [s] too."""

    def save_state(self) -> bytes:
        """All of the accepted state that later steps depend on, in a form of the solver's own. Optional, with
        load_state: a run with this solver then keeps checkpoints and can be restarted."""
        raise NotImplementedError

    def load_state(self, state: bytes) -> None:
        """Go on from what save_state gave, in an earlier run perhaps: every later step gives the bits that it
        would have given there. Forgets the last solution."""
        raise NotImplementedError

    def probe_names(self) -> list[str]:
        """Names of the numbers that the run shall record of this solver."""
        return []

    def probes(self) -> list[float]:
        """Values of these numbers in the accepted state; NaN is allowed."""
        return []

    def summary(self) -> dict[str, Any]:
        """Methods that ran, counts, wall seconds, for the run's summary.json."""
        return {}
