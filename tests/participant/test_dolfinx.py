#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""structures/dolfinx: surfaces, steps against closed forms, history, the scenes' laws, ranks, what goes wrong."""

import json
import os
import subprocess
import sys
import unittest
from pathlib import Path

import dolfinx_models as models
import numpy as np
import ufl
from dolfinx.mesh import CellType
from dolfinx_models import DENSITY, SIZE, YOUNG, Block, HeldBlock, SoftTop, Yielding, march, on_top
from mpi4py import MPI

from gabion_dolfinx.model import ModelError
from gabion_dolfinx.program import read_model
from gabion_dolfinx.structure import Structure
from gabion_participant import END_OF_STEP, STEP_MEAN, ConvergenceError, StepRequest
from running.mpi import find_launcher

COMM = MPI.COMM_SELF
SCENES = models.ROOT / "configs"
KINDS = [(2, CellType.triangle, (1, 2, 3)), (2, CellType.quadrilateral, (1, 2, 3)),
         (3, CellType.tetrahedron, (1, 2)), (3, CellType.hexahedron, (1, 2))]


def centre(structure: Structure, u: np.ndarray) -> np.ndarray:
    """Displacement of the centre of mass [m]."""
    nodal = structure.balance.mass_times(u).reshape(-1, structure.dimension)
    return nodal.sum(axis=0) / (DENSITY * np.prod(SIZE[:structure.dimension]))


class Surfaces(unittest.TestCase):
    def test_closed_and_around_the_volume(self) -> None:
        """Normals sum to zero, the divergence theorem gives the volume, all nodes of the boundary are vertices."""
        for dim, cell, degrees in KINDS:
            for degree in degrees:
                with self.subTest(f"{cell} {degree}"):
                    structure = Structure(Block(dim, cell, degree), COMM)
                    surface = structure.surfaces[0]
                    corners = surface.coordinates[surface.facets]
                    if dim == 2:
                        way = corners[:, 1] - corners[:, 0]
                        normals = np.stack([way[:, 1], -way[:, 0]], axis=1)
                    else:
                        last = 3 if corners.shape[1] == 4 else 1
                        a = corners[:, 2] - corners[:, 0]
                        b = corners[:, 3] - corners[:, 1] if last == 3 else corners[:, 1] - corners[:, 0]
                        normals = 0.5 * (np.cross(a, b) if last == 3 else np.cross(b, a))
                    volume = np.sum(normals * corners.mean(axis=1)) / dim
                    np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-14)
                    self.assertAlmostEqual(volume, np.prod(SIZE[:dim]), delta=1e-14)
                    nodes = structure.balance.V.tabulate_dof_coordinates()[:, :dim]
                    outside = (np.isclose(nodes, 0) | np.isclose(nodes, SIZE[:dim])).any(axis=1)
                    self.assertEqual(len(surface.coordinates), np.count_nonzero(outside))
                    np.testing.assert_allclose(nodes[surface.nodes], surface.coordinates[surface.vertices])


