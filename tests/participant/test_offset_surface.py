#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""offset_surface: wet surfaces of beams and shells against closed forms."""

import sys
import unittest

import numpy as np
from fake_coupler import ROOT

sys.path[:0] = [str(ROOT / "protocol" / "python")]
from gabion_participant import offset_surface  # noqa: E402
from gabion_participant.offset_surface import OffsetSurface, circle, outline, rectangle, rotation_matrices  # noqa: E402
from gabion_participant.offset_surface import shell, tube, turned  # noqa: E402

UPRIGHT = np.stack([np.full(6, 0.255), np.linspace(0, 0.05, 6)], axis=1)
BENT = np.array([[0, 0], [1, 0.2], [1.7, 1], [1.5, 2.2], [2.5, 2.5]])
CURVE = np.array([[0, 0, 0], [0.5, 0.1, 0.2], [1, 0.5, 0.2], [1.2, 0.9, 0.7]])


def grid(across: int, up: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and quadrilaterals over the unit square at z = 0."""
    x, y = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, up + 1), indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(across), np.arange(up), indexing="ij"))
    first = i * (up + 1) + j
    return nodes, np.stack([first, first + up + 1, first + up + 2, first + 1], axis=1)


def surfaces() -> dict[str, OffsetSurface]:
    nodes, facets = grid(3, 2)
    curved = nodes + np.stack([0 * nodes[:, 0], 0 * nodes[:, 0], 0.3 * nodes[:, 0]**2 * nodes[:, 1]], axis=1)
    return {"outline": outline(BENT, 0.1, 0.07, (2, 3)), "left": outline(BENT, left=0.1),
            "right": outline(BENT, right=0.1), "shell": shell(curved, facets, 0.02, 0.05, True),
            "triangles": shell(curved, offset_surface.triangles(facets), 0.02, 0.05, True),
            "above": shell(curved, facets, above=0.0), "below": shell(curved, facets, below=0.1),
            "tube": tube(CURVE, rectangle(0.1, 0.2, (2, 3)), (0, 0, 1), ends=True),
            "strip": tube(CURVE, circle(0.1, 8)[:3], (0, 0, 1), closed=False)}


def enclosed(surface: OffsetSurface) -> tuple[float, np.ndarray]:
    """Volume (2D: area) by the divergence theorem, and the sum of the normals, 0 of what is closed."""
    corners = surface.coordinates[surface.facets]
    if corners.shape[2] == 2:
        way = corners[:, 1] - corners[:, 0]
        normal = np.stack([way[:, 1], -way[:, 0]], axis=1)
    elif corners.shape[1] == 3:
        normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    else:
        normal = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return float(np.sum(normal * corners.mean(axis=1))) / corners.shape[2], normal.sum(axis=0)


def random_motion(surface: OffsetSurface, size: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and rotations (angles, rotation vectors) of the nodes."""
    random = np.random.default_rng(seed)
    shape = surface.nodes.shape
    return size * random.standard_normal(shape), size * random.standard_normal(shape if shape[1] == 3 else shape[0])


class Shapes(unittest.TestCase):
    def test_outline_of_an_upright_wall(self) -> None:
        """The order of the granular obstacle: up the right face, over the top, down the left."""
        surface = outline(UPRIGHT, 0.005, 0.005, (0, 4))
        self.assertEqual(len(surface.coordinates), 15)
        np.testing.assert_allclose(surface.coordinates[[0, 5, 7, 9, 14]],
                                   [[0.26, 0], [0.26, 0.05], [0.255, 0.05], [0.25, 0.05], [0.25, 0]], atol=1e-15)
        np.testing.assert_array_equal(surface.facets, np.stack([np.arange(14), np.arange(1, 15)], axis=1))

    def test_one_face(self) -> None:
        for surface, x, rise in ((outline(UPRIGHT, right=0.005), 0.26, 1), (outline(UPRIGHT, left=0.005), 0.25, -1)):
            np.testing.assert_allclose(surface.coordinates[:, 0], x)
            way = np.diff(surface.coordinates[surface.facets], axis=1)[:, 0]
            np.testing.assert_array_equal(np.sign(way[:, 1]), rise)

    def test_faces_without_ends_stay_apart(self) -> None:
        surface = outline(UPRIGHT, 0.005, 0.005)
        self.assertEqual(len(surface.facets), 10)
        self.assertAlmostEqual(np.abs(np.diff(surface.coordinates[surface.facets], axis=1)).max(), 0.01)

    def test_bends_keep_the_thickness(self) -> None:
        """The area of a closed outline is thickness times length: the wedges at the bends cancel."""
        area, total = enclosed(outline(BENT, 0.1, 0.1, (1, 1)))
        self.assertAlmostEqual(area, 0.2 * np.linalg.norm(np.diff(BENT, axis=0), axis=1).sum(), delta=1e-14)
        np.testing.assert_allclose(total, 0, atol=1e-14)

    def test_shell_is_closed_and_has_its_volume(self) -> None:
        nodes, facets = grid(3, 2)
        for cells in (facets, offset_surface.triangles(facets)):
            volume, total = enclosed(shell(nodes, cells, 0.02, 0.05, True))
            self.assertAlmostEqual(volume, 0.07, delta=1e-15)
            np.testing.assert_allclose(total, 0, atol=1e-15)

    def test_shell_of_a_folded_plate_keeps_its_distance(self) -> None:
        nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 0], [1, 1, 1]], dtype=float)
        surface = shell(nodes, [[0, 1, 4, 3], [1, 2, 5, 4]], above=0.1)
        np.testing.assert_allclose(surface.coordinates[[1, 4], ::2], [[0.9, 0.1]] * 2, atol=1e-15)

    def test_tube_is_closed_and_has_its_volume(self) -> None:
        straight = np.stack([np.zeros(4), np.linspace(0, 3, 4), np.zeros(4)], axis=1)
        for section, area in ((rectangle(0.1, 0.2, (2, 3)), 0.02), (circle(0.1, 7), np.pi * 0.01)):
            volume, total = enclosed(tube(straight, section, (0, 0, 1), ends=True))
            self.assertAlmostEqual(volume, 3 * area, delta=1e-14)
            np.testing.assert_allclose(total, 0, atol=1e-15)
        first = tube(straight, rectangle(0.1, 0.2), (0, 0, 1)).offset[0]
        np.testing.assert_allclose(np.abs(first), [0.1, 0, 0.05], atol=1e-16)  # upwards: the side of 0.1

    def test_what_cannot_be(self) -> None:
        nodes, facets = grid(1, 1)
        for call, word in ((lambda: outline(UPRIGHT), "a wet face"),
                           (lambda: outline(UPRIGHT, 0.1, None, (0, 1)), "ends"),
                           (lambda: outline(np.array([[0, 0], [1, 0], [0, 0.0]]), 0.1), "turns back"),
                           (lambda: outline(np.zeros((2, 2)), 0.1), "one place"),
                           (lambda: shell(nodes, facets), "a wet face"),
                           (lambda: shell(nodes, facets, 0.1, rim=True), "rim"),
                           (lambda: shell(0 * nodes, facets, 0.1), "without area"),
                           (lambda: tube(CURVE[:, [2, 2, 0]] * [0, 0, 1], circle(1, 5), (0, 0, 1)), "across")):
            with self.assertRaisesRegex(ValueError, word):
                call()


