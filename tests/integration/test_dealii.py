#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""structures/dealii: built with the installed package; closed forms, a coupled run beside fem_solver, restart, kill.

Where libdeal.ii-dev is not installed (scripts/setup: tests_of_optional) the exit code is 77.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import launch
import numpy as np
from foreign_wall import ROOT, ForeignWall
from launch import IntegrationCase, Launch, endless, meeting
from test_restart_script import ScriptCase

sys.path[:0] = [str(ROOT / "tests" / "participant")]
from fake_coupler import FakeCoupler, Message  # noqa: E402

FOLDER = ROOT / "structures" / "dealii"
PROGRAM = str(FOLDER / "dealii_structure")
# Parts of a uniform load on the nodes of an edge, by the degree of the element.
PARTS = {1: np.array([1, 1]) / 2, 2: np.array([1, 4, 1]) / 6, 3: np.array([1, 5, 5, 1]) / 12}
WALL = {"dimension": 2, "mesh": {"box": {"low": [0.25, 0], "high": [0.26, 0.05], "cells": [2, 10]}},
        "refine": [{"near": [0.25, 0], "radius": 0.002}],
        "material": {"density": 1100, "young_modulus": 1e6}, "gravity": [0, -9.81], "initial_equilibrium": True,
        "supports": [{"groups": ["bottom"]}], "interfaces": [{"name": "wall", "groups": ["left", "top", "right"]}],
        "probes": [{"name": "A", "point": [0.25, 0.05]}]}


def block(dim: int, **changes) -> dict:
    """A cube or square of 1 m in free flight, finer at a corner of its wet side."""
    return {"dimension": dim, "mesh": {"box": {"low": [0] * dim, "high": [1] * dim, "cells": [2] * dim}},
            "refine": [{"near": [1] * dim, "radius": 0.3}], "material": {"density": 1, "young_modulus": 1e7},
            "interfaces": [{"name": "wall", "groups": ["right"]}],
            "probes": [{"name": "far", "point": [0] * dim}]} | changes


