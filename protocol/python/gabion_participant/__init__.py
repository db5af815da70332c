# SPDX-License-Identifier: BSD-3-Clause
"""Couple a Python code with Gabion; the contract is protocol/README.md. Needs numpy and pyzmq.

serve(solver, settings)   for codes that offer a few functions: derive from Solver
serve_ranks(solver, settings, comm)   the same on the ranks of an MPI communicator
Participant(settings)     for codes that keep their own time loop
offset_surface            the wet surface of beams and shells, and its forces as forces and moments of their nodes
"""

from . import interrupt
from .connection import Connection
from .errors import ConvergenceError, ParticipantError, ProtocolError, UsageError
from .handshake import PROTOCOL_VERSION, ParticipantSettings
from .participant import Participant
from .ranks import serve_ranks
from .service import introduce, serve, serve_over
from .solver import (END_OF_STEP, STEP_MEAN, AcceptReport, InterfaceMesh, InterfaceValues, Solver,
                     StepReport, StepRequest)

__all__ = ["END_OF_STEP", "PROTOCOL_VERSION", "STEP_MEAN", "AcceptReport", "Connection",
           "ConvergenceError", "InterfaceMesh", "InterfaceValues", "Participant", "ParticipantError",
           "ParticipantSettings", "ProtocolError",
           "Solver", "StepReport", "StepRequest", "UsageError", "interrupt", "introduce", "serve",
           "serve_over", "serve_ranks"]