class Steps(unittest.TestCase):
    def test_impulse_of_a_mean_force(self) -> None:
        """F on a free mass m: F t^2 / (2 m) at the centre of mass after each step, whatever alpha."""
        mass, force, dt = DENSITY * SIZE[0] * SIZE[1], 12.0, 0.01
        for alpha in (0.0, -0.1, -0.3):
            structure = Structure(Block(bossak_alpha=alpha), COMM)
            structure.set_force_kinds({"wall": STEP_MEAN})
            for step in range(1, 5):
                request = StepRequest(step, 0, (step - 1) * dt, dt)
                structure.solve_step(request, on_top(structure, force))
                structure.accept_step(request, True)
                way = centre(structure, structure.motion.u)[0]
                self.assertAlmostEqual(way / (force * (step * dt)**2 / (2 * mass)), 1, delta=1e-10)

    def test_force_at_the_end_of_a_step(self) -> None:
        """Trapezoidal rule: a grows to F / m at the end of the first step, u = beta dt^2 F / m."""
        mass, force, dt = DENSITY * SIZE[0] * SIZE[1], 12.0, 0.01
        structure = Structure(Block(), COMM)
        structure.set_force_kinds({"wall": END_OF_STEP})
        structure.solve_step(StepRequest(1, 0, 0, dt), on_top(structure, force))
        self.assertAlmostEqual(centre(structure, structure.trial.u)[0] / (0.25 * dt**2 * force / mass), 1, delta=1e-10)

    def test_energy_of_a_mean_force(self) -> None:
        """Trapezoidal rule, linear: kinetic and elastic energy grow by exactly F . du (T9)."""
        structure = Structure(HeldBlock(), COMM)
        structure.set_force_kinds({"wall": STEP_MEAN})

        def energy() -> float:
            motion = structure.motion
            return 0.5 * (motion.v @ structure.balance.mass_times(motion.v)
                          + motion.u @ structure.balance.internal_forces(motion.u))

        for step, force in enumerate((10.0, -25.0, 3.0, 0.0, 40.0), 1):
            before, u = energy(), structure.motion.u
            request = StepRequest(step, 0, 0, 2e-3)
            received = on_top(structure, force)
            structure.solve_step(request, received)
            structure.accept_step(request, True)
            work = structure.nodal_forces(received)[1] @ (structure.motion.u - u)
            self.assertAlmostEqual(energy() - before, work, delta=1e-9 * abs(work) + 1e-12)

    def test_second_order_in_time(self) -> None:
        for alpha in (0.0, -0.3):
            ends = []
            for steps in (80, 160, 320, 1280):
                structure = Structure(HeldBlock(bossak_alpha=alpha, newton_tolerance=1e-10), COMM)
                structure.set_force_kinds({"wall": STEP_MEAN})
                dt = 0.02 / steps
                for step in range(1, steps + 1):
                    mean = 50.0 * ((step * dt)**3 - ((step - 1) * dt)**3) / (3 * dt) / 0.02**2  # of 50 (t / T)^2
                    request = StepRequest(step, 0, (step - 1) * dt, dt)
                    structure.solve_step(request, on_top(structure, mean))
                    structure.accept_step(request, True)
                ends.append(structure.probes()[0])
            errors = np.abs(np.array(ends[:-1]) - ends[-1])
            rates = np.log2(errors[:-1] / errors[1:])
            self.assertGreater(rates.min(), 1.85, f"{alpha} {errors}")

    def test_own_weight(self) -> None:
        """A bar that hangs: rho g L^2 / (2 E) at its end, exact with quadratic elements."""
        structure = Structure(HeldBlock(degree=2, gravity=(0.0, 9.81), initial_equilibrium=True), COMM)
        self.assertAlmostEqual(structure.probes()[1] / (DENSITY * 9.81 * SIZE[1]**2 / (2 * YOUNG)), 1, delta=1e-9)
        values, report = structure.solve_step(StepRequest(1, 0, 0, 1e-3), {})
        self.assertEqual(report.newton_iterations, 0)
        self.assertTrue(structure.accept_step(StepRequest(1, 0, 0, 1e-3), True).at_rest)

    def test_starts_with_the_acceleration_of_its_weight(self) -> None:
        structure = Structure(Block(gravity=(0.0, -9.81)), COMM)
        np.testing.assert_allclose(structure.motion.a.reshape(-1, 2), np.tile((0, -9.81), (12, 1)), atol=1e-9)

    def test_a_step_is_a_function_of_the_accepted_state(self) -> None:
        structure = Structure(SoftTop(gravity=(0.0, -9.81)), COMM)
        march(structure, 3, 1e-3, 40.0)
        request = StepRequest(4, 0, 3e-3, 1e-3)
        first, _ = structure.solve_step(request, on_top(structure, 60.0))
        structure.solve_step(request, on_top(structure, -90.0))
        structure.solve_step(StepRequest(4, 1, 3e-3, 5e-4), on_top(structure, 10.0))
        again, _ = structure.solve_step(request, on_top(structure, 60.0))
        np.testing.assert_array_equal(first["wall"], again["wall"])

    def test_forces_as_small_as_rounding(self) -> None:
        """1 + grad u has lost the strain of the first touch."""
        way = march(Structure(SoftTop(), COMM), 3, 1e-4, 1e-9)
        self.assertGreater(np.abs(way[-1]).max(), 0)

    def test_a_large_load_in_one_step(self) -> None:
        """The factor of the state at rest serves badly where the body is turned and stretched by a half: steps of
        Newton's method are shortened, and the factor is made anew."""
        for dt in (1e-2, 1e-1, 1.0):
            structure = Structure(SoftTop(), COMM)
            structure.set_force_kinds({"wall": STEP_MEAN})
            values, report = structure.solve_step(StepRequest(1, 0, 0.0, dt), on_top(structure, 3e4))
            self.assertLessEqual(report.newton_iterations, 12)
            self.assertGreater(np.abs(values["wall"]).max(), 0.2)

    def test_no_solution_leaves_the_state(self) -> None:
        class Breaks(SoftTop):
            """Has no forces where u_x > 1 mm."""

            def internal_work(self, u, w, old, dx):
                return super().internal_work(u, w, old, dx) + ufl.ln(1e-3 - u[0]) * w[0] * dx

        for model, force, words in ((Breaks(), 1e3, "forces are not finite"),
                                    (SoftTop(newton_iterations=1), 1e3, "no balance after 1 iterations")):
            structure = Structure(model, COMM)
            march(structure, 2, 1e-3, 1e-3)
            before = structure.motion
            with self.assertRaisesRegex(ConvergenceError, words):
                structure.solve_step(StepRequest(3, 0, 2e-3, 1.0), on_top(structure, force))
            self.assertIs(structure.motion, before)
            march(structure, 1, 1e-3, 1e-3)


