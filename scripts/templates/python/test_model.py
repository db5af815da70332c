#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The model alone, without a coupler."""

import unittest

import model
import numpy as np


class Plate(unittest.TestCase):
    def setUp(self) -> None:
        self.force = np.zeros_like(model.POINTS)
        self.force[:, 0] = 2.0  # [N] on each point
        self.rest = self.force.sum(axis=0)[0] / model.STIFFNESS  # k u = F

    def test_rest(self) -> None:
        state = model.step(model.at_rest(), 1e9, self.force)
        self.assertAlmostEqual(state[0, 0] / self.rest, 1, delta=1e-9)
        self.assertEqual(state[0, 1], 0)
        self.assertEqual(model.displacement(state).shape, model.POINTS.shape)

    def error(self, steps: int) -> float:
        """Error after 0.1 s of a sudden load, against the closed form of the damped oscillator."""
        end, decay = 0.1, model.DAMPING / (2 * model.MASS)
        omega = np.sqrt(model.STIFFNESS / model.MASS - decay**2)
        exact = self.rest * (1 - np.exp(-decay * end) * (np.cos(omega * end) + decay / omega * np.sin(omega * end)))
        state = model.at_rest()
        for _ in range(steps):
            state = model.step(state, end / steps, self.force)
        return abs(state[0, 0] - exact)

    def test_order(self) -> None:
        """Implicit Euler is of first order: half the step, half the error."""
        self.assertAlmostEqual(np.log2(self.error(2000) / self.error(4000)), 1, delta=0.05)


if __name__ == "__main__":
    unittest.main()
