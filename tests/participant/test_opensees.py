#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""structures/opensees: settings, surfaces, steps against closed forms, trial solutions, restart, what goes wrong.

Exit code 77, not run, where there is no openseespy (scripts/setup: tests_of_wheels).
"""

import math
import os
import shutil
import signal
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
from fake_coupler import ROOT
from opensees_models import AREA, INERTIA, LENGTH, YOUNG, installed, line, write
from opensees_models import cantilever, cantilever_in_tcl, mass, post

sys.path[:0] = [str(ROOT / "structures" / "opensees")]
from gabion_opensees.errors import OpenSeesError, SettingsError  # noqa: E402
from gabion_opensees.settings import read_settings  # noqa: E402
from gabion_opensees.structure import Structure  # noqa: E402
from gabion_participant import STEP_MEAN, ConvergenceError, StepRequest  # noqa: E402

BARE = {"name": "wall", "line": {"nodes": [1, 2], "right": 0}}
CIRCLE = {"name": "wall", "tube": {"nodes": "NODES", "circle": [0.1, 4], "upwards": [1, 0, 0]}}
EXACT = ["NormDispIncr", 1e-13, 50]


class OpenSeesCase(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="gabion_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def structure(self, text: str, interface: dict, suffix: str = ".py", **settings) -> Structure:
        structure = Structure(read_settings(write(self.folder, text, interface, suffix, **settings)))
        self.addCleanup(structure.model.close)
        return structure

    def wait_until(self, holds, what: str) -> None:
        end = time.monotonic() + 60
        while not holds():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.01)


def forces(structure: Structure) -> np.ndarray:
    return np.zeros_like(structure.surfaces[0].surface.offset)


def at(structure: Structure, place: tuple[float, ...]) -> int:
    return int(np.linalg.norm(structure.surfaces[0].surface.coordinates - np.array(place), axis=1).argmin())


class Settings(OpenSeesCase):
    def test_errors_name_place_found_and_allowed(self) -> None:
        good = {"nodes": [1, 2], "right": 0.1}
        for change, *words in (
                ({"step": 1}, "/step: found this key", "integrator"), ({"model": "wall.inp"}, "/model", ".tcl"),
                ({"procedure": "modal"}, "dynamic, static"), ({"arm_tolerance": 2}, "/arm_tolerance: found 2.0"),
                ({"interfaces": []}, "/interfaces"), ({"interfaces": [{"name": "wall"}]}, "/interfaces/0"),
                ({"interfaces": [{"name": "wall", "line": good | {"thick": 1}}]}, "/line/thick", "left"),
                ({"interfaces": [{"name": "wall", "line": {"right": 0.1}}]}, "/line", "nodes"),
                ({"interfaces": [{"name": "wall", "shell": {"above": 0}}]}, "elements or facets|facets or elements"),
                ({"interfaces": [{"name": "wall", "tube": {"nodes": "N", "ends": True}}]}, "upwards"),
                ({"probes": [{"name": "A"}]}, "/probes/0", '"node"')):
            path = write(self.folder, "", BARE, **change)
            for word in words:
                with self.subTest(word), self.assertRaisesRegex(SettingsError, word):
                    read_settings(path)

    def test_errors_of_the_model(self) -> None:
        for interface, more, word in (
                (line(nodes="AXIS"), {}, 'found "AXIS", allowed: a list, or a list of numbers of the model: NODES'),
                (line(nodes=[1, 99]), {}, "node 99"), (line(nodes=[1, 1]), {}, "each once"),
                (line(left=None), {}, "/line/left"),
                ({"name": "wall", "shell": {"elements": [1], "above": 0}}, {}, "-ndm 2"),
                (line(), {"max_unknowns": 7}, "a model of 30 unknowns, allowed: 7"),
                (line(), {"probes": [{"name": "A", "node": 77}]}, "node 77"),
                (line(), {"probes": [{"name": "A", "interface": "wall", "point": [0, 0]}]}, "no vertex at"),
                (line(), {"probes": [{"name": "A", "element": 1, "response": ["colour"]}]}, "colour")):
            with self.subTest(word), self.assertRaisesRegex(SettingsError, word):
                self.structure(cantilever(), interface, **more)
        with self.assertRaisesRegex(SettingsError, "without mass"):
            self.structure(mass().replace("ops.mass", "#"), BARE)
        with self.assertRaisesRegex(OpenSeesError, "model.py: ZeroDivisionError"):
            self.structure("1 / 0", BARE)

    def test_no_openseespy(self) -> None:
        python = self.folder / "python"
        python.write_text('#!/bin/sh\nexec /usr/bin/python3 -S "$@"\n')
        python.chmod(0o755)
        with self.assertRaisesRegex(SettingsError, "-m pip install openseespy"):
            self.structure(mass(), BARE, python=str(python))
        with self.assertRaisesRegex(SettingsError, "/python: found"):
            self.structure(mass(), BARE, python=str(self.folder / "none"))


class ClosedForms(OpenSeesCase):
    def test_a_free_mass_under_mean_forces(self) -> None:
        """Constant load over each step: exact, whatever the sizes of loads and steps."""
        structure = self.structure(mass(), BARE, test=EXACT)
        structure.set_force_kinds({"wall": STEP_MEAN})
        u, v = np.zeros(2), np.zeros(2)
        for number, (dt, *force) in enumerate([(0.1, 3, 1), (0.1, -1, 0), (0.05, 5, 2), (0.2, 0, 0), (0.1, 1, 1)], 1):
            f = forces(structure)
            f[1] = force
            values, _ = structure.solve_step(StepRequest(number, 0, 0, dt), {"wall": f})
            structure.accept_step(StepRequest(number, 0, 0, dt), True)
            u, v = u + dt * v + dt**2 / 2 * f[1] / 2, v + dt * f[1] / 2
            np.testing.assert_allclose(values["wall"][1], u, atol=1e-12)

    def test_a_free_mass_under_forces_at_the_end_of_a_step(self) -> None:
        """The mean of the old and the new one acts."""
        structure = self.structure(mass(), BARE, test=EXACT)
        f = forces(structure)
        f[1, 0] = 4
        for number, expected in ((1, 0.5), (2, 0.5 + 1 + 1)):
            values, _ = structure.solve_step(StepRequest(number, 0, 0, 1.0), {"wall": f})
            structure.accept_step(StepRequest(number, 0, 0, 1.0), True)
            self.assertAlmostEqual(values["wall"][1, 0], expected, delta=1e-11)

    def test_a_cantilever_under_a_force_at_its_tip(self) -> None:
        structure = self.structure(cantilever(), line(), procedure="static", test=EXACT)
        f = forces(structure)
        f[at(structure, (0.255, LENGTH)), 0] = 1e-4
        values, _ = structure.solve_step(StepRequest(1, 0, 0, 1), {"wall": f})
        tip = values["wall"][at(structure, (0.255, LENGTH)), 0]
        self.assertAlmostEqual(tip / (1e-4 * LENGTH**3 / (3 * YOUNG * INERTIA)), 1, delta=1e-6)

    def test_a_dead_couple_bends_to_an_arc(self) -> None:
        """E I angle / length = F thickness cos(angle): the arms of the forces turn. Large rotation."""
        structure = self.structure(cantilever(20), line(), procedure="static",
                                   test=["NormDispIncr", 1e-11, 50], arm_tolerance=1e-9)
        f = forces(structure)
        couple = 0.6 * YOUNG * INERTIA / LENGTH
        f[at(structure, (0.25, LENGTH)), 1], f[at(structure, (0.26, LENGTH)), 1] = -couple / 0.01, couple / 0.01
        for step in range(1, 11):
            values, _ = structure.solve_step(StepRequest(step, 0, 0, 1), {"wall": 0.1 * step * f})
            structure.accept_step(StepRequest(step, 0, 0, 1), True)
        angle = 0.7
        for _ in range(60):
            angle -= (angle - 0.6 * math.cos(angle)) / (1 + 0.6 * math.sin(angle))
        found = structure.motions[0].angles[-1]
        self.assertAlmostEqual(found, angle, delta=1e-7)
        middle = values["wall"][at(structure, (0.255, LENGTH))] + [0, LENGTH]
        expected = LENGTH / angle * np.array([-(1 - math.cos(angle)), math.sin(angle)])
        np.testing.assert_allclose(middle, expected, rtol=3e-4)

    def test_a_dead_couple_twists_a_post(self) -> None:
        """G J angle / length = couple cos(angle) on a tube in space; a corner turns with its section."""
        structure = self.structure(post(), CIRCLE, procedure="static", test=EXACT, arm_tolerance=1e-12)
        surface = structure.surfaces[0].surface
        top = np.flatnonzero(surface.carrier == 8)
        f = forces(structure)
        radius = np.linalg.norm(surface.offset[0])
        f[top[0], 1], f[top[2], 1] = 50 / (2 * radius), -50 / (2 * radius)
        np.testing.assert_allclose(surface.offset[top[0]], [radius, 0, 0], atol=1e-15)
        values, _ = structure.solve_step(StepRequest(1, 0, 0, 1), {"wall": f})
        angle = 0.45
        for _ in range(60):
            angle -= (angle - 0.5 * math.cos(angle)) / (1 + 0.5 * math.sin(angle))
        np.testing.assert_allclose(values["wall"][top[0]],
                                   radius * np.array([math.cos(angle) - 1, math.sin(angle), 0]), atol=1e-8)

    def test_the_period_of_a_cantilever(self) -> None:
        """Bending against the beam's first mode, and what the trapezoidal rule adds: (omega dt)^2 / 12."""
        structure = self.structure(cantilever(20), line())
        structure.set_force_kinds({"wall": STEP_MEAN})
        omega = 1.875104**2 * math.sqrt(YOUNG * INERTIA / (1100 * AREA * LENGTH**4))
        dt, tip = 2 * math.pi / omega / 40, at(structure, (0.255, LENGTH))
        f = forces(structure)
        f[tip, 0] = 1e-3
        way = [0.0]
        for step in range(1, 62):
            values, _ = structure.solve_step(StepRequest(step, 0, 0, dt), {"wall": f if step <= 20 else 0 * f})
            structure.accept_step(StepRequest(step, 0, 0, dt), True)
            way.append(float(values["wall"][tip, 0]))
        zeros = [n - way[n] / (way[n] - way[n - 1]) for n in range(22, 62) if way[n - 1] * way[n] < 0]
        self.assertAlmostEqual(2 * (zeros[1] - zeros[0]) / 40 / (1 + (2 * math.pi / 40)**2 / 12), 1, delta=0.01)

    def test_tcl_and_python_give_the_same(self) -> None:
        answers = []
        for text, suffix in ((cantilever(), ".py"), (cantilever_in_tcl(), ".tcl")):
            structure = self.structure(text, line(), suffix)
            f = forces(structure) + 0.1
            answers.append(structure.solve_step(StepRequest(1, 0, 0, 1e-3), {"wall": f})[0]["wall"])
        np.testing.assert_array_equal(*answers)
        for text, word in (("wipe\nnonsense 1", "exit code 1"), ("error stop", "exit code 1")):
            with self.assertRaisesRegex(OpenSeesError, word):
                self.structure(text, line(), ".tcl")


