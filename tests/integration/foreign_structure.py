#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A foreign wall with a time loop of its own: each vertex on a spring and a damper, implicit Euler.

    foreign_structure.py HABIT --coupler ENDPOINT

HABIT: good; keeps (does not go back after a rejected step); dies (in step 3); sleeps (in step 3);
fails (before it connects).
FOREIGN_STRUCTURE_SHIFT in the environment: [m] that its surface lies beside its place.
"""

import os
import sys
import time
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent.parent.parent / "protocol" / "python")]
from gabion_participant import Participant, ParticipantError, ParticipantSettings  # noqa: E402

STIFFNESS, DAMPING = 1e4, 10.0  # [N/m], [N s/m] of a vertex, per metre


def run(habit: str, endpoint: str) -> None:
    settings = ParticipantSettings("structure", endpoint, dimension=2, program="foreign_structure",
                                   connect_deadline=10,
                                   exit_when_coupler_is_lost=False)
    participant = Participant(settings)
    vertices = np.array([[0.26, 0.0], [0.26, 0.05], [0.25, 0.05], [0.25, 0.0]])
    vertices += float(os.environ.get("FOREIGN_STRUCTURE_SHIFT", "0"))
    participant.set_interface("wall", vertices, [[0, 1], [1, 2], [2, 3]])
    participant.set_probes({"A.ux": 0.0})
    u = saved = np.zeros_like(vertices)

    def load(state: bytes) -> None:
        nonlocal u
        u = np.frombuffer(state).reshape(u.shape)
        participant.set_probes({"A.ux": float(u[2, 0])})

    participant.set_state(lambda: u.tobytes(), load)
    participant.initialize()
    steps = 0
    while participant.is_coupling_ongoing():
        if participant.requires_writing_checkpoint():
            saved = u
            steps += 1
        if habit == "dies" and steps == 3:
            os._exit(9)
        if habit == "sleeps" and steps == 3:
            time.sleep(60)
        dt = participant.get_max_time_step_size()
        u = (participant.read_data("wall") + DAMPING / dt * u) / (STIFFNESS + DAMPING / dt)
        participant.write_data("wall", u)
        participant.set_probes({"A.ux": float(u[2, 0])})
        participant.advance(dt)
        if participant.requires_reading_checkpoint() and habit != "keeps":
            u = saved
    participant.finalize()


def main() -> int:
    habit, option, endpoint = sys.argv[1:]
    if habit == "fails" or option != "--coupler":
        print("this code does not start", file=sys.stderr)
        return 3
    try:
        run(habit, endpoint)
    except ParticipantError as problem:
        print(f"[foreign] error: {problem}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
