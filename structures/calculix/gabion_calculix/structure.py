# SPDX-License-Identifier: BSD-3-Clause
"""The structure behind the five functions of the contract: a run of ccx for each solution.

The accepted state is one file, step.rin: ccx reads it, writes step.rout, and accept_step renames that. So a solution is
repeated, rejected or cut by doing nothing.

Each step begins with the acceleration of its load and its state, M a = G - f_int: ccx has no other one after a restart.
G is constant over the step. That is what a mean force asks for; of forces at the end of the step G is the mean of the
old and the new one, which is the trapezoidal rule (alpha = 0) with forces that vary linearly.
"""

import base64
import csv
import hashlib
import json
import os
import shutil
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from gabion_participant import (STEP_MEAN, AcceptReport, ConvergenceError, InterfaceMesh, InterfaceValues, Solver,
                                StepReport, StepRequest)

from .ccx import Ccx, NoSolution
from .deck import DeckError, read_deck
from .job import (Load, check_deck, check_dynamics, check_nlgeom, coupled_step, has_steps, loads_of, model_text,
                  own_steps, with_output, with_section_forces)
from .reactions import append_reactions, read_reactions
from .restart_file import NodalState, limit_reserve, read_nodal_state
from .section_forces import append_section_forces, beam_nodes, read_section_forces
from .settings import Settings
from .wet_surface import WetSurface, make_wet_surface

JOB = "step"
READ = "*RESTART, READ"


