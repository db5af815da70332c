# SPDX-License-Identifier: BSD-3-Clause
"""A plane beam that bends, stretches and shears by any amount, and its motion in time.

Strains of Reissner (1972), linear elements with one integration point, consistent mass with rotary inertia,
Bossak's time integration, full Newton. Degrees of freedom of node i: q[3 i:3 i + 3] = displacement (x, y) [m]
and rotation theta, counter-clockwise. The straight axis stands upright on the clamped foot; all per metre of
thickness.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

BAND = 5  # off-diagonals of a matrix that couples neighbouring nodes
MAX_NEWTON = 30
TOLERANCE = 1e-10  # of the forces in balance
ROUND_OFF = 10 * np.finfo(float).eps  # of EA and of M q / dt^2: what the rounding of q leaves


class NoSolution(Exception):
    """Newton's iteration has not converged."""


@dataclass(frozen=True)
class BeamSettings:
    foot: tuple[float, float]  # [m] of the axis
    length: float  # [m] > 0
    thickness: float  # [m] > 0
    elements: int  # along the axis, >= 1
    density: float  # [kg/m3] > 0
    young_modulus: float  # [Pa] > 0
    poisson_ratio: float = 0.0  # in (-1, 0.5): of the shear modulus only
    shear_correction: float = 5 / 6  # > 0
    gravity: float = 9.81  # [m/s2] downwards, >= 0
    bossak_alpha: float = -0.3  # in [-1/3, 0]; 0 is Newmark's trapezoidal rule

    def __post_init__(self) -> None:
        checks = {
            "foot": (len(self.foot) == 2, "two coordinates"), "length": (self.length > 0, "> 0"),
            "thickness": (self.thickness > 0, "> 0"),
            "elements": (isinstance(self.elements, int) and self.elements >= 1, "an integer >= 1"),
            "density": (self.density > 0, "> 0"), "young_modulus": (self.young_modulus > 0, "> 0"),
            "poisson_ratio": (-1 < self.poisson_ratio < 0.5, "between -1 and 0.5"),
            "shear_correction": (self.shear_correction > 0, "> 0"), "gravity": (self.gravity >= 0, ">= 0"),
            "bossak_alpha": (-1 / 3 <= self.bossak_alpha <= 0, "-1/3 to 0"),
        }
        for name, (holds, allowed) in checks.items():
            if not holds:
                raise ValueError(f"{name}: found {getattr(self, name)}, allowed: {allowed}")


@dataclass(frozen=True)
class State:
    """Degrees of freedom with their rates, 3 (elements + 1) each; never changed in place."""

    q: np.ndarray  # [m, -]
    v: np.ndarray  # per s
    a: np.ndarray  # per s2


@dataclass(frozen=True)
class Load:
    """Dead forces on points that the sections carry: point k lies `offset[k]` [m] from the axis on the
    section of `node[k]`, to the right of the upright axis, and carries `force[k]` [N/m]."""

    node: np.ndarray
    offset: np.ndarray
    force: np.ndarray  # num_points x 2

    def on_axis(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces and moments on the nodes by virtual work, size of q; and d moment / d theta, a value a node.

        The point's virtual displacement is du + offset t(theta) dtheta, so its moment is offset f . t.
        """
        across, along = directors(q[2::3][self.node])
        forces = np.zeros((len(q) // 3, 3))
        np.add.at(forces[:, :2], self.node, self.force)
        np.add.at(forces[:, 2], self.node, self.offset * np.sum(self.force * along, axis=1))
        slope = np.zeros(len(q) // 3)
        np.add.at(slope, self.node, -self.offset * np.sum(self.force * across, axis=1))
        return forces.ravel(), slope


def directors(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors across and along the axis of sections turned by theta; each num x 2."""
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)


