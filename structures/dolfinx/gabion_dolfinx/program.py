# SPDX-License-Identifier: BSD-3-Clause
"""Make a participant from a file with a Model, on the ranks that mpirun has started."""

import argparse
import importlib.util
import logging
import sys
import traceback
from pathlib import Path

from gabion_participant import ConvergenceError, ParticipantError, ParticipantSettings, interrupt, serve_ranks
from mpi4py import MPI

from .model import Model, ModelError
from .structure import Structure


def read_model(path: Path) -> Model:
    """The one Model that a file defines. Raises ModelError."""
    if not path.is_file():
        raise ModelError(f"{path}: found no file, allowed: one that defines a gabion_dolfinx.Model")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.parent))
    spec.loader.exec_module(module)
    found = [value for value in vars(module).values() if isinstance(value, type) and issubclass(value, Model)
             and value.__module__ == module.__name__]
    if len(found) != 1:
        raise ModelError(f"{path}: found {len(found)} classes derived from Model, allowed: one")
    return found[0]()


def run(arguments: argparse.Namespace) -> int:
    """The exit code. On several ranks an error ends all of them."""
    comm = MPI.COMM_WORLD
    logging.disable(logging.INFO)  # each command of the compiler
    interrupt.install()
    try:
        structure = Structure(read_model(arguments.model), comm, arguments.model.read_text(encoding="utf-8"),
                              arguments.name)
        settings = ParticipantSettings(arguments.name, arguments.coupler, dimension=structure.dimension,
                                       program="dolfinx_structure")
        serve_ranks(structure, settings, comm)
        return 0
    except Exception as problem:
        known = isinstance(problem, (ModelError, ParticipantError))
        if not known:
            traceback.print_exc()
        print(f"[dolfinx] error: {problem if known else repr(problem)}", file=sys.stderr, flush=True)
        code = exit_code(problem)
    if comm.size > 1:
        comm.Abort(code)
    return code


def exit_code(problem: Exception) -> int:
    if isinstance(problem, interrupt.Interrupted):
        return 128 + problem.signal
    if isinstance(problem, ModelError):
        return 2
    return 4 if isinstance(problem, ParticipantError) and not isinstance(problem, ConvergenceError) else 3