class Structure(Solver):
    """settings: structure.json; folder: scratch, of this run alone. Raises DeckError, CcxError."""

    def __init__(self, settings: Settings, folder: Path) -> None:
        self.settings, self.folder = settings, folder
        self.deck = read_deck(settings.deck)
        self.surfaces = [make_wet_surface(self.deck, part.name, part.surface, part.element_set)
                         for part in settings.interfaces]
        self.dimension = one_dimension(self.surfaces)
        self.check_probes()
        self.check_tables()
        check_deck(self.deck, self.surfaces)
        check_nlgeom(self.deck, settings.nlgeom)
        if settings.procedure == "dynamic":
            check_dynamics(self.deck)
        self.ccx = Ccx(settings, folder)
        self.mean_forces: set[str] = set()  # interfaces whose forces are means over the step
        self.forces: InterfaceValues = self.zero_forces()  # of the accepted step
        self.trial_forces = self.forces
        self.trial_job, self.accepted_job = "", ""
        self.steps = self.newton = 0
        self.frames: Path | None = None  # folder of the results
        self.reserve: int | None = None  # of multi-point constraints in restart files
        self.accepted = self.trial = self.begin()

    def begin(self) -> NodalState:
        """State after the deck's own steps, such as its weight; at rest where it has none."""
        self.state_file.unlink(missing_ok=True)
        if has_steps(self.deck):
            try:
                self.ccx.run(JOB, own_steps(self.deck, loads_of(self.surfaces, {})))
            except NoSolution as problem:
                raise DeckError(f"{self.settings.deck}: found no solution of its own steps: {problem}") from problem
            return self.take_result()
        zero = np.zeros((max(self.deck.nodes), 3))
        return NodalState(zero, zero)

    def check_probes(self) -> None:
        """Nodes of solids and wet nodes: of others ccx keeps no displacement."""
        wet = {node for surface in self.surfaces for node in surface.nodes.tolist()}
        solid = {node for element in self.deck.elements.values() if element.type.startswith("C3D")
                 for node in element.nodes}
        for probe in self.settings.probes:
            if probe.node not in wet | solid:
                raise DeckError(f'{self.settings.deck}: found probe "{probe.name}" at node {probe.node}, allowed: '
                                "nodes of the wet surface or of solids")

    def check_tables(self) -> None:
        """ccx writes stresses in place of section forces at nodes that beams share with other elements."""
        for name in self.settings.reactions:
            if name not in self.deck.node_sets:
                raise DeckError(f"{self.settings.deck}: found no node set {name} for reactions, allowed: "
                                f"{', '.join(self.deck.node_sets) or 'none'}")
        if not self.settings.section_forces:
            return
        beams = set(beam_nodes(self.deck))
        others = {node for element in self.deck.elements.values() if not element.type.startswith("B")
                  for node in element.nodes}
        if not beams or beams & others:
            found = f"node {min(beams & others)} of beams and of others" if beams else "no beams"
            raise DeckError(f'{self.settings.deck}: found {found} for "section_forces": true, allowed: beams with '
                            'nodes '
                            "of their own")

    def zero_forces(self) -> InterfaceValues:
        return {surface.name: np.zeros_like(surface.coordinates) for surface in self.surfaces}

    def interfaces(self) -> list[InterfaceMesh]:
        return [InterfaceMesh(surface.name, surface.coordinates, surface.facets) for surface in self.surfaces]

    def start_displacements(self) -> InterfaceValues:
        return self.wet_displacements()

    def set_force_kinds(self, kinds: Mapping[str, str]) -> None:
        self.mean_forces = {name for name, kind in kinds.items() if kind == STEP_MEAN}

    def constant_forces(self, received: InterfaceValues) -> InterfaceValues:
        """G of the step; statics know the end of the step only."""
        return {name: value if name in self.mean_forces or self.settings.procedure == "static"
                else 0.5 * (self.forces[name] + value) for name, value in received.items()}

    def solve_step(self, request: StepRequest,
                   received: InterfaceValues) -> tuple[InterfaceValues, StepReport]:
        self.trial_forces = self.zero_forces() | received
        begin = READ if self.state_file.exists() else model_text(self.deck)
        loads = loads_of(self.surfaces, self.constant_forces(self.trial_forces))
        iterations = self.run_in_increments(begin, request.dt, loads)
        self.trial = read_nodal_state(self.folder / f"{JOB}.rout")
        values = self.wet_displacements()
        if not all(np.isfinite(value).all() for value in values.values()):
            raise ConvergenceError("ccx: the displacement is not finite")
        self.newton += iterations
        return values, StepReport(newton_iterations=iterations)

    def run_in_increments(self, begin: str, dt: float, loads: list[Load]) -> int:
        """Run in one increment, or in 4, 16, ... where there is no solution. @returns iterations"""
        increments = 1
        while True:
            self.trial_job = coupled_step(self.settings, begin, (dt, increments), loads)
            try:
                return self.ccx.run(JOB, self.trial_job)
            except NoSolution as problem:
                increments *= 4
                if increments > self.settings.max_increments:
                    raise ConvergenceError(str(problem)) from problem

    def wet_displacements(self) -> InterfaceValues:
        return {surface.name: self.trial.displacement[surface.nodes - 1, :self.dimension]
                for surface in self.surfaces}

    def accept_step(self, request: StepRequest, solved: bool) -> AcceptReport:
        if solved:
            if self.state_file.exists():
                os.replace(self.state_file, self.folder / "output.rin")
            self.trial = self.take_result()
            self.accepted, self.forces = self.trial, self.trial_forces
            self.accepted_job = self.trial_job
            self.steps += 1
        return AcceptReport()

    @property
    def state_file(self) -> Path:
        return self.folder / f"{JOB}.rin"

    def take_result(self) -> NodalState:
        """Make the state that ccx wrote the accepted one."""
        os.replace(self.folder / f"{JOB}.rout", self.state_file)
        self.reserve = limit_reserve(self.state_file, self.reserve)
        return read_nodal_state(self.state_file)

    def write_output(self, time: float) -> None:
        """A .frd of the accepted step: solved once more, as ccx writes fields only while it solves. Before the
        first step, and after a restart until the next one, there is none to solve."""
        if self.frames is None or not self.accepted_job:
            return
        table = self.frames / "frames.csv"
        begin = not table.exists()
        name = f"frame_{self.steps:06d}.frd"
        self.ccx.run("output", with_output(self.accepted_job, bool(self.deck.cards_of("*PLASTIC")),
                                           self.settings.reactions))
        if self.settings.reactions:
            append_reactions(self.frames / "reactions.csv", time, read_reactions(self.folder / "output.dat"))
        shutil.move(self.folder / "output.frd", self.frames / name)
        with table.open("a", newline="", encoding="utf-8") as out:
            csv.writer(out).writerows(([["time", "file"]] if begin else []) + [[time, name]])
        if self.settings.section_forces:
            self.ccx.run("output", with_section_forces(self.accepted_job))
            found = read_section_forces(self.folder / "output.frd", beam_nodes(self.deck))
            append_section_forces(self.frames / "section_forces.csv", time, found)

    def save_state(self) -> bytes:
        state = self.state_file.read_bytes() if self.state_file.exists() else b""
        return json.dumps({"deck": self.fingerprint(), "steps": self.steps,
                           "forces": {name: value.tolist() for name, value in self.forces.items()},
                           "restart_file": base64.b64encode(zlib.compress(state, 1)).decode("ascii")}).encode()

    def load_state(self, state: bytes) -> None:
        saved = json.loads(state)
        if saved["deck"] != self.fingerprint():
            raise ValueError(f"{self.settings.deck}: found another deck, or other interfaces, procedure, nlgeom or "
                             "alpha in structure.json, allowed: those of the run that is continued")
        self.state_file.unlink(missing_ok=True)
        content = zlib.decompress(base64.b64decode(saved["restart_file"]))
        self.accepted_job = ""
        if content:
            self.state_file.write_bytes(content)
            self.reserve = limit_reserve(self.state_file, None)
            self.accepted = read_nodal_state(self.state_file)
        else:
            self.accepted = self.begin()
        self.trial, self.steps = self.accepted, saved["steps"]
        self.forces = {name: np.array(value) for name, value in saved["forces"].items()}

    def fingerprint(self) -> str:
        """Hash of all data on which the state depends."""
        physics = [self.settings.procedure, self.settings.nlgeom, self.settings.alpha,
                   *((part.name, part.surface, part.element_set) for part in self.settings.interfaces)]
        text = "\n".join([*(line.text for line in self.deck.lines), json.dumps(physics)])
        return hashlib.sha256(text.encode()).hexdigest()

    def probe_names(self) -> list[str]:
        return [f"{probe.name}.u{axis}" for probe in self.settings.probes for axis in "xyz"[:self.dimension]]

    def probes(self) -> list[float]:
        return [float(value) for probe in self.settings.probes
                for value in self.accepted.displacement[probe.node - 1, :self.dimension]]

    def summary(self) -> dict:
        return {"program": "CalculiX", "steps": self.steps, "newton_iterations": self.newton,
                "runs_of_ccx": self.ccx.runs, "nodes": len(self.deck.nodes), "elements": len(self.deck.elements)}


def one_dimension(surfaces: list[WetSurface]) -> int:
    if len({surface.dimension for surface in surfaces}) != 1:
        raise DeckError("structure.json: at /interfaces: found "
                        f"{ {surface.name: surface.dimension for surface in surfaces} }, allowed: one or more of one "
                        "dimension (2: plane elements, 3: all others)")
    return surfaces[0].dimension
