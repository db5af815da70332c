# SPDX-License-Identifier: BSD-3-Clause
"""History fields at the quadrature points: constant in a step, renewed when it is accepted."""

import basix
import numpy as np
import ufl
from dolfinx import fem

from .model import Model, ModelError


class History:
    """The fields of a model, as functions of dolfinx on the mesh.

    `old`: what the forms see. renew() evaluates all expressions of the new ones before it changes any.
    """

    def __init__(self, model: Model, u: fem.Function, degree: int) -> None:
        domain = u.function_space.mesh
        self.old = {name: make_field(domain, name, value, degree) for name, value in model.fields().items()}
        new = model.new_fields(u, self.old)
        if set(new) != set(self.old):
            raise ModelError(f"new_fields: found {sorted(new)}, allowed: {sorted(self.old)}, those of fields()")
        points, _ = basix.make_quadrature(getattr(basix.CellType, domain.topology.cell_name()), degree)
        self.points = len(points)
        cells = domain.topology.index_map(domain.topology.dim)
        self.cells = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
        self.new = {name: fem.Expression(on_mesh(domain, value), points) for name, value in new.items()}
        for name, expression in self.new.items():
            if (size := self.size(name)) != expression.value_size:
                raise ModelError(f'new_fields: found {expression.value_size} components of "{name}", allowed: {size}')

    def size(self, name: str) -> int:
        return int(np.prod(self.old[name].ufl_shape, dtype=int))

    def renew(self) -> None:
        """Compute the new values from the displacement and the fields that the expressions refer to."""
        values = {name: expression.eval(self.cells) for name, expression in self.new.items()}
        for name, value in values.items():
            self.old[name].x.array[:] = value.ravel()

    def arrays(self) -> dict[str, np.ndarray]:
        """Values of this rank: cells x points x components."""
        return {name: field.x.array for name, field in self.old.items()}

    def cell_means(self, name: str) -> np.ndarray:
        """cells x components."""
        return self.old[name].x.array.reshape(len(self.cells), self.points, self.size(name)).mean(axis=1)


def on_mesh(domain, value) -> ufl.core.expr.Expr:
    """A number is a constant of the mesh, as Expression wants it."""
    expression = ufl.as_ufl(value)
    if expression.ufl_domain() is None and expression.ufl_shape == ():
        return fem.Constant(domain, float(expression))
    return expression


def make_field(domain, name: str, value, degree: int) -> fem.Function:
    initial = np.asarray(value, dtype=float)
    cell = domain.ufl_cell()
    if initial.ndim == 0:
        element = ufl.FiniteElement("Quadrature", cell, degree, quad_scheme="default")
    elif initial.ndim == 1:
        element = ufl.VectorElement("Quadrature", cell, degree, initial.size, quad_scheme="default")
    else:
        element = ufl.TensorElement("Quadrature", cell, degree, initial.shape, quad_scheme="default")
    field = fem.Function(fem.FunctionSpace(domain, element), name=name)
    copies = field.x.array.reshape(-1, max(initial.size, 1))
    copies[:] = initial.ravel()
    check_layout(field, domain)
    return field


def check_layout(field: fem.Function, domain) -> None:
    """Expression.eval gives cell by cell; so must the field be."""
    dofs = field.function_space.dofmap.list.array
    if not np.array_equal(dofs, np.arange(len(dofs))):
        raise ModelError(f'field "{field.name}": found a numbering of dolfinx that does not go cell by cell')