class Driven(IntegrationCase):
    """The program behind a coupler that asks for single steps."""

    def begin(self, settings: dict, mean: bool = False) -> None:
        path = self.folder / "structure.json"
        path.write_text(json.dumps(settings))
        self.coupler = FakeCoupler()
        self.addCleanup(self.coupler.close)
        started = Launch([PROGRAM, "--coupler", self.coupler.endpoint, "--settings", str(path)], self.folder)
        self.addCleanup(started.end)
        self.hello = self.coupler.welcome()
        self.points = self.hello.arrays["coordinates:wall"]
        self.facets = self.hello.arrays["facets:wall"]
        if mean:
            reply = self.coupler.ask("set_force_kinds", kinds={"wall": "step_mean"})
            self.assertEqual(reply.type, "force_kinds_set", reply.fields)
        self.time = 0.0

    def step(self, number: int, dt: float, force: np.ndarray) -> tuple[np.ndarray, Message]:
        """Solved and accepted: displacement of the surface, and the reply to accept."""
        request = {"step": number, "iteration": 0, "time": self.time, "dt": dt}
        solved = self.coupler.ask("solve_step", {"force:wall": force}, **request)
        self.assertEqual(solved.type, "solved", solved.fields)
        accepted = self.coupler.ask("accept_step", **request, solved=True, write_output=False)
        self.time += dt
        return solved.arrays["displacement:wall"], accepted

    def uniform(self, total: float, degree: int) -> np.ndarray:
        """Along x over the side x = 1, whose mesh is uniform: parts of the shape functions."""
        weights = np.ones(len(self.points))
        for axis in range(1, self.points.shape[1]):
            places, inverse = np.unique(np.round(self.points[:, axis], 9), return_inverse=True)
            line = np.zeros(len(places))
            cells = (len(places) - 1) // degree
            for cell in range(cells):
                line[cell * degree:(cell + 1) * degree + 1] += PARTS[degree] / cells
            weights *= line[inverse]
        force = np.zeros_like(self.points)
        force[:, 0] = total * weights
        return force

    def test_stretch(self) -> None:
        """nu = 0: P = mu (s - 1 / s) at any stretch s, across hanging nodes; dt so long that inertia is nothing."""
        stretch, young = 1.5, 1e6
        total = young / 2 * (stretch - 1 / stretch)
        for dim, degree in ((2, 1), (2, 2), (2, 3), (3, 1), (3, 2)):
            with self.subTest(dim=dim, degree=degree):
                self.begin(block(dim, degree=degree, refine=[{"near": [0] * dim, "radius": 0.3}],
                                 supports=[{"groups": ["left"]}], material={"density": 1, "young_modulus": young}))
                u, _ = self.step(1, 1e5, self.uniform(total, degree))
                np.testing.assert_allclose(u[:, 0], stretch - 1, rtol=1e-9)
                np.testing.assert_allclose(u[:, 1:], 0, atol=1e-10)

    def test_mesh_file(self) -> None:
        """A square from a file of Gmsh, whose physical lines 1 to 4 are its sides, stretches uniformly."""
        nodes = [f"{1 + i + 3 * j} {i / 2} {j / 2} 0" for j in range(3) for i in range(3)]
        lines = [(group, a, b) for group, way in ((1, (1, 4, 7)), (2, (3, 6, 9)), (3, (1, 2, 3)), (4, (7, 8, 9)))
                 for a, b in zip(way, way[1:])]
        quads = [(5, n, n + 1, n + 4, n + 3) for n in (1, 2, 4, 5)]
        elements = [f"{k} {1 if len(e) == 3 else 3} 2 {e[0]} {e[0]} {' '.join(map(str, e[1:]))}"
                    for k, e in enumerate(lines + quads, 1)]
        text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "9", *nodes, "$EndNodes", "$Elements",
                str(len(elements)), *elements, "$EndElements", ""]
        (self.folder / "square.msh").write_text("\n".join(text))
        groups = {"supports": [{"groups": ["1"]}], "interfaces": [{"name": "wall", "groups": ["2"]}]}
        self.begin(block(2, mesh={"file": "square.msh"}, refine=[], material={"density": 1, "young_modulus": 1e6})
                   | groups)
        u, _ = self.step(1, 1e5, self.uniform(1e6 / 2 * (1.5 - 1 / 1.5), 2))
        np.testing.assert_allclose(u[:, 0], 0.5, rtol=1e-9)

    def test_surface(self) -> None:
        """Facets cover the sides once, their normals point out, and no place has two vertices, although finer faces
        meet coarser ones there."""
        sides = {2: ["left", "right", "bottom", "top"], 3: ["left", "right", "front", "back", "bottom", "top"]}
        for dim in (2, 3):
            with self.subTest(dim=dim):
                self.begin(block(dim, interfaces=[{"name": "wall", "groups": sides[dim]}]))
                corners = self.points[self.facets]
                if dim == 2:
                    way = corners[:, 1] - corners[:, 0]
                    areas = np.stack([way[:, 1], -way[:, 0]], axis=1)
                else:
                    areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
                np.testing.assert_allclose(areas.sum(axis=0), 0, atol=1e-12)
                self.assertAlmostEqual(np.linalg.norm(areas, axis=1).sum(), 2 * dim, places=12)
                out = np.einsum("ki,ki->k", areas, corners.mean(axis=1) - 0.5)
                self.assertTrue((out > 0).all())
                self.assertEqual(len(np.unique(np.round(self.points, 9), axis=0)), len(self.points))

    def test_impulse(self) -> None:
        """8 N on 1 kg for 0.5 s a step: a mean force gives 4 t^2, whatever alpha; of forces at the end of the step the
        first one begins at zero: u = 0.5, 2.5, 6.5 by the trapezoidal rule."""
        for dim in (2, 3):
            for mean, alpha, way in ((True, 0, [1, 4, 9]), (True, -0.3, [1, 4, 9]), (False, 0, [0.5, 2.5, 6.5])):
                with self.subTest(dim=dim, mean=mean, alpha=alpha):
                    self.begin(block(dim, alpha=alpha), mean)
                    force = np.zeros_like(self.points)
                    force[:, 0] = self.balanced_weights()
                    found = [self.step(k, 0.5, 8 * force)[1].arrays["probes"][0] for k in (1, 2, 3)]
                    np.testing.assert_allclose(found, way, rtol=1e-4)

    def balanced_weights(self) -> np.ndarray:
        """Sum 1 and no moment about the middle of the side, on vertices that are finer at one corner."""
        arms = self.points[:, 1:] - 0.5
        rows = np.vstack([np.ones(len(arms)), arms.T])
        return np.linalg.lstsq(rows, np.eye(len(rows))[0], rcond=None)[0]

    def test_own_weight(self) -> None:
        """q L^4 / (8 E I) + q L^2 / (2 (5 / 6) G A), Timoshenko, from the start."""
        length, height, young, density, g = 1.0, 0.1, 1e7, 1000.0, 0.01
        for refinements in ([], [{"near": [0, 0], "radius": 0.06, "times": 2}]):
            self.begin(block(2, mesh={"box": {"low": [0, 0], "high": [length, height], "cells": [10, 1]}},
                             refine=refinements, material={"density": density, "young_modulus": young},
                             gravity=[0, -g], initial_equilibrium=True, supports=[{"groups": ["left"]}],
                             probes=[{"name": "tip", "point": [length, height / 2]}]))
            q, inertia, area = density * g * height, height**3 / 12, height
            exact = q * length**4 / (8 * young * inertia) + q * length**2 / (2 * (5 / 6) * (young / 2) * area)
            self.assertAlmostEqual(-self.hello.arrays["probes"][1] / exact, 1, delta=2e-3)

    def test_settings(self) -> None:
        for change, *words in (
                ({"degre": 2}, "at /degre", '"degree"'),
                ({"degree": 9}, "at /degree", "found 9"),
                ({"supports": [{"groups": ["underside"]}]}, 'group "underside"', "allowed: left, right, bottom, top"),
                ({"supports": []}, "at /initial_equilibrium", "with supports"),
                ({"refine": [{"near": [9, 9], "radius": 0.1}]}, "at /refine/0/radius", "a larger radius"),
                ({"probes": [{"name": "A", "point": [9, 9]}]}, 'probe "A"', "outside of the mesh"),
                ({"mesh": {"file": "none.msh"}}, "none.msh", "cannot be read"),
                ({"supports": [{"groups": ["bottom"], "components": ["z"]}]}, "at /supports/0/components", "in 2D")):
            with self.subTest(words):
                path = self.folder / "structure.json"
                path.write_text(json.dumps(WALL | change))
                done = subprocess.run([PROGRAM, "--coupler", "tcp://127.0.0.1:9", "--settings", str(path)], text=True,
                                      capture_output=True, check=False, timeout=600)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assert_says(done.stderr, "[dealii] error: ", *words)


