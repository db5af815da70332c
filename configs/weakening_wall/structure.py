# SPDX-License-Identifier: BSD-3-Clause
"""A wall that weakens: neo-Hookean with isotropic damage, driven by the largest elastic energy so far.

    P = (1 - d(k)) dW/dF ,  W = mu / 2 (F : F - 2 - 2 ln J) + lambda / 2 (ln J)^2 ,  k = max over time of W
    d(k) = D (1 - exp(-(k - k_0) / k_s))   above k_0

See Simo (1987), On a fully three-dimensional finite-strain viscoelastic damage model, section 3. With D = 0.6 and
k_s = 4 k_0 the stress of a bar still grows with its strain, so damage does not localise in one row of cells.
"""

import numpy as np
import ufl
from dolfinx.mesh import CellType, create_rectangle
from gabion_dolfinx import Model

LOW, HIGH = (0.25, 0.0), (0.26, 0.05)  # [m]
MU, LAMBDA = 0.5e6, 0.0  # [Pa]: E = 1 MPa, no Poisson's ratio
LARGEST_DAMAGE, BEGIN, SCALE = 0.6, 300.0, 1200.0  # D [-], k_0, k_s [Pa]


def energy(F):
    """W [Pa] of the undamaged material."""
    log_J = ufl.ln(ufl.det(F))
    return 0.5 * MU * (ufl.inner(F, F) - 2 - 2 * log_J) + 0.5 * LAMBDA * log_J**2


def damage(k):
    return LARGEST_DAMAGE * (1 - ufl.exp(-ufl.max_value(k - BEGIN, 0) / SCALE))


class WeakeningWall(Model):
    degree = 2
    density = 1100.0  # [kg/m^3]
    gravity = (0.0, -9.81)
    bossak_alpha = -0.3
    initial_equilibrium = True

    def mesh(self, comm):
        return create_rectangle(comm, [LOW, HIGH], [2, 10], CellType.quadrilateral)

    def interfaces(self):
        return {"wall": lambda x: np.isclose(x[0], LOW[0]) | np.isclose(x[0], HIGH[0]) | np.isclose(x[1], HIGH[1])}

    def supports(self):
        return [(lambda x: np.isclose(x[1], 0), (0, 1))]

    def probes(self):
        return {"A": (0.25, 0.05)}

    def fields(self):
        return {"k": 0.0, "damage": 0.0}

    def new_fields(self, u, old):
        k = ufl.max_value(old["k"], energy(ufl.Identity(2) + ufl.grad(u)))
        return {"k": k, "damage": damage(k)}

    def internal_work(self, u, w, old, dx):
        F = ufl.variable(ufl.Identity(2) + ufl.grad(u))
        W = energy(F)
        P = (1 - damage(ufl.max_value(old["k"], W))) * ufl.diff(W, F)
        return ufl.inner(P, ufl.grad(w)) * dx
