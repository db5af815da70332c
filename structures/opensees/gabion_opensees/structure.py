# SPDX-License-Identifier: BSD-3-Clause
"""The structure behind the functions of the contract.

Loads are constant over a step, as mean forces ask for. Newmark's family has no constant load but between two
accelerations of its own, so each step begins with the acceleration of its load: where that jumps by dG, the
acceleration jumps by M^-1 dG. Of forces at the end of the step the constant load is the mean of the old and the new
one. Unknowns without mass, and all of a static procedure, take the forces at the end as they are.
"""

import csv
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from gabion_participant import (STEP_MEAN, AcceptReport, ConvergenceError, InterfaceMesh, InterfaceValues, Solver,
                                StepReport, StepRequest)

from .history import History
from .inertia import Inertia
from .model import Model
from .probes import Probes
from .settings import Settings
from .wet_surface import Description, Motion, make_wet_surface

MAX_ARMS = 20  # solutions of a step until the arms of the forces are those of its rotations


class Structure(Solver):
    """settings: structure.json. Raises SettingsError, OpenSeesError."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.model = Model(settings)
        self.description = Description(self.model.ask_accepted("describe"), self.model.variables)
        self.dimension = self.description.dimension
        self.surfaces = [make_wet_surface(self.description, entry) for entry in settings.interfaces]
        self.wet = list(dict.fromkeys(tag for surface in self.surfaces for tag in surface.tags))
        self.read = Probes(settings.probes, self.description, self.surfaces, self.wet)
        self.places = [[self.wet.index(tag) for tag in surface.tags] for surface in self.surfaces]
        self.width = max(self.description.nodes[tag][1] for tag in self.wet)
        self.inertia = self.make_inertia()
        self.mean_forces: set[str] = set()  # interfaces whose forces are means over the step
        self.steps = self.newton = self.solutions = 0
        self.frames: Path | None = None  # folder of the results
        self.begin()

    def make_inertia(self) -> Inertia | None:
        if self.settings.procedure == "static":
            return None
        return Inertia(self.model.mass(), self.wet, self.description.constrained, self.settings.max_unknowns)

    def begin(self) -> None:
        """The state that the model file leaves behind."""
        self.history = History()
        self.forces = self.zero_forces()  # of the accepted step, on the points
        self.loads = np.zeros((len(self.wet), self.width))  # of the accepted step, on the nodes
        answer = self.model.ask_accepted("watch", nodes=self.read.nodes, probes=self.read.orders)
        self.take(answer, [surface.at_rest for surface in self.surfaces])
        self.motions = [surface.motion(surface.at_rest, self.unknowns[place])
                        for surface, place in zip(self.surfaces, self.places)]
        self.read.update(self.moved(self.motions), answer["u"], answer["probes"])

    def take(self, answer: dict, motions: list[Motion]) -> None:
        """Unknowns and rates of the wet nodes, num_wet x width, and motions."""
        self.unknowns, self.rates = self.padded(answer["u"]), self.padded(answer["v"])
        self.motions = motions

    def padded(self, rows: list[list[float]]) -> np.ndarray:
        return np.array([row + [0.0] * (self.width - len(row)) for row in rows[:len(self.wet)]])

    def zero_forces(self) -> InterfaceValues:
        return {surface.name: np.zeros_like(surface.surface.offset) for surface in self.surfaces}

    def interfaces(self) -> list[InterfaceMesh]:
        return [surface.surface.interface(surface.name) for surface in self.surfaces]

    def start_displacements(self) -> InterfaceValues:
        return self.moved(self.motions)

    def set_force_kinds(self, kinds: Mapping[str, str]) -> None:
        self.mean_forces = {name for name, kind in kinds.items() if kind == STEP_MEAN}

    def solve_step(self, request: StepRequest,
                   received: InterfaceValues) -> tuple[InterfaceValues, StepReport]:
        self.trial_forces = self.zero_forces() | received
        motions = self.moved_by(self.unknowns + request.dt * self.rates)
        loads = self.nodal_loads(motions)
        iterations = 0
        for _ in range(MAX_ARMS):
            self.trial_step = (request.dt, self.listed(loads), self.jumps(loads))
            self.answer = self.model.trial(*self.trial_step)
            if "failed" in self.answer:
                raise ConvergenceError(f"OpenSees: {self.answer['failed']}")
            self.solutions += 1
            iterations += self.answer["iterations"]
            motions = self.moved_by(self.padded(self.answer["u"]))
            self.trial_loads, loads = loads, self.nodal_loads(motions)
            if np.abs(loads - self.trial_loads).max() <= self.settings.arm_tolerance * self.lever():
                break
        else:
            raise ConvergenceError(f"OpenSees: the arms of the forces have not settled in {MAX_ARMS} solutions")
        self.trial_motions, self.newton = motions, self.newton + iterations
        values = self.moved(motions)
        if not all(np.isfinite(value).all() for value in values.values()):
            raise ConvergenceError("OpenSees: the displacement is not finite")
        return values, StepReport(newton_iterations=iterations)

    def moved_by(self, unknowns: np.ndarray) -> list[Motion]:
        return [surface.motion(before, unknowns[place])
                for surface, before, place in zip(self.surfaces, self.motions, self.places)]

    def moved(self, motions: list[Motion]) -> InterfaceValues:
        return {surface.name: surface.displacement(motion) for surface, motion in zip(self.surfaces, motions)}

    def nodal_loads(self, motions: list[Motion]) -> np.ndarray:
        """num_wet x width, if the step ends with these motions. Over unknowns with mass the forces act all the step,
        at the mean of the old and the new arms, which gives their work; over others at its end."""
        acting, last = np.zeros_like(self.loads), np.zeros_like(self.loads)
        for surface, before, after, place in zip(self.surfaces, self.motions, motions, self.places):
            name, arms = surface.name, surface.surface.arms(after.rotation)
            force = self.trial_forces[name]
            mean = force if name in self.mean_forces else 0.5 * (self.forces[name] + force)
            middle = 0.5 * (surface.surface.arms(before.rotation) + arms)
            own = surface.loads(force, arms)
            last[place, :own.shape[1]] += own
            acting[place, :own.shape[1]] += surface.loads(mean, middle)
        return last if self.inertia is None else np.where(self.inertia.massive, acting, last)

    def lever(self) -> float:
        """A force times an offset [N m]: the largest of each."""
        return max(np.abs(self.trial_forces[surface.name]).max() * np.abs(surface.surface.offset).max()
                   for surface in self.surfaces)

    def listed(self, loads: np.ndarray) -> list[tuple[int, list[float]]]:
        return [(tag, row[:self.description.nodes[tag][1]].tolist()) for tag, row in zip(self.wet, loads)]

    def jumps(self, loads: np.ndarray) -> list:
        return [] if self.inertia is None else self.inertia.jumps(loads - self.loads)

    def accept_step(self, request: StepRequest, solved: bool) -> AcceptReport:
        if solved:
            element_values = self.model.accept()
            self.history.append(*self.trial_step)
            self.take(self.answer, self.trial_motions)
            self.forces, self.loads = self.trial_forces, self.trial_loads
            self.read.update(self.moved(self.motions), self.answer["u"], element_values)
            self.steps += 1
        return AcceptReport()

    def reject_step(self) -> None:
        self.model.reject()

    def write_output(self, time: float) -> None:
        """All nodes of the model, a row each: displacement [m]."""
        if self.frames is None:
            return
        axes = "xyz"[:self.dimension]
        table = self.frames / "nodes.csv"
        begin = not table.exists()
        moved = self.model.ask_accepted("frame")["u"]
        with table.open("a", newline="", encoding="utf-8") as out:
            rows = csv.writer(out)
            if begin:
                rows.writerow(["time", "node", *axes, *(f"u{axis}" for axis in axes)])
            rows.writerows([time, tag, *place, *moved[tag][:self.dimension]]
                           for tag, (place, _) in self.description.nodes.items())

    def save_state(self) -> bytes:
        head = {"model": self.fingerprint(), "steps": self.steps, "loads": self.loads.tolist(),
                "forces": {name: value.tolist() for name, value in self.forces.items()},
                "rotations": [None if motion.rotation is None else motion.rotation.tolist() for motion in self.motions]}
        return json.dumps(head).encode() + b"\n" + self.history.to_bytes()

    def load_state(self, state: bytes) -> None:
        """The accepted steps again, in a fresh model."""
        first, _, rest = state.partition(b"\n")
        saved = json.loads(first)
        if saved["model"] != self.fingerprint():
            raise ValueError(f"{self.settings.model}: found another model or OpenSees, or other interfaces, procedure "
                             "or commands in structure.json, allowed: those of the run that is continued")
        self.model.restart()
        self.begin()
        self.history = History.from_bytes(rest)
        for steps in self.history.steps():
            answer = self.model.ask_accepted("replay", steps=steps)
            self.take(answer, self.motions)
        self.steps = saved["steps"]
        self.loads = np.array(saved["loads"])
        self.forces = {name: np.array(value) for name, value in saved["forces"].items()}
        if self.steps:
            self.motions = [self.with_rotation(motion, rotation)
                            for motion, rotation in zip(self.moved_by(self.unknowns), saved["rotations"])]
            self.read.update(self.moved(self.motions), answer["u"], answer["probes"])

    @staticmethod
    def with_rotation(motion: Motion, rotation: list | None) -> Motion:
        return Motion(motion.u, motion.angles, None if rotation is None else np.array(rotation))

    def fingerprint(self) -> str:
        """Hash of all that the state depends on."""
        physics = [self.settings.analysis(), self.settings.arm_tolerance, self.settings.interfaces,
                   self.description.version, self.settings.model.read_text(encoding="utf-8")]
        return hashlib.sha256(json.dumps(physics).encode()).hexdigest()

    def probe_names(self) -> list[str]:
        return self.read.names

    def probes(self) -> list[float]:
        return self.read.values

    def summary(self) -> dict:
        return {"program": f"OpenSees {self.description.version}", "steps": self.steps, "solutions": self.solutions,
                "newton_iterations": self.newton, "nodes": len(self.description.nodes),
                "elements": len(self.description.elements)}
