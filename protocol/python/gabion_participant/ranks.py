# SPDX-License-Identifier: BSD-3-Clause
"""serve_ranks(solver, settings, comm): a solver on the ranks of an MPI communicator behind one socket.

Rank 0 has the connection and passes each request on; every rank answers it with its part of the solver, and the answer
of rank 0 is sent. So a solver is written as MPI codes are: each function is called on all ranks with the same values.
`comm` is a communicator of mpi4py; nothing here imports that.
"""

import sys
import time
import traceback
from typing import Any

from .connection import Connection
from .errors import text_of
from .handshake import ParticipantSettings
from .process import this_process
from .rank_watch import RankWatch
from .service import Service, introduce, serve, serve_over
from .solver import Solver

TAG = 4711
NAP = 1e-4  # [s] between two looks for an order: a rank that waits leaves the processor to the soil
ANSWER_TIME = 1.0  # [s] for rank 0 to tell the coupler of its error, before another rank ends all


def serve_ranks(solver: Solver, settings: ParticipantSettings, comm: Any) -> None:
    """serve() on all ranks; called by each with its own part of the solver.

    interfaces, probe_names, probes, solve_step and the others return the same on all ranks where rank 0's answer
    depends on it, and accept_step the same proposed_dt; save_state may return b"" on the others. ConvergenceError has
    to come on all ranks or on none; any other error of a rank but 0 is printed and ends all processes of the
    communicator.
    """
    if comm.size == 1:
        serve(solver, settings)
    elif comm.rank == 0:
        _lead(solver, settings, comm)
    else:
        _follow(solver, settings, comm)


def _lead(solver: Solver, settings: ParticipantSettings, comm: Any) -> None:
    def give_on(order: Any) -> None:
        for rank in range(1, comm.size):
            comm.send(order, rank, TAG)

    others = [comm.recv(source=rank, tag=TAG) for rank in range(1, comm.size)]
    with Connection(settings) as connection, RankWatch(settings.name, others):
        introduce(solver, connection)
        give_on(connection.run_settings())
        serve_over(solver, connection, give_on)


def _follow(solver: Solver, settings: ParticipantSettings, comm: Any) -> None:
    try:
        comm.send(this_process(), 0, TAG)
        solver.interfaces(), solver.probe_names(), solver.probes()  # as rank 0 for the handshake
        if settings.sends == "displacement":
            solver.start_displacements(), solver.facets()
        run = _next_order(comm)
        service = Service(solver, settings)
        solver.begin_run(run)
        while not service.is_finished:
            service.answer(_next_order(comm))
    except Exception as problem:
        traceback.print_exc()
        print(f'[{settings.name}] error: rank {comm.rank}: {text_of(problem)}', file=sys.stderr, flush=True)
        time.sleep(ANSWER_TIME)
        comm.Abort(3)


def _next_order(comm: Any) -> Any:
    while not comm.iprobe(source=0, tag=TAG):
        time.sleep(NAP)
    return comm.recv(source=0, tag=TAG)

