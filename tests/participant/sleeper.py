#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A participant whose solution takes a minute: sleeper.py ENDPOINT."""

import sys
import time

from fake_coupler import SQUARE
from gabion_participant import AcceptReport, InterfaceMesh, ParticipantSettings, Solver, StepReport, serve


class Sleeper(Solver):
    def interfaces(self):
        return [InterfaceMesh("wall", SQUARE)]

    def solve_step(self, request, received):
        time.sleep(60)
        return {"wall": SQUARE}, StepReport()

    def accept_step(self, request, solved):
        return AcceptReport()


serve(Sleeper(), ParticipantSettings("structure", sys.argv[1], dimension=2))