class Motion(unittest.TestCase):
    def test_rigid_motion_is_exact(self) -> None:
        for name, surface in surfaces().items():
            with self.subTest(name):
                dimension = surface.nodes.shape[1]
                rotation = np.array([2.3]) if dimension == 2 else np.array([[1.1, -2.0, 0.7]])
                matrix = rotation_matrices(rotation, dimension)[0]
                u = surface.nodes @ matrix.T + np.arange(dimension) - surface.nodes
                same = np.repeat(rotation, len(surface.nodes), axis=0)
                np.testing.assert_allclose(surface.coordinates + surface.displacement(u, same),
                                           surface.coordinates @ matrix.T + np.arange(dimension), atol=1e-14)

    def test_rotation_matrices(self) -> None:
        vectors = np.array([[0, 0, 0.5 * np.pi], [0, 0, 0], [1e-9, 0, 0], [0.3, -0.4, 2.0]])
        matrices = rotation_matrices(vectors, 3)
        np.testing.assert_allclose(matrices[0], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
        np.testing.assert_array_equal(matrices[1], np.eye(3))
        self.assertEqual(matrices[2][2, 1], 1e-9)
        one = np.broadcast_to(np.eye(3), (4, 3, 3))
        np.testing.assert_allclose(matrices @ matrices.swapaxes(1, 2), one, atol=1e-15)
        np.testing.assert_allclose(matrices[3] @ vectors[3], vectors[3], atol=1e-15)
        np.testing.assert_allclose(turned(matrices, -vectors), one, atol=1e-15)

    def test_nodes_without_rotations_carry_in_parallel(self) -> None:
        for surface in surfaces().values():
            u, _ = random_motion(surface, 1.0, 1)
            np.testing.assert_array_equal(surface.displacement(u, None), u[surface.carrier])


class Work(unittest.TestCase):
    def test_force_and_moment_are_those_of_the_points(self) -> None:
        for name, surface in surfaces().items():
            with self.subTest(name):
                u, rotation = random_motion(surface, 1.0, 2)
                force = np.random.default_rng(3).standard_normal(surface.offset.shape)
                arms = surface.arms(rotation)
                on_nodes = surface.forces(force)
                np.testing.assert_allclose(on_nodes.sum(axis=0), force.sum(axis=0), atol=1e-13)
                place = surface.nodes + u
                expected = np.cross(place[surface.carrier] + arms, force).sum(axis=0)
                found = np.cross(place, on_nodes).sum(axis=0) + surface.moments(force, arms).sum(axis=0)
                np.testing.assert_allclose(found, expected, atol=1e-12)

    def test_virtual_work(self) -> None:
        """Forces do the work of a central difference of the points, the rotation turned by spins; order 2."""
        for name, surface in surfaces().items():
            with self.subTest(name):
                dimension = surface.nodes.shape[1]
                u, rotation = random_motion(surface, 1.0, 4)
                du, spin = random_motion(surface, 1.0, 5)
                force = np.random.default_rng(6).standard_normal(surface.offset.shape)
                matrices = rotation_matrices(rotation, dimension)

                def moved(step: float) -> np.ndarray:
                    return surface.displacement(u + step * du, rotation_matrices(step * spin, dimension) @ matrices)

                moments = surface.moments(force, surface.arms(matrices))
                work = np.sum(surface.forces(force) * du) + np.sum(moments * spin)
                errors = [abs(np.sum(force * (moved(h) - moved(-h))) / (2 * h) - work) for h in (1e-2, 1e-3)]
                self.assertLess(errors[1], 1e-5)
                self.assertTrue(errors[1] < 1e-10 or errors[0] / errors[1] > 90, errors)

    def test_work_of_a_constant_force_over_a_finite_step(self) -> None:
        """Mean arms, and 2 tan(angle / 2) n in place of the rotation of the step: exact."""
        for name, surface in surfaces().items():
            with self.subTest(name):
                dimension = surface.nodes.shape[1]
                u, before = random_motion(surface, 1.0, 7)
                du, spin = random_motion(surface, 0.7, 8)
                force = np.random.default_rng(9).standard_normal(surface.offset.shape)
                matrices = rotation_matrices(before, dimension)
                after = rotation_matrices(spin, dimension) @ matrices
                arms = 0.5 * (surface.arms(matrices) + surface.arms(after))
                angle = np.abs(spin) if dimension == 2 else np.linalg.norm(spin, axis=1, keepdims=True)
                turn = np.tan(0.5 * angle) / (0.5 * angle) * spin
                work = np.sum(force * (surface.displacement(u + du, after) - surface.displacement(u, matrices)))
                found = np.sum(surface.forces(force) * du) + np.sum(surface.moments(force, arms) * turn)
                self.assertAlmostEqual(found, work, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
