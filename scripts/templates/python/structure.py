#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The structure of model.py behind the coupler: it asks, these functions answer.

    structure.py --coupler tcp://host:port
"""

import argparse
import sys

import model
import numpy as np
from gabion_participant import (AcceptReport, InterfaceMesh, ParticipantError, ParticipantSettings, Solver, StepReport,
                                interrupt, serve)


class Structure(Solver):
    """A step always starts from the accepted state; only accept_step moves that on."""

    def __init__(self):
        self.accepted = self.trial = model.at_rest()

    def interfaces(self):
        return [InterfaceMesh("wall", model.POINTS, model.FACETS)]

    def set_force_kinds(self, kinds):
        """Nothing to do: implicit Euler adds dt F of momentum, be F the mean of the step or the force at its end."""

    def solve_step(self, request, received):
        force = received.get("wall", np.zeros_like(model.POINTS))  # none: nothing touches
        self.trial = model.step(self.accepted, request.dt, force)
        return {"wall": model.displacement(self.trial)}, StepReport()

    def accept_step(self, request, solved):
        if solved:
            self.accepted = self.trial
        return AcceptReport()

    def probe_names(self):
        return list(model.probes(self.accepted))

    def probes(self):
        return list(model.probes(self.accepted).values())

    def save_state(self):
        return self.accepted.tobytes()

    def load_state(self, state):
        self.accepted = self.trial = np.frombuffer(state).reshape(self.accepted.shape)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--coupler", required=True, metavar="ENDPOINT", help="such as tcp://127.0.0.1:5555")
    arguments = parser.parse_args()
    interrupt.install()  # a signal ends the run, with a checkpoint, not this program
    try:
        serve(Structure(), ParticipantSettings("__NAME__", arguments.coupler, model.DIMENSION, program="structure.py"))
    except ParticipantError as problem:
        print(f"[__NAME__] error: {problem}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
