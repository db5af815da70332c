# SPDX-License-Identifier: BSD-3-Clause
"""Frames for ParaView: a .vtu of each, and structure.pvd, which is complete after each."""

from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.io import VTKFile


class Output:
    """Displacement, and means of the history fields over each cell, in `folder`."""

    def __init__(self, balance, folder: Path) -> None:
        self.balance, self.file = balance, folder / "structure.pvd"
        self.comm = balance.comm
        if self.comm.rank == 0:
            folder.mkdir(parents=True, exist_ok=True)
            for old in folder.glob("structure*"):
                old.unlink()
        self.comm.Barrier()
        self.means = {name: constant_in_cells(balance.V.mesh, name, balance.history.size(name))
                      for name in balance.history.old}

    def write(self, time: float) -> None:
        for name, mean in self.means.items():
            mean.x.array[:] = self.balance.history.cell_means(name).ravel()
        with VTKFile(self.comm, str(self.file), "a" if self.file.exists() else "w") as out:
            out.write_function([self.balance.u, *self.means.values()], time)


def constant_in_cells(domain, name: str, size: int) -> fem.Function:
    kind = ("DG", 0)
    space = fem.FunctionSpace(domain, kind) if size == 1 else fem.VectorFunctionSpace(domain, kind, dim=size)
    return fem.Function(space, name=name)
