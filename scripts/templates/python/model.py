# SPDX-License-Identifier: BSD-3-Clause
"""The structure: a rigid plate on a spring and a damper in each direction, m a + c v + k u = F."""

import numpy as np

DIMENSION = __DIMENSION__
LEFT, RIGHT, TOP = 0.16, 0.17, 0.05  # the plate from y = 0 up [m]
WIDTH = 0.1  # in z, in 3D [m]
SEGMENTS = 10  # of its height; in 3D of its width too
MASS, DAMPING, STIFFNESS = 0.6, 10.0, 5e3  # [kg], [N s/m], [N/m]; in 2D per metre of width


def surface() -> tuple[np.ndarray, np.ndarray]:
    """Points [m], num_points x dim, and facets (their points) of the surface that the soil can reach, at the start.

    Up the right side, over the top, down the left side: the soil is on the right of the line. In 3D this line is drawn
    along z.
    """
    up = np.linspace(0, TOP, SEGMENTS + 1)
    line = np.array([[RIGHT, y] for y in up] + [[LEFT, y] for y in up[::-1]])
    first = np.arange(len(line) - 1)
    if DIMENSION == 2:
        return line, np.stack([first, first + 1], axis=1)
    layers = np.linspace(0, WIDTH, SEGMENTS + 1)
    points = np.array([[x, y, z] for z in layers for x, y in line])
    first = np.concatenate([first + layer * len(line) for layer in range(SEGMENTS)])
    return points, np.stack([first, first + 1, first + 1 + len(line), first + len(line)], axis=1)


POINTS, FACETS = surface()


def at_rest() -> np.ndarray:
    """The state at the start. All that later steps depend on: displacement [m] and velocity [m/s] of the plate."""
    return np.zeros((2, DIMENSION))


def step(state: np.ndarray, dt: float, force: np.ndarray) -> np.ndarray:
    """The state after dt [s], by implicit Euler. `force`: of the soil on each point [N], as POINTS.

    A step without solution raises ConvergenceError of gabion_participant; a smaller dt follows.
    """
    u, v = state
    v_new = (force.sum(axis=0) + MASS / dt * v - STIFFNESS * u) / (MASS / dt + DAMPING + STIFFNESS * dt)
    return np.stack([u + dt * v_new, v_new])


def displacement(state: np.ndarray) -> np.ndarray:
    """[m] of each point, total: from where it was at the start."""
    return np.tile(state[0], (len(POINTS), 1))


def probes(state: np.ndarray) -> dict[str, float]:
    """Numbers for probes.csv."""
    return {f"plate.u{axis}": float(u) for axis, u in zip("xyz", state[0])}
