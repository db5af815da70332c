# SPDX-License-Identifier: BSD-3-Clause
"""The wall of granular_obstacle as a variational form: neo-Hookean, plane strain, clamped foot."""

import numpy as np
import ufl
from dolfinx.mesh import CellType, create_rectangle
from gabion_dolfinx import Model

LOW, HIGH = (0.25, 0.0), (0.26, 0.05)  # [m]
MU, LAMBDA = 0.5e6, 0.0  # [Pa]: E = 1 MPa, no Poisson's ratio


class Wall(Model):
    density = 1100.0
    gravity = (0.0, -9.81)
    bossak_alpha = -0.3
    initial_equilibrium = True

    def mesh(self, comm):
        return create_rectangle(comm, [LOW, HIGH], [4, 40], CellType.quadrilateral)

    def interfaces(self):
        return {"wall": lambda x: np.isclose(x[0], LOW[0]) | np.isclose(x[0], HIGH[0]) | np.isclose(x[1], HIGH[1])}

    def supports(self):
        return [(lambda x: np.isclose(x[1], 0), (0, 1))]

    def probes(self):
        return {"A": (0.25, 0.05)}

    def internal_work(self, u, w, old, dx):
        F = ufl.variable(ufl.Identity(2) + ufl.grad(u))
        log_J = ufl.ln(ufl.det(F))
        energy = 0.5 * MU * (ufl.inner(F, F) - 2 - 2 * log_J) + 0.5 * LAMBDA * log_J**2
        return ufl.inner(ufl.diff(energy, F), ufl.grad(w)) * dx
