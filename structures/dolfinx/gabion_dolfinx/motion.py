# SPDX-License-Identifier: BSD-3-Clause
"""Newmark's family with Bossak's averaged inertia, and mean forces in it: docs/theory/structure.md, (T4) to (T9)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """u [m], v [m/s], a [m/s^2] of the owned unknowns, and the mean interface force F [N] of the step that led here."""

    u: np.ndarray
    v: np.ndarray
    a: np.ndarray
    F: np.ndarray

    def is_still(self) -> bool:
        return not (self.v.any() or self.a.any())


class Bossak:
    def __init__(self, alpha: float) -> None:
        self.alpha = alpha
        self.beta, self.gamma = 0.25 * (1 - alpha)**2, 0.5 - alpha
        self.c = (1 - alpha) / (2 * self.beta)  # the weight of a mean force in the balance at the end of the step

    def end(self, old: Motion, du: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocity and acceleration."""
        a = du / (self.beta * dt**2) - old.v / (self.beta * dt) - (0.5 / self.beta - 1) * old.a
        return old.v + dt * ((1 - self.gamma) * old.a + self.gamma * a), a

    def mean_acceleration(self, a: np.ndarray, old: np.ndarray) -> np.ndarray:
        return (1 - self.alpha) * a + self.alpha * old

    def slope(self, dt: float) -> float:
        """Derivative of the mean acceleration by du."""
        return (1 - self.alpha) / (self.beta * dt**2)

    def load(self, end: np.ndarray, F: np.ndarray, old: np.ndarray) -> np.ndarray:
        """Load in the balance: forces at the end of the step, and mean forces of this step and of the one before."""
        return end + self.c * F - (self.c - 1) * old

    def corrected(self, trial: Motion, y: np.ndarray, dt: float) -> Motion:
        """Motion at the end of an accepted step; M y = F - F_o."""
        return Motion(trial.u, trial.v + dt * (1 - self.gamma / (2 * self.beta)) * y,
                      trial.a - (0.5 / self.beta - 1) * y, trial.F)
