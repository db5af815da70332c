# SPDX-License-Identifier: BSD-3-Clause
"""Frames for ParaView: structure.pvd, which is complete after each, and a .pvtu with a .vtu of each rank."""

from pathlib import Path

from dolfinx import fem
from dolfinx.io import VTKFile


class Output:
    """Displacement, and means of the history fields over each cell, in `folder`."""

    def __init__(self, balance, folder: Path) -> None:
        self.balance, self.index = balance, folder / "structure.pvd"
        self.times: list[float] = []
        self.comm = balance.comm
        if self.comm.rank == 0:
            folder.mkdir(parents=True, exist_ok=True)
        self.comm.Barrier()
        self.file = VTKFile(self.comm, str(self.index), "w")
        self.means = {name: constant_in_cells(balance.V.mesh, name, balance.history.size(name))
                      for name in balance.history.old}

    def write(self, time: float) -> None:
        for name, mean in self.means.items():
            mean.x.array[:] = self.balance.history.cell_means(name).ravel()
        self.file.write_function([self.balance.u, *self.means.values()], time)
        self.times.append(time)
        if self.comm.rank == 0:
            self.write_index()

    def write_index(self) -> None:
        """VTKFile itself writes it at its end only, which a run that is killed does not reach."""
        rows = [f'    <DataSet timestep="{time!r}" part="0" file="{self.index.stem}{number:06d}.pvtu" />'
                for number, time in enumerate(self.times)]
        self.index.write_text("\n".join(['<?xml version="1.0"?>', '<VTKFile type="Collection" version="1.0">',
                                         "  <Collection>", *rows, "  </Collection>", "</VTKFile>", ""]))


def constant_in_cells(domain, name: str, size: int) -> fem.Function:
    kind = ("DG", 0)
    space = fem.FunctionSpace(domain, kind) if size == 1 else fem.VectorFunctionSpace(domain, kind, dim=size)
    return fem.Function(space, name=name)
