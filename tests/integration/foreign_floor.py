#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A foreign floor with a time loop of its own, each vertex on a spring and a damper, whose middle breaks: facets with
more than an impulse on their vertices leave the interface.

    foreign_floor.py IMPULSE --coupler ENDPOINT     IMPULSE [N s/m] that a vertex bears
"""

import os
import signal
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent.parent.parent / "protocol" / "python")]
from gabion_participant import Participant, ParticipantSettings  # noqa: E402

HEIGHT, CELLS = 0.4, 20  # [m] of the floor, over 1 m
STIFFNESS, DAMPING = 1e6, 1e3  # [N/m], [N s/m] of a vertex, per metre


class Floor:
    """State: displacement, and the impulse that each vertex has borne."""

    def __init__(self, bears: float) -> None:
        self.bears = bears
        across = np.arange(CELLS + 1) / CELLS
        self.vertices = np.array([[x, y] for y in (HEIGHT - 0.05, HEIGHT) for x in across])  # lower ones without facets
        self.segments = np.array([[i + 1, i] for i in range(CELLS + 1, 2 * CELLS + 1)])  # normals up
        self.u = np.zeros_like(self.vertices)
        self.impulse = np.zeros(len(self.vertices))

    def facets(self) -> np.ndarray:
        broken = self.impulse > self.bears
        return self.segments[~broken[self.segments].any(axis=1)]

    def save(self) -> bytes:
        return self.u.tobytes() + self.impulse.tobytes()

    def load(self, state: bytes) -> None:
        numbers = np.frombuffer(state).copy()
        self.u, self.impulse = numbers[:self.u.size].reshape(self.u.shape), numbers[self.u.size:]


def run(bears: float, endpoint: str) -> None:
    settings = ParticipantSettings("structure", endpoint, dimension=2, program="foreign_floor", connect_deadline=60,
                                   exit_when_coupler_is_lost=False)
    floor = Floor(bears)
    participant = Participant(settings)
    participant.set_interface("wall", floor.vertices, floor.segments)
    participant.set_facets_may_change("wall")
    participant.set_probes({"facets": float(CELLS)})

    def load(state: bytes) -> None:
        floor.load(state)
        participant.write_facets("wall", floor.facets())
        participant.set_probes({"facets": float(len(floor.facets()))})

    participant.set_state(floor.save, load)
    participant.initialize()
    participant.force_kind("wall")
    saved = floor.save()
    while participant.is_coupling_ongoing():
        if participant.requires_writing_checkpoint():
            saved = floor.save()
        dt = participant.get_max_time_step_size()
        force = participant.read_data("wall")
        floor.u = (force + DAMPING / dt * floor.u) / (STIFFNESS + DAMPING / dt)
        floor.impulse = floor.impulse - dt * force[:, 1]
        participant.write_data("wall", floor.u)
        participant.set_probes({"facets": float(len(floor.facets()))})
        participant.advance(dt)
        if participant.requires_reading_checkpoint():
            floor.load(saved)
        elif participant.is_time_window_complete():
            participant.write_facets("wall", floor.facets())
    participant.finalize()


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    run(float(sys.argv[1]), sys.argv[sys.argv.index("--coupler") + 1])
