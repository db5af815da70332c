#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A participant whose solution takes a minute: sleeper.py ENDPOINT."""

import sys
import time

from fake_coupler import SQUARE
from gabion_participant import (AcceptReport, InterfaceMesh, ParticipantError, ParticipantSettings, Solver, StepReport,
                                interrupt, serve)


class Sleeper(Solver):
    def interfaces(self):
        return [InterfaceMesh("wall", SQUARE)]

    def solve_step(self, request, received):
        time.sleep(60)
        return {"wall": SQUARE}, StepReport()

    def accept_step(self, request, solved):
        return AcceptReport()

    def save_state(self):
        return b""

    def load_state(self, state):
        pass


interrupt.install()
try:
    serve(Sleeper(), ParticipantSettings("structure", sys.argv[1], dimension=2))
except interrupt.Interrupted as problem:
    print(problem, file=sys.stderr)
    sys.exit(128 + problem.signal)
except ParticipantError as problem:
    print(problem, file=sys.stderr)
    sys.exit(4)
