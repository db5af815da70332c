#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The beam of configs/granular_obstacle_external against closed forms."""

import math
import sys
import unittest

import numpy as np
from fake_coupler import ROOT

sys.path[:0] = [str(ROOT / "configs" / "granular_obstacle_external")]
from beam import BAND, Beam, BeamSettings, Load, State  # noqa: E402
from structure import Outline, read_wall  # noqa: E402

LENGTH, THICKNESS, YOUNG, DENSITY = 0.05, 0.01, 1e6, 1100.0
EI = YOUNG * THICKNESS**3 / 12


def beam(elements: int = 40, **changes) -> Beam:
    values = {"foot": (0.255, 0.0), "length": LENGTH, "thickness": THICKNESS, "elements": elements,
              "density": DENSITY, "young_modulus": YOUNG, "gravity": 0.0, "bossak_alpha": 0.0} | changes
    return Beam(BeamSettings(**values))


def slender(elements: int, **changes) -> Beam:
    """Neither stretch nor shear matter: a tenth of the thickness, the same EI."""
    return beam(elements, thickness=THICKNESS / 10, young_modulus=YOUNG * 1e3, **changes)


def tip(structure: Beam, force: tuple[float, float], offset: float = 0.0) -> Load:
    return Load(np.array([structure.num_nodes - 1]), np.array([offset]), np.array([force]))


def static_tip(structure: Beam, force: tuple[float, float], loads: int = 1) -> np.ndarray:
    """(x, y, theta) of the tip, the force put on in equal parts."""
    state = structure.at_rest()
    for k in range(1, loads + 1):
        state = structure.static(state, tip(structure, (force[0] * k / loads, force[1] * k / loads)))
    return state.q[-3:]


def random_state(structure: Beam, size: float) -> np.ndarray:
    return size * np.random.default_rng(1).standard_normal(structure.size)


def dense(matrix: np.ndarray) -> np.ndarray:
    size = matrix.shape[1]
    full = np.zeros((size, size))
    for i in range(size):
        for j in range(max(0, i - BAND), min(size, i + BAND + 1)):
            full[i, j] = matrix[BAND + i - j, j]
    return full


def elastica(alpha: float) -> tuple[float, float]:
    """Deflection and shortening by L of an inextensible cantilever under a dead tip load alpha = P L^2 / (E
    I) across
    its axis: theta'' = -alpha cos(theta), shooting for the slope at the tip (Bisshopp, Drucker 1945)."""
    def shoot(slope: float, steps: int = 1000) -> np.ndarray:
        def rate(y: np.ndarray) -> np.ndarray:
            return np.array([y[1], -alpha * math.cos(y[0]), math.sin(y[0]), math.cos(y[0])])

        y, ds = np.array([slope, 0.0, 0.0, 0.0]), 1 / steps  # theta, dtheta/ds, across, along; s from the tip
        for _ in range(steps):
            k1 = rate(y)
            k2 = rate(y + ds / 2 * k1)
            k3 = rate(y + ds / 2 * k2)
            y = y + ds / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + ds * k3))
        return y

    low, high = 0.0, math.pi / 2
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if shoot(middle)[0] > 0 else (middle, high)
    end = shoot(0.5 * (low + high))
    return end[2], 1 - end[3]


class Forces(unittest.TestCase):
    def test_tangent_against_differences(self) -> None:
        structure = beam(4)
        q, step = random_state(structure, 0.3), 1e-6
        tangent = dense(structure.forces(q)[1])
        for j in range(structure.size):
            d = np.zeros(structure.size)
            d[j] = step
            difference = (structure.forces(q + d)[0] - structure.forces(q - d)[0]) / (2 * step)
            np.testing.assert_allclose(tangent[:, j], difference, rtol=0, atol=1e-7 * np.abs(tangent).max())

    def test_forces_are_the_slope_of_the_energy(self) -> None:
        structure = beam(4)
        q, step = random_state(structure, 0.3), 1e-6
        zero = np.zeros(structure.size)
        forces = structure.forces(q)[0]
        for j in range(structure.size):
            d = np.zeros(structure.size)
            d[j] = step
            up, down = (structure.energies(State(x, zero, zero))["strain_energy"] for x in (q + d, q - d))
            self.assertAlmostEqual((up - down) / (2 * step), forces[j], delta=1e-7 * np.abs(forces).max())

    def test_rigid_motion_is_free(self) -> None:
        structure = beam(5)
        angle, shift = 2.0, np.array([0.3, -0.2])
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        place = np.stack([np.zeros(6), structure.height], axis=1)
        q = np.concatenate([place @ turn.T - place + shift, np.full((6, 1), angle)], axis=1).ravel()
        self.assertLess(np.abs(structure.forces(q)[0]).max(), 1e-10 * structure.stiffness[0])

    def test_mass_of_a_uniform_motion(self) -> None:
        structure = beam(7)
        for direction in (0, 1):
            v = np.zeros(structure.size)
            v[direction::3] = 2.0
            kinetic = structure.energies(State(v * 0, v, v))["kinetic_energy"]
            self.assertAlmostEqual(kinetic, 0.5 * DENSITY * LENGTH * THICKNESS * 4, delta=1e-12)