class Beam:
    """The discrete beam: forces, tangent, mass, energies."""

    def __init__(self, settings: BeamSettings) -> None:
        self.settings = settings
        self.num_nodes = settings.elements + 1
        self.size = 3 * self.num_nodes
        self.h = settings.length / settings.elements
        self.height = np.linspace(0, settings.length, self.num_nodes)  # [m] of the nodes above the foot
        area, inertia = settings.thickness, settings.thickness**3 / 12
        shear = settings.young_modulus / (2 * (1 + settings.poisson_ratio))
        # Stiffness of stretching, shearing, bending: N = EA epsilon, Q = k GA gamma, M = EI kappa.
        self.stiffness = np.array([settings.young_modulus * area, settings.shear_correction * shear * area,
                                   settings.young_modulus * inertia])
        first = 3 * np.arange(settings.elements)[:, None] + np.arange(6)
        self._dofs = first  # elements x 6
        rows, columns = first[:, :, None], first[:, None, :]
        self._band_index = ((BAND + rows - columns) * self.size + columns).ravel()
        per_length = settings.density * np.array([area, area, inertia])
        block = np.kron(np.array([[2, 1], [1, 2]]) * self.h / 6, np.diag(per_length))
        self.mass = self._band(np.broadcast_to(block, (settings.elements, 6, 6)))
        weight = np.zeros((self.num_nodes, 3))
        weight[:, 1] = -settings.gravity
        self.weight = self.mass_times(weight.ravel())

    def _band(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of element matrices in the form that solve_banded takes, (2 BAND + 1) x size."""
        summed = np.bincount(self._band_index, blocks.ravel(), (2 * BAND + 1) * self.size)
        return summed.reshape(2 * BAND + 1, self.size)

    def mass_times(self, vector: np.ndarray) -> np.ndarray:
        result = np.zeros(self.size)
        for k in range(-BAND, BAND + 1):  # diagonal k: row i, column i + k
            columns = np.arange(max(k, 0), self.size + min(k, 0))
            result[columns - k] += self.mass[BAND - k, columns] * vector[columns]
        return result

    def strains(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stretch, shear and curvature [-, -, 1/m] in the middle of each element, elements x 3; directors
        there."""
        theta = q[2::3]
        across, along = directors(0.5 * (theta[1:] + theta[:-1]))
        u = np.stack([q[0::3], q[1::3]], axis=1)
        slope = (u[1:] - u[:-1]) / self.h + np.array([0.0, 1.0])  # dr/ds
        strains = np.stack([np.sum(slope * along, axis=1) - 1, np.sum(slope * across, axis=1),
                            (theta[1:] - theta[:-1]) / self.h], axis=1)
        return strains, across, along

    def forces(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Internal forces, size of q [N, N m per metre], and their exact tangent, banded."""
        strains, across, along = self.strains(q)
        stretch, shear = strains[:, 0], strains[:, 1]
        b = np.zeros((self.settings.elements, 3, 6))  # d strain / d dof
        b[:, 0, 0:2], b[:, 0, 3:5] = -along / self.h, along / self.h
        b[:, 1, 0:2], b[:, 1, 3:5] = -across / self.h, across / self.h
        b[:, 0, 2] = b[:, 0, 5] = -0.5 * shear
        b[:, 1, 2] = b[:, 1, 5] = 0.5 * (1 + stretch)
        b[:, 2, 2], b[:, 2, 5] = -1 / self.h, 1 / self.h
        stress = self.stiffness * strains
        internal = self.h * np.einsum("ek,ekd->ed", stress, b)
        tangent = self.h * np.einsum("k,ekd,ekf->edf", self.stiffness, b, b)
        # Second derivatives of the strains: between place and rotation, and of the rotation twice.
        turn = 0.5 * (-stress[:, :1] * across + stress[:, 1:2] * along)  # d along = -across, d across = along
        twice = 0.25 * self.h * (-stress[:, 0] * (1 + stretch) - stress[:, 1] * shear)
        for angle in (2, 5):
            for place, sign in ((slice(0, 2), -1), (slice(3, 5), 1)):
                tangent[:, place, angle] += sign * turn
                tangent[:, angle, place] += sign * turn
            for other in (2, 5):
                tangent[:, angle, other] += twice
        assembled = np.bincount(self._dofs.ravel(), internal.ravel(), self.size)
        return assembled, self._band(tangent)

    def energies(self, state: State) -> dict[str, float]:
        """[J/m] of strain, of motion, and of height."""
        strains = self.strains(state.q)[0]
        return {"strain_energy": 0.5 * self.h * float(np.sum(self.stiffness * strains**2)),
                "kinetic_energy": 0.5 * float(state.v @ self.mass_times(state.v)),
                "potential_energy": -float(self.weight @ state.q)}

    def at_rest(self) -> State:
        zero = np.zeros(self.size)
        return self.static(State(zero, zero, zero))

    def static(self, start: State, load: Load | None = None) -> State:
        """Equilibrium under weight and load, found from `start`."""
        q, _ = self._newton(start.q, load, lambda q: (np.zeros_like(q), 0.0))
        zero = np.zeros(self.size)
        return State(q, zero, zero)

    def step(self, start: State, dt: float, load: Load) -> tuple[State, int]:
        """One step of Bossak's scheme (Wood, Bossak, Zienkiewicz 1981), load at its end; and the Newton
        iterations.

            (1 - alpha) M a1 + alpha M a0 + f_int(q1) = f1
            gamma = 1/2 - alpha ,   beta = (1 - alpha)^2 / 4
        """
        alpha = self.settings.bossak_alpha
        beta, gamma = (1 - alpha)**2 / 4, 0.5 - alpha
        guess = start.q + dt * start.v + dt**2 * (0.5 - beta) * start.a  # q1 for a1 = 0

        def inertia(q: np.ndarray) -> tuple[np.ndarray, float]:
            a = (q - guess) / (beta * dt**2)
            return (1 - alpha) * a + alpha * start.a, (1 - alpha) / (beta * dt**2)

        q, iterations = self._newton(start.q, load, inertia)
        a = (q - guess) / (beta * dt**2)
        v = start.v + dt * ((1 - gamma) * start.a + gamma * a)
        return State(q, v, a), iterations

    def _newton(self, q: np.ndarray, load: Load | None, inertia) -> tuple[np.ndarray, int]:
        """Balance of inertia, internal forces, weight and load from the guess q.

        inertia(q): the accelerations that act on the mass, and their derivative by q.
        """
        for iteration in range(MAX_NEWTON + 1):
            acceleration, factor = inertia(q)
            moved = self.mass_times(acceleration)
            internal, tangent = self.forces(q)
            outer, slope = load.on_axis(q) if load else (np.zeros(self.size), np.zeros(self.num_nodes))
            residual = (moved + internal - self.weight - outer)[3:]  # the foot is clamped
            size = max(np.linalg.norm(part[3:]) for part in (moved, internal, self.weight, outer))
            if not np.isfinite(size):
                raise NoSolution(f"Newton iteration {iteration}: forces are not finite")
            rounded = max(self.stiffness[0], factor * np.linalg.norm(self.mass_times(q)))
            allowed = max(TOLERANCE * size, ROUND_OFF * rounded)
            if np.linalg.norm(residual) <= allowed:
                return q, iteration
            matrix = tangent + factor * self.mass
            matrix[BAND, 2::3] -= slope
            q = q.copy()
            q[3:] -= solve_banded((BAND, BAND), free_part(matrix), residual)
        raise NoSolution(f"no balance after {MAX_NEWTON} Newton iterations: residual "
                         f"{np.linalg.norm(residual):.3g} N/m, allowed {allowed:.3g}")


def free_part(matrix: np.ndarray) -> np.ndarray:
    """The banded matrix without the three rows and columns of the clamped foot."""
    free = matrix[:, 3:].copy()
    for above in range(1, BAND + 1):  # entries that stood in the rows taken away
        free[BAND - above, :above] = 0
    return free
