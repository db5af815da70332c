# SPDX-License-Identifier: BSD-3-Clause
"""What theory says of beams, blocks and earth pressure. SI units; in the plane forces are per metre."""

import numpy as np


def plane_strain_stiffness(young: float, poisson: float, thickness: float) -> float:
    """EI of a strip [N m], E t^3 / 12 / (1 - nu^2)."""
    return young * thickness**3 / 12 / (1 - poisson**2)


def turned(angle: np.ndarray, way: np.ndarray) -> np.ndarray:
    """A direction (2) turned by angles (n) against the clock: n x 2."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * way[0] - s * way[1], s * way[0] + c * way[1]])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """z component of a x b in the plane; last axis 2."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def bent_axis(stations: np.ndarray, forces: np.ndarray, moments: np.ndarray, stiffness: float,
              way: np.ndarray) -> np.ndarray:
    """Axis of an inextensible beam without shear, clamped at its start, in its own bent shape.

    The curvature is M / EI in the middle between stations, constant there; M is the moment of what acts behind it.

    @param stations   n, along the axis from the clamp, where s = 0 [m]
    @param forces     n x 2, at the stations, their direction stays [N]
    @param moments    n, about the axis there, against the clock [N m]
    @param stiffness  EI [N m^2]
    @param way        2, direction of the straight axis
    @return           n x 2, places relative to the clamp [m]
    """
    ds = np.diff(stations)
    behind, turning = _behind(forces), _behind(moments)
    angle = np.zeros(len(stations))
    for _ in range(1000):
        steps = ds[:, None] * turned((angle[1:] + angle[:-1]) / 2, way)
        axis = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        middle = (axis[1:] + axis[:-1]) / 2
        bending = _behind(cross(axis, forces)) - cross(middle, behind) + turning
        new = np.concatenate([[0.0], np.cumsum(bending * ds / stiffness)])
        change = np.abs(new - angle).max()
        angle += 0.3 * (new - angle)  # a whole step overshoots where the load turns the beam far
        if change < 1e-12:
            return axis
    raise ArithmeticError(f"the beam's shape does not settle: its angle changes by {change:.2g}")


def _behind(values: np.ndarray) -> np.ndarray:
    """Sum over the stations behind each interval between stations."""
    return np.cumsum(values[::-1], axis=0)[::-1][1:]


def cantilever_tip(heights: np.ndarray, forces: np.ndarray, moments: np.ndarray, length: float,
                   stiffness: float) -> float:
    """Deflection of the tip of a straight cantilever by Euler and Bernoulli, small, along the forces [m].

    @param heights  above the clamp [m]
    @param forces   across the axis [N]
    @param moments  that bend it the same way [N m]
    """
    return float(np.sum(forces * heights**2 * (3 * length - heights) / 6
                        + moments * heights * (length - heights / 2)) / stiffness)


def earth_pressure_at_rest(density: float, gravity: float, height: float, poisson: float) -> float:
    """Force of level elastic soil that cannot move to the side [N/m], nu / (1 - nu) rho g H^2 / 2."""
    return poisson / (1 - poisson) * density * gravity * height**2 / 2


def earth_pressure_at_soft_contact(rest: np.ndarray, young: float, poisson: float, width: float,
                                   contact: float) -> np.ndarray:
    """Pressure of layers of soil at rest that each move by the depth of their contact, p = (contact depth)^2 [Pa].

    p = rest - E / (1 - nu^2) depth / width, the load of the layers above staying.

    @param rest     pressure of the layers that cannot move [Pa]
    @param width    of the soil [m]
    @param contact  root of the pressure by the depth [Pa^(1/2) / m]
    """
    slope = young / (1 - poisson**2) / width / contact
    return ((np.sqrt(slope**2 + 4 * rest) - slope) / 2) ** 2


def block_acceleration(along: float, across: float, friction: float) -> float:
    """Acceleration of a rigid block that slides down a slope [m/s^2]. @param along, across gravity, both
    positive"""
    return along - friction * across


def fall_line_acceleration(slope: np.ndarray, gravity: float, friction: float) -> np.ndarray:
    """Acceleration of rigid blocks that begin to slide, each down the fall line at its place; 0 where
    friction holds it.

    @param slope  n x 2, gradient of the height [-]
    @return       n x 2, horizontal part [m/s^2]
    """
    steep = np.linalg.norm(slope, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(steep > friction, 1 - friction / steep, 0.0)
    return -gravity * share[:, None] * slope / (1 + steep[:, None] ** 2)