class Statics(unittest.TestCase):
    def test_small_tip_load(self) -> None:
        """Timoshenko: P L^3 / (3 EI) + P L / (k GA); a linear element with one point errs by 1/(4 n^2) of the
        first."""
        force = 1e-3
        bending, shear = force * LENGTH**3 / (3 * EI), force * LENGTH / (5 / 6 * YOUNG / 2 * THICKNESS)
        for elements in (5, 10, 40):
            found = static_tip(beam(elements), (force, 0))
            self.assertAlmostEqual(found[0] / (bending * (1 - 1 / (4 * elements**2)) + shear), 1, delta=1e-7)
            self.assertAlmostEqual(found[2] / (-force * LENGTH**2 / (2 * EI)), 1, delta=1e-7)

    def test_elastica(self) -> None:
        """Second order in the element size, and the limit."""
        for alpha in (1.0, 2.0):
            exact = elastica(alpha)
            deflections = []
            for elements in (10, 20, 40):
                found = static_tip(slender(elements), (alpha * EI / LENGTH**2, 0), loads=4)
                deflections.append(found[0] / LENGTH)
                self.assertAlmostEqual(-found[1] / LENGTH / exact[1], 1, delta=2.0 / elements**2)
            self.assertAlmostEqual(deflections[-1] / exact[0], 1, delta=5e-4)
            coarse, middle, fine = deflections
            self.assertAlmostEqual(math.log2((middle - coarse) / (fine - middle)), 2, delta=0.1)

    def test_published_elastica(self) -> None:
        """Mattiasson (1981), figures of his table for alpha = 1, which this file's own solution must give."""
        deflection, shortening = elastica(1.0)
        self.assertAlmostEqual(deflection, 0.3017, delta=5e-5)
        self.assertAlmostEqual(shortening, 0.0564, delta=5e-5)

    def test_full_circle_under_an_end_moment(self) -> None:
        """M = 2 pi EI / L rolls the beam up: the tip comes back to the foot. A couple of dead forces cannot
        do that,
        so the inverse: the curved state needs this moment and nothing else inside."""
        structure = slender(64)
        n = structure.settings.elements
        theta = 2 * math.pi * np.arange(n + 1) / n
        middle = 0.5 * (theta[1:] + theta[:-1])
        segments = structure.h * np.stack([-np.sin(middle), np.cos(middle)], axis=1)
        place = np.concatenate([np.zeros((1, 2)), np.cumsum(segments, axis=0)])
        straight = np.stack([np.zeros(n + 1), structure.height], axis=1)
        q = np.concatenate([place - straight, theta[:, None]], axis=1).ravel()
        forces = structure.forces(q)[0]
        moment = 2 * math.pi * EI / LENGTH
        self.assertAlmostEqual(forces[-1] / moment, 1, delta=1e-9)
        self.assertLess(np.abs(forces[3:-1]).max(), 1e-8 * moment)
        self.assertLess(np.abs(place[-1]).max(), 1e-14)

    def test_own_weight(self) -> None:
        """rho g L^2 / (2 E) shorter."""
        found = beam(gravity=9.81).at_rest().q
        self.assertAlmostEqual(found[-2] / (-DENSITY * 9.81 * LENGTH**2 / (2 * YOUNG)), 1, delta=1e-3)
        self.assertAlmostEqual(found[-3], 0, delta=1e-15)

    def test_eccentric_load_bends_by_its_moment(self) -> None:
        """A tip force along the axis at distance e is the moment e P."""
        force, offset = 1e-4, THICKNESS / 2
        structure = beam(10)
        q = structure.static(structure.at_rest(), tip(structure, (0, force), offset)).q
        self.assertAlmostEqual(q[-1] / (offset * force * LENGTH / EI), 1, delta=2e-6)


