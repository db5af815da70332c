# SPDX-License-Identifier: BSD-3-Clause
"""Small models for the tests of structures/dolfinx, and what rank tests print of them."""

import json
import sys
from pathlib import Path

import numpy as np
import ufl

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "structures" / "dolfinx"), str(ROOT / "protocol" / "python"), str(ROOT / "scripts")]
from dolfinx.mesh import CellType, create_box, create_rectangle  # noqa: E402
from gabion_dolfinx import Model  # noqa: E402
from gabion_participant import STEP_MEAN, StepRequest  # noqa: E402

YOUNG, DENSITY = 1e6, 1000.0  # [Pa], [kg/m^3]; no Poisson's ratio
SIZE = (0.1, 0.3, 0.2)  # [m]
CELLS = (2, 3, 2)


def everywhere(x):
    return np.full(x.shape[1], True)


class Block(Model):
    """Linear elastic, wet all around, free."""

    density = DENSITY

    def __init__(self, dim=2, cell=CellType.quadrilateral, degree=1, **settings):
        self.dim, self.cell, self.degree = dim, cell, degree
        for name, value in settings.items():
            setattr(self, name, value)

    def mesh(self, comm):
        create = create_rectangle if self.dim == 2 else create_box
        return create(comm, [np.zeros(self.dim), np.array(SIZE[:self.dim])], list(CELLS[:self.dim]), self.cell)

    def interfaces(self):
        return {"wall": everywhere}

    def supports(self):
        return []

    def internal_work(self, u, w, old, dx):
        strain = ufl.sym(ufl.grad(u))
        return YOUNG * ufl.inner(strain, ufl.sym(ufl.grad(w))) * dx


class HeldBlock(Block):
    def supports(self):
        return [(lambda x: np.isclose(x[1], 0), range(self.dim))]

    def probes(self):
        return {"top": np.array((0, SIZE[1], 0))[:self.dim]}


class Yielding(HeldBlock):
    """Small strains, yields in uy,y alone: stress E (e - p), |stress| <= YIELD + HARDENING |p|."""

    YIELD, HARDENING = 1e3, 1e5  # [Pa]

    def fields(self):
        return {"p": 0.0}

    def plastic(self, u, old):
        strain = ufl.grad(u)[1, 1]
        stress = YOUNG * (strain - old["p"])
        excess = stress - self.YIELD - self.HARDENING * old["p"]
        return old["p"] + ufl.max_value(excess, 0) / (YOUNG + self.HARDENING)

    def new_fields(self, u, old):
        return {"p": self.plastic(u, old)}

    def internal_work(self, u, w, old, dx):
        strain = ufl.sym(ufl.grad(u))
        return (super().internal_work(u, w, old, dx)
                - YOUNG * self.plastic(u, old) * ufl.grad(w)[1, 1] * dx)


class SoftTop(HeldBlock):
    """Neo-Hookean."""

    initial_equilibrium = True

    def internal_work(self, u, w, old, dx):
        F = ufl.variable(ufl.Identity(self.dim) + ufl.grad(u))
        energy = 0.25 * YOUNG * (ufl.inner(F, F) - self.dim - 2 * ufl.ln(ufl.det(F)))
        return ufl.inner(ufl.diff(energy, F), ufl.grad(w)) * dx


def on_top(structure, force):
    """A force along x in equal parts on the top's nodes; 2D: per metre."""
    places = structure.surfaces[0].coordinates
    top = np.isclose(places[:, 1], SIZE[1])
    values = np.zeros_like(places)
    values[top, 0] = force / np.count_nonzero(top)
    return {"wall": values}


def march(structure, steps, dt, force):
    """Accepted steps under a force that grows; the surface's displacement after each."""
    structure.set_force_kinds({"wall": STEP_MEAN})
    found = []
    for step in range(1, steps + 1):
        request = StepRequest(step, 0, (step - 1) * dt, dt)
        values, _ = structure.solve_step(request, on_top(structure, force * step / steps))
        structure.accept_step(request, True)
        found.append(values["wall"])
    return found


def main():
    """Results of the ranks of mpirun, as JSON of rank 0."""
    from mpi4py import MPI

    from gabion_dolfinx.structure import Structure
    for dim, cell, degree in ((2, CellType.triangle, 2), (3, CellType.hexahedron, 1)):
        structure = Structure(SoftTop(dim, cell, degree), MPI.COMM_WORLD)
        way = march(structure, 5, 1e-3, 20.0)
        state = structure.save_state()
        onward = march(structure, 2, 1e-3, 5.0)
        structure.load_state(MPI.COMM_WORLD.bcast(state))
        again = march(structure, 2, 1e-3, 5.0)
        surface = structure.surfaces[0]
        found = {"ranks": MPI.COMM_WORLD.size, "coordinates": surface.coordinates.tolist(),
                 "facets": surface.facets.tolist(), "way": np.array(way).tolist(), "probes": structure.probes(),
                 "same_again": all(np.array_equal(a, b) for a, b in zip(onward, again))}
        if MPI.COMM_WORLD.rank == 0:
            print("found", json.dumps(found))


if __name__ == "__main__":
    main()