class Coupled(ForeignWall):
    def start_structure(self, **changes) -> Launch:
        (self.scene / "structure.json").write_text(json.dumps(WALL | changes))
        return self.launch_structure(PROGRAM, "--settings", str(self.scene / "structure.json"))

    def test_check_participant(self) -> None:
        text = self.pass_the_check(self.start_structure, "--amplitude", "0.5")
        self.assertNotIn("NOTICE", text)

    def run_coupled(self, **changes) -> tuple[float, float]:
        """Run with these settings in place of those of WALL. @returns `result`"""
        self.write_scene(self.files)
        self.couple(lambda: self.start_structure(**changes))
        frames = list((self.out / "structure").glob("frame_*.vtu"))
        self.assertEqual(len(frames), (self.out / "structure" / "frames.pvd").read_text().count(".vtu"))
        self.assertGreater(len(frames), 2)
        found = self.result()
        shutil.rmtree(self.out)
        return found

    def test_goes_the_way_of_the_finite_elements(self) -> None:
        """The result with the cells of fem_solver is its result; with fewer quadratic cells the displacement is the
        same."""
        cells = [4, 40]
        same = WALL["mesh"]["box"] | {"cells": cells}
        linear = self.run_coupled(mesh={"box": same}, degree=1, refine=[])
        quadratic = self.run_coupled()
        expected = self.result_of_finite_elements(cells)
        print(f"A [m], iterations: {linear}, {quadratic}, fem_solver {expected}")
        self.assertAlmostEqual(linear[0] / expected[0], 1, delta=1e-4)
        self.assertAlmostEqual(linear[1], expected[1], delta=1)  # 7 steps; last digits change one
        self.assertAlmostEqual(quadratic[0] / expected[0], 1, delta=0.02)

    def test_killed_in_contact(self) -> None:
        """Named as dead, not as silent."""
        files = endless(in_contact=True)
        files["coupler"]["protocol"] = {"endpoint": self.endpoint, "silence_deadline": 40}
        del files["fem"]
        self.write_scene(files)
        run = self.start(programs=("coupler", "mpm_solver"))
        structure = self.start_structure()
        rows = self.out / "steps.csv"
        run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > 30, "30 steps")
        pid = structure.pid_of("dealii_structur")  # as much of a name as the system keeps
        os.kill(pid, signal.SIGKILL)
        seconds = run.wait_programs_gone()
        print(f"dealii_structure killed: all programs gone after {seconds:.2f} s")
        ended = run.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "[cpl] error: ", 'participant "structure"',
                         f"(dealii_structure, pid {pid}) has died", "last sign of life")


class Restarted(ScriptCase):
    """Restarts by scripts/run, which starts the program."""

    def write_wall(self, **changes) -> None:
        files = meeting()
        del files["fem"]
        files["coupler"]["participants"]["structure"]["command"] = ["dealii_structure"]
        self.write_scene(files | {"structure": WALL | changes})

    def test_restart(self) -> None:
        self.write_wall()
        self.run_script(self.scene, "straight")
        self.run_script(self.scene, "first", "coupler.json:/time/end=0.01")
        self.run_script(self.scene, "second", options=self.restart_of("first"))
        self.assert_same_rows("second", self.steps("first") + 1)
        self.write_wall(material={"density": 1200, "young_modulus": 1e6})
        text = self.run_script(self.scene, "third", options=self.restart_of("first"), code=4)
        self.assert_says(text, "[cpl] error: ", "the saved state is of other settings than structure.json")


if __name__ == "__main__":
    # A package that others only name is known, and shown, without being installed.
    package = subprocess.run(["dpkg-query", "--show", "--showformat", "${db:Status-Status}", "libdeal.ii-dev"],
                             capture_output=True, text=True, check=False)
    if package.stdout != "installed" or Path(sys.argv[1]).resolve() != ROOT / "build" / "release" / "bin":
        print("not run: it needs libdeal.ii-dev, and build/release")
        sys.exit(77)
    subprocess.run([str(FOLDER / "build")], check=True)
    launch.main()
