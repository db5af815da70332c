#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The closed forms of scripts/bench scene_checks, and how forces, momentum and beams are read from results."""

import json
import unittest

import numpy as np
from script_case import ScriptCase

import made_up_results as made_up
from plotting.results import Frame, Results, ResultsError
from studies import balances, gate_checks, posts_checks, scene_course, slope_checks, terrain_checks
from studies.closed_forms import (
    bent_axis, block_acceleration, cantilever_tip, earth_pressure_at_rest, earth_pressure_at_soft_contact,
    fall_line_acceleration, plane_strain_stiffness,
)
from studies.measures import Measured

DOWN = np.array([0.0, -1.0])


def end_load(load: np.ndarray, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Stations of a beam of length 1 and a force at its end."""
    forces = np.zeros((count + 1, 2))
    forces[-1] = load
    return np.linspace(0, 1, count + 1), forces


class Beam(unittest.TestCase):
    def test_small_deflection(self) -> None:
        stations, forces = end_load([3e-4, 0])
        axis = bent_axis(stations, forces, np.zeros(len(stations)), 1.0, DOWN)
        np.testing.assert_allclose(axis[:, 0], 3e-4 * stations**2 * (3 - stations) / 6, rtol=1e-4, atol=1e-9)
        np.testing.assert_allclose(axis[:, 1], -stations, rtol=1e-7)

    def test_end_load_of_bisshopp_and_drucker(self) -> None:
        for load, across, along in ((1, 0.3017, 0.9436), (2, 0.4935, 0.8394), (10, 0.8106, 0.4450)):
            stations, forces = end_load([load, 0])
            axis = bent_axis(stations, forces, np.zeros(len(stations)), 1.0, DOWN)
            np.testing.assert_allclose(axis[-1], [across, -along], atol=1e-4)

    def test_end_moment_makes_a_circle(self) -> None:
        stations, forces = end_load([0, 0])
        moments = np.zeros(len(stations))
        moments[-1] = np.pi
        axis = bent_axis(stations, forces, moments, 2.0, np.array([1.0, 0.0]))
        np.testing.assert_allclose(axis[-1], [2 / np.pi, 2 / np.pi], rtol=1e-5)  # a quarter, against the clock

    def test_pull_along_the_axis_leaves_it_straight(self) -> None:
        stations, forces = end_load([0, -5])
        axis = bent_axis(stations, forces, np.zeros(len(stations)), 1.0, DOWN)
        np.testing.assert_allclose(axis, np.outer(stations, DOWN), atol=1e-12)

    def test_stiffness(self) -> None:
        self.assertAlmostEqual(plane_strain_stiffness(1e6, 0.4, 0.02), 1e6 * 8e-6 / 12 / 0.84)

    def test_cantilever(self) -> None:
        one = np.array([1.0])
        self.assertAlmostEqual(cantilever_tip(2 * one, one, 0 * one, 2, 4), 8 / 3 / 4)
        self.assertAlmostEqual(cantilever_tip(2 * one, 0 * one, one, 2, 4), 4 / 2 / 4)
        heights = (np.arange(1000) + 0.5) / 1000 * 2
        self.assertAlmostEqual(cantilever_tip(heights, np.full(1000, 0.002 * 3), 0 * heights, 2, 4), 3 * 16 / 8 / 4,
                               places=5)


class Soil(unittest.TestCase):
    def test_earth_pressure(self) -> None:
        self.assertAlmostEqual(earth_pressure_at_rest(1600, 9.81, 0.2, 0.3), 0.3 / 0.7 * 1600 * 9.81 * 0.02)

    def test_soft_contact_lets_layers_move_by_its_depth(self) -> None:
        rest, contact = np.array([0.0, 500.0, 1300.0]), 3.7e5
        pressure = earth_pressure_at_soft_contact(rest, 1e6, 0.3, 0.2, contact)
        np.testing.assert_allclose(pressure, rest - 1e6 / 0.91 * np.sqrt(pressure) / contact / 0.2, atol=1e-9)
        np.testing.assert_allclose(earth_pressure_at_soft_contact(rest, 1e6, 0.3, 0.2, 1e12), rest, rtol=1e-5)

    def test_a_fall_line_along_x_is_a_block_on_a_plane(self) -> None:
        angle, friction = np.radians(35), 0.25
        found = fall_line_acceleration(np.array([[-np.tan(angle), 0], [0, np.tan(angle)]]), 9.81, friction)
        along = block_acceleration(9.81 * np.sin(angle), 9.81 * np.cos(angle), friction)
        np.testing.assert_allclose(found, [[along * np.cos(angle), 0], [0, -along * np.cos(angle)]], atol=1e-12)

    def test_friction_holds_on_flat_ground(self) -> None:
        np.testing.assert_array_equal(fall_line_acceleration(np.array([[0.0, 0.0], [0.1, 0.1]]), 9.81, 0.25), 0)


class Reading(ScriptCase):
    def run_of_blocks(self) -> Measured:
        """1 kg: from rest with 3 m/s^2 along x against 1 N of the bed, at a wall of 4 N from 0.2 s on."""
        steps, dt = 40, 0.01
        times = dt * np.arange(steps + 1)
        wall = np.where(times[1:] > 0.2 + 1e-9, 4.0, 0.0)
        momentum = np.concatenate([[0.0], np.cumsum((3 - 1 - wall) * dt)])
        place = np.concatenate([[0.0], np.cumsum(dt * (momentum[1:] + momentum[:-1]) / 2)])
        made_up.write_table(self.folder / "probes.csv",
                            ["time", "soil.mass", "soil.momentum_x", "soil.bed.fx", "soil.front"],
                            [[t, 1, p, 1 if t else 0, x] for t, p, x in zip(times, momentum, place)])
        made_up.write_table(self.folder / "steps.csv", ["time", "dt", "fx"],
                            [[t, dt, f] for t, f in zip(times[1:], wall)])
        (self.folder / "summary.json").write_text(json.dumps({"completed": True}))
        return Measured(Results(self.folder))

    def test_momentum_of_a_block(self) -> None:
        run = self.run_of_blocks()
        last = balances.arrival(run)
        self.assertEqual(last, 20)
        self.assertAlmostEqual(balances.mean_acceleration(run, last), 2)
        self.assertAlmostEqual(balances.acceleration_by_force(run, "bed", 3.0, last), 2)
        self.assertAlmostEqual(balances.impulse(run.force().values, run, last, 40), 0.8)
        self.assertAlmostEqual(balances.front_speed(run, last, 0.1), 0.3)

    def test_a_blow(self) -> None:
        values = [value for _, value in scene_course.blow(self.run_of_blocks())]
        np.testing.assert_allclose(values, [0.2, 0.3, 4e-3, 100])

    def test_soil_that_never_arrives_is_named(self) -> None:
        run = self.run_of_blocks()
        made_up.write_table(self.folder / "steps.csv", ["time", "dt", "fx"], [[0.01, 0.01, 0]])
        with self.assertRaisesRegex(ResultsError, "never reaches"):
            balances.arrival(run)

    def test_ledger_ends_before_soil_leaves(self) -> None:
        head = ["time", *(f"soil.{name}" for name in ("removed_mass", "gravity_work", "momentum_x", "energy_balance",
                                                      "momentum_error_x", "created_energy", "contact_created"))]
        rows = [[0, 0, 0, 0, 0, 0, 0, 0], [1, 0, 2000, 8, 5, 1, 0, 3], [2, 500, 4000, -9, 50, 10, 0, 7]]
        made_up.write_table(self.folder / "probes.csv", head, rows)
        (self.folder / "summary.json").write_text(json.dumps({"completed": True}))
        found = balances.ledger_rows(Measured(Results(self.folder)), 1e3, "kJ")
        self.assertEqual([row[2] for row in found], [0.005, 1, 0.05, 10, 0, 0.007])
        self.assertIn("to 1 s, gravity gives 4", found[0][0])
        self.assertIn("0.5 t left", found[2][0])
        made_up.write_table(self.folder / "probes.csv", head, rows[:2])
        self.assertEqual(len(balances.ledger_rows(Measured(Results(self.folder)), 1, "J")), 4)

    def test_forces_of_facets_act_away_from_the_soil(self) -> None:
        points = np.array([[0.2, 0.0, 0], [0.2, 2, 0], [0.0, 2, 0], [0.0, 0, 0]])  # up, over, down: soil outside
        frame = Frame(0.0, points, np.array([[0, 1], [1, 2], [2, 3]]),
                      {"pressure": np.array([10.0, 20, 30]), "shear": np.array([[0.0, -1, 0], [2, 0, 0], [0, -3, 0]])})
        np.testing.assert_allclose(slope_checks.facet_forces(frame), [[-20, -2], [0.4, -4], [60, -6]])

    def test_tip_under_forces_of_facets(self) -> None:
        points = np.array([[1.0, 2.0, 0], [1.0, 1.0, 0]])  # the upper half of the left face
        frame = Frame(0.0, points, np.array([[0, 1]]),
                      {"pressure": np.array([10.0]), "shear": np.array([[0, -2.0, 0]])})
        low, high = np.array([1.0, 0.0]), np.array([1.4, 2.0])
        expected = (10 * 1.5**2 * (6 - 1.5) / 6 - 0.2 * 2 * 1.5 * (2 - 0.75)) / 7
        self.assertAlmostEqual(slope_checks.tip_of(frame, low, high, 7.0), expected)

    def test_a_beam_is_read_from_its_top(self) -> None:
        x, y = np.meshgrid([0.0, 0.1, 0.2], [0.0, 0.5, 1.0])
        start = np.column_stack([x.ravel(), y.ravel()])
        moved = np.column_stack([0.3 * (1 - start[:, 1]), np.zeros(9)])
        force = np.zeros((9, 2))
        force[0] = [1.0, -4.0]  # lower left corner
        fields = {"displacement": moved, "external_force": force}
        cells = np.array([[0, 1, 4, 3]])
        made_up.write_series(self.folder / "fem", "structure",
                             [(t, start + moved, cells, fields) for t in (0.0, 1.0)])
        beam = gate_checks.loaded_beam(Results(self.folder).structures[0], 0.5)
        np.testing.assert_allclose(beam.stations, [0, 0.5, 1])
        np.testing.assert_allclose(beam.axis, [[0, 0], [0.15, -0.5], [0.3, -1]])
        np.testing.assert_allclose(beam.forces, [[0, 0], [0, 0], [1, -4]])
        np.testing.assert_allclose(beam.moments, [0, 0, 0.4])

    def test_height_of_a_force_beside_the_origin(self) -> None:
        place, force = np.array([2.1, 0.0, 0.3]), np.array([10.0, 0, 4.0])  # on a post at x = 2
        moment = np.cross(place, force)[1]
        self.assertAlmostEqual(posts_checks.height_of_force(10, 4, moment, 2.0), 0.3 - 0.1 * 4 / 10)

    def test_every_largest_value_has_its_head(self) -> None:
        self.assertEqual(len(terrain_checks.gauge_head()), 1 + 2 * len(terrain_checks.LARGEST) - 1)


if __name__ == "__main__":
    unittest.main()