class Motion(unittest.TestCase):
    def test_first_frequency(self) -> None:
        """(1.8751)^2 sqrt(EI / (rho A L^4)) of a slender cantilever; 20 elements, 200 steps a period."""
        structure = slender(20)
        omega = 1.875104**2 * math.sqrt(EI / (DENSITY * THICKNESS / 10 * LENGTH**4))
        state = structure.static(structure.at_rest(), tip(structure, (0.1, 0)))
        dt = 2 * math.pi / omega / 200
        free, crossings, before = tip(structure, (0, 0)), [], state.q[-3]
        for n in range(1, 411):
            state, _ = structure.step(state, dt, free)
            now = state.q[-3]
            if before > 0 >= now or before < 0 <= now:
                crossings.append((n - now / (now - before)) * dt)
            before = now
        period = 2 * (crossings[-1] - crossings[0]) / (len(crossings) - 1)
        self.assertAlmostEqual(period * omega / (2 * math.pi), 1, delta=2e-3)

    def swing(self, alpha: float, force: float, dt: float = 2e-4) -> list[float]:
        """Energy at each step of a beam that is let go."""
        structure = beam(10, bossak_alpha=alpha)
        state = structure.static(structure.at_rest(), tip(structure, (force, 0)))
        free, energies = tip(structure, (0, 0)), []
        for _ in range(400):
            state, _ = structure.step(state, dt, free)
            energies.append(sum(structure.energies(state).values()))
        return energies

    def test_energy(self) -> None:
        """Kept by the trapezoidal rule where the beam is nearly linear, and nearly where it is not; Bossak
        takes some,
        and no scheme makes any."""
        small = self.swing(0.0, 1e-3)
        self.assertLess((max(small) - min(small)) / small[0], 1e-6)
        large = self.swing(0.0, 10.0)
        self.assertLess((max(large) - min(large)) / large[0], 0.01)
        damped = self.swing(-0.3, 10.0, 2e-3)
        self.assertLess(damped[-1], 0.9 * damped[0])
        self.assertLess(max(damped), 1.001 * damped[0])

    def test_momentum_of_one_step(self) -> None:
        """Mass times acceleration and inner forces balance the load, but for the reaction at the foot."""
        structure = beam(10)
        start = structure.at_rest()
        load = tip(structure, (3.0, 1.0))
        state, iterations = structure.step(start, 1e-5, load)
        self.assertLess(iterations, 6)
        balance = structure.mass_times(state.a) + structure.forces(state.q)[0] - load.on_axis(state.q)[0]
        self.assertLess(np.linalg.norm(balance[3:]), 1e-9)


class Surface(unittest.TestCase):
    def setUp(self) -> None:
        self.beam = beam(6)
        self.outline = Outline(self.beam, 4)
        self.q = random_state(self.beam, 0.2)

    def test_steps_that_end_a_run(self) -> None:
        """However short: the rounding of a displacement is a large acceleration then."""
        structure = beam(bossak_alpha=-0.3)
        push = tip(structure, (3.0, 0.0))
        moving = structure.at_rest()
        for _ in range(20):
            moving, _ = structure.step(moving, 1e-3, push)
        for dt in (1e-5, 1e-6, 1e-7, 1e-8):
            state = moving
            for _ in range(5):
                state, _ = structure.step(state, dt, push)
            way = np.linalg.norm(state.q - moving.q) / np.linalg.norm(moving.v)
            self.assertAlmostEqual(way / (5 * dt), 1, delta=0.02)

    def test_outline(self) -> None:
        points = self.outline.coordinates
        np.testing.assert_allclose(points[[0, 6, 8, 10, 16]], [[0.26, 0], [0.26, 0.05], [0.255, 0.05], [0.25, 0.05],
                                                               [0.25, 0]], atol=1e-15)
        self.assertEqual(self.outline.corner, 10)
        way = np.diff(points, axis=0)
        out = np.stack([way[:, 1], -way[:, 0]], axis=1)  # to the right of the outline's direction
        self.assertTrue((np.sum(out * (points[:-1] - [0.255, 0.02]), axis=1) > 0).all())

    def test_forces_do_the_work_of_the_surface(self) -> None:
        """f . du of the points = F . dq of the axis, and the slope of the moments."""
        random = np.random.default_rng(2)
        force = random.standard_normal(self.outline.coordinates.shape)
        d, step = random.standard_normal(self.beam.size), 1e-6
        points = [self.outline.displacement(self.q + sign * step * d) for sign in (1, -1)]
        work = np.sum(force * (points[0] - points[1])) / (2 * step)
        load = self.outline.load(force)
        on_axis, slope = load.on_axis(self.q)
        self.assertAlmostEqual(work, on_axis @ d, delta=1e-7)
        difference = (load.on_axis(self.q + step * d)[0] - load.on_axis(self.q - step * d)[0]) / (2 * step)
        np.testing.assert_allclose(difference[2::3], slope * d[2::3], atol=1e-7)

    def test_a_turned_section_carries_its_points_rigidly(self) -> None:
        q = np.zeros(self.beam.size)
        q[2::3] = math.pi / 2
        np.testing.assert_allclose(self.outline.displacement(q)[0], [-0.005, 0.005], atol=1e-17)


class Settings(unittest.TestCase):
    def test_wrong_values_are_named(self) -> None:
        for change, allowed in (({"length": 0.0}, "length: found 0.0, allowed: > 0"), ({"elements": 0}, "elements"),
                                ({"bossak_alpha": 0.1}, "-1/3 to 0"), ({"poisson_ratio": 0.5}, "between -1 and 0.5")):
            with self.subTest(change), self.assertRaisesRegex(ValueError, allowed):
                beam(**({"elements": 4} | change))

    def test_the_scenes_settings(self) -> None:
        path = ROOT / "configs" / "granular_obstacle_external" / "structure.json"
        wall = read_wall(path)
        self.assertEqual(wall.probe_names(), ["A.ux", "A.uy"])
        self.assertAlmostEqual(wall.probes()[1], -DENSITY * 9.81 * LENGTH**2 / (2 * YOUNG), delta=1e-7)


if __name__ == "__main__":
    unittest.main()