class History(unittest.TestCase):
    def test_plastic_strain_stays(self) -> None:
        """A bar pulled slowly by its weight and let go: p = (s - YIELD) / HARDENING at each height, then s = 0 gives
        no more. s = rho g (L - y), to the mean over a cell."""
        pull = 9.81 * 1.2  # largest stress 3531 Pa
        structure = Structure(Yielding(degree=2, gravity=(0.0, pull), initial_equilibrium=True), COMM)
        p = structure.balance.history.cell_means("p")[:, 0]
        # Above 1 kPa the whole cell yields: the lowest two rows of three, of 0.1 m; mean stresses 2943 and 1766 Pa.
        excess = np.array([DENSITY * pull * (SIZE[1] - y) - Yielding.YIELD for y in (0.05, 0.15)])
        np.testing.assert_allclose(np.sort(p)[:1:-1], np.repeat(excess / Yielding.HARDENING, 2), rtol=1e-6)
        kept = structure.balance.history.old["p"].x.array.copy()
        structure.balance.set_u(np.zeros(structure.balance.size))
        structure.balance.history.renew()
        np.testing.assert_array_equal(structure.balance.history.old["p"].x.array, kept)

    def test_only_an_accepted_step_renews(self) -> None:
        structure = Structure(Yielding(), COMM)
        force = {"wall": np.zeros_like(structure.surfaces[0].coordinates)}
        force["wall"][:, 1] = 40.0
        request = StepRequest(1, 0, 0, 0.1)
        before, _ = structure.solve_step(request, force)
        field = structure.balance.history.old["p"].x.array
        self.assertEqual(np.abs(field).max(), 0)
        again, _ = structure.solve_step(request, force)
        np.testing.assert_array_equal(before["wall"], again["wall"])
        structure.accept_step(request, True)
        self.assertGreater(field.max(), 1e-4)

    def test_a_field_may_become_a_number(self) -> None:
        class Touched(HeldBlock):
            def fields(self):
                return {"touched": 0.0}

            def new_fields(self, u, old):
                return {"touched": 1}

        structure = Structure(Touched(), COMM)
        march(structure, 1, 1e-3, 1.0)
        np.testing.assert_array_equal(structure.balance.history.old["touched"].x.array, 1.0)

    def test_the_weakening_wall(self) -> None:
        """Under a uniform stretch of both directions k is W, and d follows from it; less stretch leaves both. The
        tangent is the derivative of the forces, while damage grows too."""
        structure = Structure(read_model(SCENES / "weakening_wall" / "structure.py"), COMM)
        balance = structure.balance
        places = balance.V.tabulate_dof_coordinates()[:, :2]
        for stretch in (1.05, 1.02):
            balance.set_u(((stretch - 1) * places).ravel())
            balance.history.renew()
            work = 0.25e6 * (2 * 1.05**2 - 2 - 4 * np.log(1.05))
            np.testing.assert_allclose(balance.history.old["k"].x.array, work, rtol=1e-9)
            np.testing.assert_allclose(balance.history.old["damage"].x.array, 0.6 * (1 - np.exp(-(work - 300) / 1200)),
                                       rtol=1e-9)
        u = (0.08 * places + 0.01 * np.sin(50 * places[:, ::-1])).ravel()
        way = np.where(balance.held, 0.0, np.cos(np.arange(balance.size)))
        structure.later.assemble(u, 0.0)
        structure.later.right.array[:] = way
        structure.later.matrix.mult(structure.later.right, structure.later.left)
        e = 1e-6
        slope = (balance.internal_forces(u + e * way) - balance.internal_forces(u - e * way)) / (2 * e)
        free = ~balance.held
        np.testing.assert_allclose(structure.later.left.array[free], slope[free], atol=1e-6 * np.abs(slope).max())


