# SPDX-License-Identifier: BSD-3-Clause
"""A structure as its user defines it: mesh, surfaces, supports, and the virtual work of its stresses as a form of
UFL."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx.mesh import Mesh

# Points (3 x n) [m] -> which of them belong to it, as dolfinx.mesh.locate_entities asks.
Marker = Callable[[np.ndarray], np.ndarray]
Fields = Mapping[str, Any]  # a history field of the accepted state, by name


class ModelError(Exception):
    """Parts of the model do not fit; the message says what was found and what is allowed."""


class Model(ABC):
    """A solid in total Lagrangian form, plane strain or 3D; SI units, in 2D per metre of thickness.

    Every function is called on all ranks.
    """

    degree = 1  # of the Lagrange elements
    quadrature_degree = 0  # of all integrals and of the history fields; 0: twice the degree
    density = 0.0  # [kg/m^3]; has to be given
    gravity: Sequence[float] = ()  # [m/s^2]; (): none
    bossak_alpha = 0.0  # -1/3 to 0; 0: the trapezoidal rule
    initial_equilibrium = False  # the run starts in balance with gravity, not at u = 0
    newton_tolerance = 1e-8  # residual over the largest of internal, external, inertial force, or rounding
    newton_iterations = 20  # after so many the step has failed

    @abstractmethod
    def mesh(self, comm: Any) -> Mesh:
        """The mesh on a communicator of mpi4py."""

    @abstractmethod
    def interfaces(self) -> dict[str, Marker]:
        """Wet surfaces by their names in coupler.json: facets of the boundary whose vertices are all marked."""

    @abstractmethod
    def supports(self) -> list[tuple[Marker, Sequence[int]]]:
        """Places and the components of the displacement that are zero there: [(marker, (0, 1))]."""

    @abstractmethod
    def internal_work(self, u: ufl.core.expr.Expr, w: ufl.core.expr.Expr, old: Fields, dx: ufl.Measure) -> ufl.Form:
        """The virtual work of the stresses in u for the variation w: inner(P, grad(w)) * dx. Gravity and inertia are
        added, the tangent is its derivative. `old`: history fields at the beginning of the step."""

    def fields(self) -> dict[str, Any]:
        """History at the quadrature points: name -> initial value, a number or an array."""
        return {}

    def new_fields(self, u: ufl.core.expr.Expr, old: Fields) -> dict[str, ufl.core.expr.Expr]:
        """Values of these fields at the end of a step that is accepted, from u there and from the old ones."""
        return {}

    def probes(self) -> dict[str, Sequence[float]]:
        """Nodes whose displacement is recorded: name -> place [m]."""
        return {}


def check_model(model: Model, dim: int) -> None:
    """Raises ModelError."""
    for name, fits, allowed in (
            ("degree", model.degree >= 1, "an integer >= 1"),
            ("density", model.density > 0, "> 0 kg/m^3"),
            ("gravity", len(model.gravity) in (0, dim), f"{dim} components, or ()"),
            ("bossak_alpha", -1 / 3 <= model.bossak_alpha <= 0, "-1/3 to 0"),
            ("newton_tolerance", 0 < model.newton_tolerance < 1, "between 0 and 1")):
        if not fits:
            raise ModelError(f"{type(model).__name__}.{name}: found {getattr(model, name)}, allowed: {allowed}")
