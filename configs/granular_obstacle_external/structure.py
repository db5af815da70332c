#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The wall of this scene as a beam, coupled through protocol/README.md.

    structure.py --coupler tcp://host:port [--name structure] [--settings structure.json]

Needs numpy, scipy and gabion_participant (protocol/python in PYTHONPATH, or installed).
"""

import argparse
import csv
import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
from beam import Beam, BeamSettings, Load, NoSolution, State, directors
from gabion_participant import (AcceptReport, Connection, ConvergenceError, InterfaceMesh, InterfaceValues,
                                ParticipantError, ParticipantSettings, Solver, StepReport, StepRequest,
                                interrupt, introduce, serve_over)


class Outline:
    """The wet surface: up the right face, over the top to the left, down the left face; points carried by
    sections."""

    def __init__(self, beam: Beam, top_segments: int) -> None:
        half, last = 0.5 * beam.settings.thickness, beam.settings.elements
        faces = np.arange(beam.num_nodes)
        top = np.linspace(half, -half, top_segments + 1)[1:-1]
        self.node = np.concatenate([faces, np.full(len(top), last), faces[::-1]])
        self.offset = np.concatenate([np.full(len(faces), half), top, np.full(len(faces), -half)])
        foot = np.array(beam.settings.foot)
        self.coordinates = foot + np.stack([self.offset, beam.height[self.node]], axis=1)
        points = np.arange(len(self.node))
        self.facets = np.stack([points[:-1], points[1:]], axis=1)
        self.corner = len(faces) + len(top)  # top left: point A of the scene

    def displacement(self, q: np.ndarray) -> np.ndarray:
        """[m] of the points, num_points x 2: that of the axis, and what the section's rotation adds."""
        across, _ = directors(q[2::3][self.node])
        axis = np.stack([q[0::3], q[1::3]], axis=1)[self.node]
        return axis + self.offset[:, None] * (across - np.array([1.0, 0.0]))

    def load(self, force: np.ndarray) -> Load:
        return Load(self.node, self.offset, force)


class Wall(Solver):
    """The beam behind the five functions of the contract."""

    def __init__(self, beam: Beam, top_segments: int) -> None:
        self.beam, self.outline = beam, Outline(beam, top_segments)
        self.top_segments = top_segments
        self.accepted = beam.at_rest()
        self.trial = self.accepted
        self.newton = self.steps = 0
        self.file: Path | None = None

    def interfaces(self) -> list[InterfaceMesh]:
        return [InterfaceMesh("wall", self.outline.coordinates, self.outline.facets)]

    def solve_step(self, request: StepRequest,
                   received: InterfaceValues) -> tuple[InterfaceValues, StepReport]:
        force = received.get("wall", np.zeros_like(self.outline.coordinates))
        try:
            self.trial, iterations = self.beam.step(self.accepted, request.dt, self.outline.load(force))
        except NoSolution as problem:
            raise ConvergenceError(str(problem)) from problem
        self.newton += iterations
        return {"wall": self.outline.displacement(self.trial.q)}, StepReport(newton_iterations=iterations)

    def accept_step(self, request: StepRequest, solved: bool) -> AcceptReport:
        if solved:
            self.accepted = self.trial
            self.steps += 1
        return AcceptReport(details=self.beam.energies(self.accepted))

    def write_output(self, time: float) -> None:
        """Append the outline in its present place [m]: a row a point."""
        if self.file is None:
            return
        place = self.outline.coordinates + self.outline.displacement(self.accepted.q)
        begin = not self.file.exists()
        with self.file.open("a", newline="", encoding="utf-8") as out:
            rows = csv.writer(out)
            if begin:
                rows.writerow(["time", "point", "x", "y"])
            rows.writerows([time, k, *map(float, point)] for k, point in enumerate(place))

    def save_state(self) -> bytes:
        state = self.accepted
        return json.dumps({"settings": self.settings(), "q": state.q.tolist(), "v": state.v.tolist(),
                           "a": state.a.tolist()}).encode()

    def load_state(self, state: bytes) -> None:
        saved = json.loads(state)
        for name, value in self.settings().items():
            if value != saved["settings"].get(name):
                raise ValueError(f"structure.json: at /{name}: found {value}, allowed: "
                                 f"{saved['settings'].get(name)} as in the run that is continued")
        self.accepted = self.trial = State(*(np.array(saved[name]) for name in ("q", "v", "a")))

    def settings(self) -> dict:
        """structure.json with its defaults, as JSON gives it back."""
        return json.loads(json.dumps(asdict(self.beam.settings) | {"top_segments": self.top_segments}))

    def probe_names(self) -> list[str]:
        return ["A.ux", "A.uy"]

    def probes(self) -> list[float]:
        return self.outline.displacement(self.accepted.q)[self.outline.corner].tolist()

    def summary(self) -> dict:
        return {"program": "structure.py", "steps": self.steps, "newton_iterations": self.newton,
                "elements": self.beam.settings.elements}


def read_wall(path: Path) -> Wall:
    """The settings in structure.json. Raises ValueError that names file, key, found and allowed."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        top_segments = values.pop("top_segments")
        if not isinstance(top_segments, int) or top_segments < 1:
            raise ValueError(f"top_segments: found {top_segments}, allowed: an integer >= 1")
        return Wall(Beam(BeamSettings(**values)), top_segments)
    except (OSError, TypeError, ValueError, KeyError) as problem:
        raise ValueError(f"{path}: {problem}") from problem


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--coupler", required=True, metavar="ENDPOINT", help="such as tcp://127.0.0.1:5555")
    parser.add_argument("--name", default="structure", help="of this participant in coupler.json")
    parser.add_argument("--settings", type=Path, default=Path(__file__).parent / "structure.json")
    arguments = parser.parse_args()
    interrupt.install()
    try:
        wall = read_wall(arguments.settings)
        settings = ParticipantSettings(arguments.name, arguments.coupler, dimension=2, program="structure.py")
        with Connection(settings) as connection:
            introduce(wall, connection)
            run = connection.run_settings()
            if not run.get("check"):
                folder = Path(run["output"]) / "beam"
                folder.mkdir(parents=True, exist_ok=True)
                wall.file = folder / "outline.csv"
                wall.file.unlink(missing_ok=True)
            serve_over(wall, connection)
    except ValueError as problem:
        print(f"[beam] error: {problem}", file=sys.stderr)
        return 2
    except interrupt.Interrupted as problem:
        print(f"[beam] error: {problem}", file=sys.stderr)
        return 128 + problem.signal
    except ParticipantError as problem:
        print(f"[beam] error: {problem}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
