# SPDX-License-Identifier: BSD-3-Clause
"""Forces, tangent and mass of a model as compiled forms, and linear systems with them. Arrays hold the unknowns that
this rank owns."""

import numpy as np
import ufl
from dolfinx import fem, jit, la
from dolfinx.fem.petsc import assemble_matrix
from mpi4py import MPI
from petsc4py import PETSc

from .history import History
from .model import Model, ModelError

# One of several processes that want the same form compiles it; 10 s, the default, is short on a busy machine.
jit.DOLFINX_DEFAULT_JIT_PARAMETERS["timeout"] = (120, "[s] that others wait")
EACH_ALONE = 5000  # up to so many unknowns each rank factorises the whole matrix


class Balance:
    """Balance of internal forces, weight and inertia in the function space of the model."""

    def __init__(self, model: Model, domain) -> None:
        dim = domain.geometry.dim
        self.comm = domain.comm
        self.V = fem.VectorFunctionSpace(domain, ("Lagrange", model.degree))
        self.size = self.V.dofmap.index_map.size_local * dim
        self.u = fem.Function(self.V, name="displacement")
        degree = model.quadrature_degree or 2 * model.degree
        dx = ufl.Measure("dx", domain, metadata={"quadrature_degree": degree, "quadrature_scheme": "default"})
        self.history = History(model, self.u, degree)
        w, du = ufl.TestFunction(self.V), ufl.TrialFunction(self.V)
        work = model.internal_work(self.u, w, self.history.old, dx)
        self.internal = fem.form(work)
        self.tangent = fem.form(ufl.derivative(work, self.u, du))
        self.supports = make_supports(model, self.V)
        self.held = np.zeros(self.size, dtype=bool)
        for support in self.supports:
            owned, count = support.dof_indices()
            self.held[owned[:count]] = True
        mass = fem.form(model.density * ufl.inner(du, w) * dx)
        self.M = assemble_matrix(mass)
        self.M.assemble()
        self.M_free = assemble_matrix(mass, self.supports, diagonal=0.0)
        self.M_free.assemble()
        self.vector, self.product = self.M.createVecs()
        self.forces = la.vector(self.V.dofmap.index_map, self.V.dofmap.index_map_bs)
        self.weight = self.mass_times(np.tile(model.gravity or np.zeros(dim), self.size // dim))

    def set_u(self, values: np.ndarray) -> None:
        self.u.x.array[:self.size] = values
        self.u.x.scatter_forward()

    def internal_forces(self, u: np.ndarray) -> np.ndarray:
        self.set_u(u)
        self.forces.array[:] = 0
        fem.assemble_vector(self.forces.array, self.internal)
        self.forces.scatter_reverse(la.ScatterMode.add)
        return self.forces.array[:self.size].copy()

    def mass_times(self, values: np.ndarray) -> np.ndarray:
        self.vector.array[:] = values
        self.M.mult(self.vector, self.product)
        return self.product.array.copy()

    def norms(self, *arrays: np.ndarray) -> list[float]:
        """Norms over all ranks."""
        squares = np.array([array @ array for array in arrays])
        return np.sqrt(self.comm.allreduce(squares)).tolist()

    def dot(self, a: np.ndarray, b: np.ndarray) -> float:
        """Scalar product over all ranks."""
        return float(self.comm.allreduce(a @ b))

    def rounding(self, at_rest: "Factor") -> float:
        """[N] that rounding alone leaves in the norm of forces: an error of a strain of 1 + grad u, by the stiffness
        at u = 0."""
        geometry = self.V.mesh.geometry
        corners = geometry.x[geometry.dofmap.array.reshape(geometry.dofmap.num_nodes, -1)]
        largest = self.comm.allreduce(np.ptp(corners, axis=1).max(initial=0.0), op=MPI.MAX)  # of the cells
        at_rest.assemble(np.zeros(self.size), 0.0)
        return np.finfo(float).eps * largest * self.norms(at_rest.matrix.getDiagonal().array)[0]

    def mass_factor(self) -> "Factor":
        """Factor of the mass on free unknowns; the others stay zero."""
        factor = Factor(self)
        factor.assemble_mass()
        return factor


class Factor:
    """A matrix and its LU factors; the pattern of both is kept."""

    def __init__(self, balance: Balance) -> None:
        self.balance = balance
        self.matrix = assemble_matrix(balance.tangent, balance.supports)
        self.matrix.assemble()
        self.solver = PETSc.KSP().create(balance.comm)
        self.solver.setOperators(self.matrix)
        self.solver.setType("preonly")
        pc = self.solver.getPC()
        if balance.comm.size > 1 and self.matrix.getSize()[0] <= EACH_ALONE:
            pc.setType("redundant")  # every rank the whole matrix: one exchange a solution
        else:
            pc.setType("lu")
            pc.setFactorSolverType("petsc" if balance.comm.size == 1 else "mumps")
        self.right, self.left = self.matrix.createVecs()

    def assemble(self, u: np.ndarray, inertia: float) -> None:
        """The tangent at u, and `inertia` times the mass."""
        self.balance.set_u(u)
        self.matrix.zeroEntries()
        assemble_matrix(self.matrix, self.balance.tangent, self.balance.supports)
        self.matrix.assemble()
        if inertia:
            self.matrix.axpy(inertia, self.balance.M_free, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)

    def assemble_mass(self) -> None:
        self.matrix.zeroEntries()
        self.matrix.assemble()
        self.matrix.axpy(1.0, self.balance.M_free, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        start = self.matrix.getOwnershipRange()[0]
        for k in np.flatnonzero(self.balance.held):
            self.matrix.setValue(start + int(k), start + int(k), 1.0)
        self.matrix.assemble()

    def solve(self, right: np.ndarray) -> np.ndarray:
        self.right.array[:] = np.where(self.balance.held, 0.0, right)
        self.solver.solve(self.right, self.left)
        return self.left.array.copy()


def make_supports(model: Model, V: fem.FunctionSpace) -> list:
    """Raises ModelError where one holds no node."""
    supports = []
    for number, (marker, components) in enumerate(model.supports()):
        for component in components:
            space = V.sub(component)
            collapsed, _ = space.collapse()
            dofs = fem.locate_dofs_geometrical((space, collapsed), marker)
            if not V.mesh.comm.allreduce(len(dofs[0])):
                raise ModelError(f"supports: found no node at support {number}, allowed: at least one")
            zero = fem.Function(collapsed)
            supports.append(fem.dirichletbc(zero, dofs, space))
    return supports
