# SPDX-License-Identifier: BSD-3-Clause
"""A model behind the functions of the contract, on every rank.

The accepted state is `motion` and the history fields; a solution changes neither. So it is repeated, rejected or cut by
doing nothing.
"""

import hashlib
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from gabion_participant import (STEP_MEAN, AcceptReport, ConvergenceError, InterfaceMesh, InterfaceValues, Solver,
                                StepReport, StepRequest)

from .balance import Balance, Factor
from .model import Model, ModelError, check_model
from .motion import Bossak, Motion
from .output import Output
from .wet_surface import make_wet_surface

Residual = tuple[np.ndarray, float]  # of the free unknowns, and its norm over all ranks
SHORTEST = 1 / 256  # share of a step of Newton's method
KEEP = 0.25  # a factor is kept while the residual falls by more than this an iteration


class Structure(Solver):
    """name: of the participant; source: of the model, compared at a restart. Raises ModelError, and
    ConvergenceError of the initial state."""

    def __init__(self, model: Model, comm: Any, source: str = "", name: str = "structure") -> None:
        self.model, self.source, self.name = model, source, name
        domain = model.mesh(comm)
        self.comm, self.dimension = comm, domain.geometry.dim
        check_model(model, self.dimension)
        self.balance = Balance(model, domain)
        V = self.balance.V
        self.surfaces = [make_wet_surface(V, name, marker) for name, marker in model.interfaces().items()]
        self.probe_nodes = {name: self.node_at(name, place) for name, place in model.probes().items()}
        self.scheme = Bossak(model.bossak_alpha)
        self.mean_forces: set[str] = set()
        self.first, self.later = Factor(self.balance), Factor(self.balance)
        self.first_of: tuple[Motion, float] | None = None  # what the first factor is of: accepted motion, dt
        self.mass = self.balance.mass_factor()
        self.rounding = self.balance.rounding(self.later)
        self.output: Output | None = None
        self.steps = self.newton = self.factored = 0
        self.motion = self.trial = self.begin()
        self.trial_dt = 0.0

    def node_at(self, name: str, place) -> int:
        """Node of this rank at a place; -1 where another rank owns it."""
        V = self.balance.V
        nodes = V.tabulate_dof_coordinates()[:V.dofmap.index_map.size_local, :self.dimension]
        away = np.linalg.norm(nodes - np.asarray(place, dtype=float), axis=1)
        nearest = self.comm.allgather(away.min(initial=np.inf))
        size = np.ptp(np.concatenate([surface.coordinates for surface in self.surfaces]), axis=0).max()
        if not min(nearest) < 1e-6 * size:
            raise ModelError(f'probe "{name}": found the nearest node {min(nearest):.3g} m away from {tuple(place)}, '
                             "allowed: a node")
        return int(away.argmin()) if self.comm.rank == int(np.argmin(nearest)) else -1

    def begin(self) -> Motion:
        """Motion in balance with the weight, or at u = 0 with M a = weight - f_int."""
        zero = np.zeros(self.balance.size)
        rest = Motion(zero, zero, zero, zero)
        if self.model.initial_equilibrium:
            u, _ = self.solve(rest, self.balance.weight, 0.0)
            self.balance.set_u(u)
            self.balance.history.renew()
            return Motion(u, zero, zero, zero)
        missing = self.balance.weight - self.balance.internal_forces(zero)
        return Motion(zero, zero, self.mass.solve(missing), zero)

    def interfaces(self) -> list[InterfaceMesh]:
        return [InterfaceMesh(surface.name, surface.coordinates, surface.facets) for surface in self.surfaces]

    def start_displacements(self) -> InterfaceValues:
        return self.surface_values(self.motion.u)

    def begin_run(self, run: Mapping[str, Any]) -> None:
        if not run.get("check") and "output" in run:
            self.output = Output(self.balance, Path(run["output"]) / self.name)

    def set_force_kinds(self, kinds: Mapping[str, str]) -> None:
        self.mean_forces = {name for name, kind in kinds.items() if kind == STEP_MEAN}

    def nodal_forces(self, received: InterfaceValues) -> tuple[np.ndarray, np.ndarray]:
        """Nodal forces at the end of the step, and mean ones."""
        end, mean = np.zeros((2, self.balance.size // self.dimension, self.dimension))
        for surface in self.surfaces:
            if surface.name in received:
                into = mean if surface.name in self.mean_forces else end
                into[surface.nodes] += received[surface.name][surface.vertices]
        return end.ravel(), mean.ravel()

    def solve_step(self, request: StepRequest, received: InterfaceValues) -> tuple[InterfaceValues, StepReport]:
        end, mean = self.nodal_forces(received)
        load = self.scheme.load(self.balance.weight + end, mean, self.motion.F)
        u, iterations = self.solve(self.motion, load, request.dt)
        v, a = self.scheme.end(self.motion, u - self.motion.u, request.dt)
        self.trial, self.trial_dt = Motion(u, v, a, mean), request.dt
        self.newton += iterations
        return self.surface_values(u), StepReport(newton_iterations=iterations)

    def surface_values(self, u: np.ndarray) -> InterfaceValues:
        nodal = u.reshape(-1, self.dimension)
        values = {}
        for surface in self.surfaces:
            part = np.zeros_like(surface.coordinates)
            part[surface.vertices] = nodal[surface.nodes]
            values[surface.name] = self.comm.allreduce(part)
        return values

    def solve(self, old: Motion, load: np.ndarray, dt: float) -> tuple[np.ndarray, int]:
        """u at the end of the step, and Newton's iterations; dt 0: in static balance.

        Starts from the accepted state and with the factor of its tangent, which serves all solutions of the step.
        Where a step of Newton's method with this factor has to be shortened, the factor of the present tangent follows.
        """
        u, factor, before = old.u + dt * old.v, None, np.inf
        residual, scale = self.residual(old, u, load, dt)
        if not np.isfinite(residual[1]):
            raise ConvergenceError("the guess of Newton's method: forces are not finite")
        for iteration in range(self.model.newton_iterations + 1):
            allowed = max(self.model.newton_tolerance * scale, self.rounding)
            if residual[1] <= allowed:
                return u, iteration
            if factor is None:
                factor = self.first_factor(old, u, dt)
            elif residual[1] > KEEP * before:
                factor = self.later
                self.refactor(factor, u, dt)
            before = residual[1]
            step = factor.solve(residual[0])
            before_step = u
            share, (residual, scale) = self.line_search(
                residual, step, lambda s: self.residual(old, before_step + s * step, load, dt))
            u = before_step + share * step
            if share < 1:
                before = 0.0  # a new factor
        raise ConvergenceError(f"no balance after {iteration} iterations of Newton: residual {residual[1]:.3g} N, "
                               f"allowed {allowed:.3g}")

    def line_search(self, start: Residual, step: np.ndarray, at: Callable[[float], tuple[Residual, float]]
                    ) -> tuple[float, tuple[Residual, float]]:
        """The first share s = 1, 1/2, ... of a step at which forces are finite and |step . r(s)| <= 0.8 |step . r(0)|
        or |r| has fallen, and the residual there (Matthies and Strang 1979: the energy, since |r| rises with a good
        step of a slender structure). The last one, SHORTEST, is taken where none is so good.
        """
        energy = abs(self.balance.dot(step, start[0]))
        share = 1.0
        while True:
            found = at(share)
            residual = found[0]
            finite = np.isfinite(residual[1])
            if finite and (residual[1] < start[1] or abs(self.balance.dot(step, residual[0])) <= 0.8 * energy):
                return share, found
            if share <= SHORTEST:
                if not finite:
                    raise ConvergenceError(f"{share} of a step of Newton's method: forces are not finite")
                return share, found
            share /= 2

    def residual(self, old: Motion, u: np.ndarray, load: np.ndarray,
                 dt: float) -> tuple[Residual, float]:
        """Residual of free unknowns with its norm, and the largest norm of the forces that are balanced."""
        internal = self.balance.internal_forces(u)
        inertia = np.zeros_like(u)
        if dt:
            _, a = self.scheme.end(old, u - old.u, dt)
            inertia = self.balance.mass_times(self.scheme.mean_acceleration(a, old.a))
        missing = np.where(self.balance.held, 0.0, load - internal - inertia)
        size, *sizes = self.balance.norms(missing, internal, inertia, load)
        return (missing, size), max(sizes)

    def first_factor(self, old: Motion, u: np.ndarray, dt: float) -> Factor:
        if self.first_of is None or self.first_of[0] is not old or self.first_of[1] != dt:
            self.refactor(self.first, u, dt)
            self.first_of = (old, dt)
        return self.first

    def refactor(self, factor: Factor, u: np.ndarray, dt: float) -> None:
        factor.assemble(u, self.scheme.slope(dt) if dt else 0.0)
        self.factored += 1

    def accept_step(self, request: StepRequest, solved: bool) -> AcceptReport:
        if solved:
            change = self.trial.F - self.motion.F
            changed = self.balance.norms(change)[0] > 0
            self.balance.set_u(self.trial.u)
            self.balance.history.renew()
            self.motion = self.scheme.corrected(self.trial, self.mass.solve(change), self.trial_dt) if changed \
                else self.trial
            self.steps += 1
        return AcceptReport(at_rest=bool(self.comm.allreduce(int(not self.motion.is_still())) == 0))

    def write_output(self, time: float) -> None:
        if self.output:
            self.balance.set_u(self.motion.u)
            self.output.write(time)

    def state_arrays(self) -> dict[str, np.ndarray]:
        motion = {f"motion.{name}": getattr(self.motion, name) for name in ("u", "v", "a", "F")}
        return motion | {f"field.{name}": array for name, array in self.balance.history.arrays().items()}

    def save_state(self) -> bytes:
        """State of all ranks, on rank 0; each rank takes its own part back."""
        parts, fingerprint = self.comm.gather(self.state_arrays()), self.fingerprint()
        if self.comm.rank:
            return b""
        content = {f"{rank}.{name}": array for rank, part in enumerate(parts) for name, array in part.items()}
        content |= {"steps": np.array(self.steps), "fingerprint": np.array(fingerprint)}
        file = io.BytesIO()
        np.savez(file, **content)
        return file.getvalue()

    def load_state(self, state: bytes) -> None:
        with np.load(io.BytesIO(state)) as saved:
            if str(saved["fingerprint"]) != self.fingerprint():
                raise ValueError(f"structure: found another model, mesh or number of ranks (here {self.comm.size}), "
                                 "allowed: those of the run that is continued")
            mine = {name: saved[f"{self.comm.rank}.{name}"] for name in self.state_arrays()}
            self.steps = int(saved["steps"])
        self.motion = self.trial = Motion(*(mine[f"motion.{name}"] for name in ("u", "v", "a", "F")))
        for name, array in self.balance.history.arrays().items():
            array[:] = mine[f"field.{name}"]

    def fingerprint(self) -> str:
        """Hash of all that the state depends on: the model's text, and which nodes are where."""
        places = self.balance.V.tabulate_dof_coordinates()
        parts = self.comm.allgather(hashlib.sha256(places.tobytes()).hexdigest())
        return hashlib.sha256("\n".join([self.source, *parts]).encode()).hexdigest()

    def probe_names(self) -> list[str]:
        return [f"{name}.u{axis}" for name in self.probe_nodes for axis in "xyz"[:self.dimension]]

    def probes(self) -> list[float]:
        nodal = self.motion.u.reshape(-1, self.dimension)
        values = [nodal[node] if node >= 0 else np.zeros(self.dimension) for node in self.probe_nodes.values()]
        return self.comm.allreduce(np.array(values)).ravel().tolist()

    def summary(self) -> dict:
        return {"program": "dolfinx", "ranks": self.comm.size, "steps": self.steps, "newton_iterations": self.newton,
                "factorisations": self.factored,
                "unknowns": self.balance.V.dofmap.index_map.size_global * self.dimension}
