#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A participant that ends in its first step and does not say so: leaver.py ENDPOINT raise|exit|fork."""

import os
import sys

from fake_coupler import SQUARE
from gabion_participant import Participant, ParticipantSettings

endpoint, how = sys.argv[1:]
participant = Participant(ParticipantSettings("structure", endpoint, dimension=2))
participant.set_interface("wall", SQUARE)
participant.initialize()
if how == "exit":
    sys.exit(3)
if how == "fork":
    copy = os.fork()
    if copy == 0:
        sys.exit(0)
    os.waitpid(copy, 0)
raise KeyError("wall")