class Trials(OpenSeesCase):
    def test_repeat_reject_cut_and_restart_with_history(self) -> None:
        """Fibres that yield: the same bits from the same accepted state, in another process too."""
        settings = {"probes": [{"name": "A", "interface": "wall", "point": [0.25, 0.05]},
                               {"name": "foot", "element": 1, "response": ["section", 1, "force"]}]}
        text = cantilever(fibres=True)
        structure = self.structure(text, line(), **settings)
        structure.set_force_kinds({"wall": STEP_MEAN})
        random = np.random.default_rng(1)
        none = forces(structure)
        load = [{"wall": none + [0.3, 0] + 0.1 * random.standard_normal(none.shape)} for _ in range(3)]
        for number in range(1, 30):
            request = StepRequest(number, 0, 0, 1e-3)
            answer = structure.solve_step(request, load[number % 3])[0]["wall"]
            structure.solve_step(StepRequest(number, 1, 0, 5e-4), load[(number + 1) % 3])
            structure.reject_step()
            np.testing.assert_array_equal(structure.solve_step(request, load[number % 3])[0]["wall"], answer)
            structure.accept_step(request, True)
        self.assertGreater(np.abs(answer).max(), 2e-3)  # more than it yields at
        saved, request = structure.save_state(), StepRequest(30, 0, 0, 1e-3)
        answer = structure.solve_step(request, load[0])[0]["wall"]
        other = self.structure(text, line(), **settings)
        other.set_force_kinds({"wall": STEP_MEAN})
        other.load_state(saved)
        self.assertEqual(other.probes(), structure.probes())
        np.testing.assert_array_equal(other.solve_step(request, load[0])[0]["wall"], answer)
        with self.assertRaisesRegex(ValueError, "another model"):
            self.structure(text, line(), integrator=["HHT", 0.9]).load_state(saved)

    def test_rotations_in_space_are_saved(self) -> None:
        structure = self.structure(post().replace("1e-5, 1)", '1e-5, 1, "-mass", 10.0, "-cMass")'), CIRCLE)
        f = forces(structure) + np.random.default_rng(2).standard_normal(forces(structure).shape) * 30
        for number in (1, 2, 3):
            structure.solve_step(StepRequest(number, 0, 0, 1e-2), {"wall": f})
            structure.accept_step(StepRequest(number, 0, 0, 1e-2), True)
        saved = structure.save_state()
        answer = structure.solve_step(StepRequest(4, 0, 0, 1e-2), {"wall": -f})[0]["wall"]
        structure.accept_step(StepRequest(4, 0, 0, 1e-2), True)
        structure.load_state(saved)
        np.testing.assert_array_equal(structure.solve_step(StepRequest(4, 0, 0, 1e-2), {"wall": -f})[0]["wall"], answer)

    def test_no_solution_is_for_the_coupler(self) -> None:
        structure = self.structure(cantilever(), line(), procedure="static", test=["NormDispIncr", 1e-9, 4])
        with self.assertRaisesRegex(ConvergenceError, "OpenSees: "):
            structure.solve_step(StepRequest(1, 0, 0, 1), {"wall": forces(structure) + [5, -5]})
        structure.reject_step()
        structure.solve_step(StepRequest(1, 0, 0, 1), {"wall": forces(structure) + [1e-3, 0]})

    def test_output_is_of_the_accepted_state(self) -> None:
        structure = self.structure(cantilever(2), line())
        structure.frames = self.folder
        structure.solve_step(StepRequest(1, 0, 0, 1e-3), {"wall": forces(structure) + 1})
        structure.write_output(0.5)
        rows = (self.folder / "nodes.csv").read_text().split()
        self.assertEqual(rows[0], "time,node,x,y,ux,uy")
        self.assertEqual(rows[3], "0.5,3,0.255,0.05,0.0,0.0")

    def test_no_process_is_left(self) -> None:
        structure = self.structure(cantilever(2), line())
        for number in range(1, 6):
            structure.solve_step(StepRequest(number, 0, 0, 1e-3), {})
            structure.accept_step(StepRequest(number, 0, 0, 1e-3), True)
        structure.solve_step(StepRequest(9, 0, 0, 1e-3), {})
        self.assertEqual(len(self.alive()), 2)  # the accepted state and a trial
        structure.model.close()
        self.wait_until(lambda: not self.alive(), "a process of the model is left")

    def alive(self) -> list[int]:
        """Processes of this test's models that run."""
        found = []
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and str(self.folder) in (entry / "cmdline").read_text():
                    found.append(int(entry.name))
            except OSError:
                pass
        return found

    def test_a_killed_model_is_named(self) -> None:
        structure = self.structure(cantilever(2), line())
        structure.solve_step(StepRequest(1, 0, 0, 1e-3), {})
        os.kill(max(self.alive()), signal.SIGKILL)  # the trial
        with self.assertRaisesRegex(OpenSeesError, "model.py: the process of a trial solution was ended by SIGKILL"):
            structure.accept_step(StepRequest(1, 0, 0, 1e-3), True)
        self.wait_until(lambda: not self.alive(), "the accepted state is left")
        structure.model.reap()
        structure = self.structure(cantilever(2), line())
        os.kill(self.alive()[0], signal.SIGKILL)
        with self.assertRaisesRegex(OpenSeesError, "model.py: the process of the model was ended by SIGKILL"):
            structure.solve_step(StepRequest(1, 0, 0, 1e-3), {})


if __name__ == "__main__":
    if not installed():
        print("no openseespy: not run")
        sys.exit(77)
    unittest.main()