class Ranks(unittest.TestCase):
    def found(self, ranks: int) -> list[dict]:
        launcher = find_launcher()
        command = launcher.command([(ranks, [sys.executable, str(Path(models.__file__))])])
        environment = {**os.environ, **launcher.environment, "OPENBLAS_NUM_THREADS": "1"}
        ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=True)
        return [json.loads(line[6:]) for line in ended.stdout.splitlines() if line.startswith("found ")]

    def test_one_and_two(self) -> None:
        for one, two in zip(self.found(1), self.found(2), strict=True):
            self.assertEqual((one["ranks"], two["ranks"]), (1, 2))
            self.assertTrue(one["same_again"] and two["same_again"])
            self.assertEqual(one["facets"], two["facets"])
            np.testing.assert_allclose(one["coordinates"], two["coordinates"], atol=1e-15)
            largest = np.abs(one["way"]).max()
            self.assertGreater(largest, 1e-5)
            np.testing.assert_allclose(one["way"], two["way"], atol=1e-9 * largest)


class Mistakes(unittest.TestCase):
    def test_say_found_and_allowed(self) -> None:
        class NoFacet(Block):
            def interfaces(self):
                return {"wall": lambda x: np.isclose(x[0], 7)}

        class NoNode(Block):
            def supports(self):
                return [(lambda x: np.isclose(x[0], 7), (0,))]

        class NotAtANode(Block):
            def probes(self):
                return {"A": (0.033, 0.1)}

        class OtherFields(Yielding):
            def new_fields(self, u, old):
                return {"q": 1.0}

        for model, *words in (
                (NoFacet(), 'interface "wall": found no facet'), (NoNode(), "supports: found no node at support 0"),
                (NotAtANode(), 'probe "A"', "allowed: a node"),
                (OtherFields(), "new_fields: found ['q'], allowed: ['p']"),
                (Block(density=0.0), "Block.density: found 0.0"), (Block(gravity=(1, 2, 3)), "gravity", "2 components"),
                (Block(bossak_alpha=0.1), "-1/3 to 0")):
            with self.subTest(words[0]):
                with self.assertRaises(ModelError) as caught:
                    Structure(model, COMM)
                for word in words:
                    self.assertIn(word, str(caught.exception))

    def test_state_of_another_model(self) -> None:
        state = Structure(HeldBlock(), COMM, "a").save_state()
        for other in (Structure(HeldBlock(), COMM, "b"), Structure(HeldBlock(degree=2), COMM, "a")):
            with self.assertRaisesRegex(ValueError, "another model"):
                other.load_state(state)

    def test_no_file_no_model(self) -> None:
        with self.assertRaisesRegex(ModelError, "found no file"):
            read_model(Path("/nowhere.py"))
        with self.assertRaisesRegex(ModelError, "found 0 classes"):
            read_model(SCENES / "granular_obstacle_external" / "beam.py")


if __name__ == "__main__":
    unittest.main()
