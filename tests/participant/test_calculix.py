#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""structures/calculix: the deck and its errors, the surface, steps of ccx against closed forms, what goes wrong."""

import csv
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
from calculix_decks import AREA, DENSITY, HEIGHT, INERTIA, LENGTH, MATERIAL, SECTIONS, WIDTH, YOUNG
from calculix_decks import beam, plane, shell, solid, two_bars, write
from fake_coupler import ROOT

sys.path[:0] = [str(ROOT / "structures" / "calculix")]
from gabion_calculix.ccx import CcxError  # noqa: E402
from gabion_calculix.deck import DeckError, read_deck  # noqa: E402
from gabion_calculix.job import number_text  # noqa: E402
from gabion_calculix.restart_file import RestartFileError, read_header, read_nodal_state, records  # noqa: E402
from gabion_calculix.settings import read_settings  # noqa: E402
from gabion_calculix.structure import Structure  # noqa: E402
from gabion_calculix.wet_surface import make_wet_surface  # noqa: E402
from gabion_participant import END_OF_STEP, STEP_MEAN, ConvergenceError, StepRequest  # noqa: E402

SMALL_WEIGHT = "*STEP\n*STATIC\n*DLOAD\nALL, GRAV, 0.1, 0, -1, 0\n*END STEP\n"
KINDS = {"C3D20": solid(), "S8R": shell(), "S4": shell("S4"), "B32": beam(), "B31": beam("B31"), "CPE8R": plane()}
# A cube and a square of 1 kg in free flight, wet on the top.
CUBE = ("*NODE\n1, 0, 0, 0\n2, .1, 0, 0\n3, .1, .1, 0\n4, 0, .1, 0\n"
        "5, 0, 0, .1\n6, .1, 0, .1\n7, .1, .1, .1\n8, 0, .1, .1\n"
        "*ELEMENT, TYPE=C3D8, ELSET=ALL\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*NSET, NSET=FOOT\n1, 2, 3, 4\n"
        f"*SURFACE, NAME=WET\nALL, S2\n{MATERIAL}{SECTIONS['C3D']}")
SQUARE = ("*NODE\n1, 0, 0\n2, .1, 0\n3, .1, .1\n4, 0, .1\n5, .05, 0\n6, .1, .05\n7, .05, .1\n8, 0, .05\n"
          "*ELEMENT, TYPE=CPE8, ELSET=ALL\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SURFACE, NAME=WET\nALL, S3\n"
          f"{MATERIAL}{SECTIONS['CPE']}")
WEIGHT = "*STEP, NLGEOM\n*STATIC\n*DLOAD\nALL, GRAV, 0.1, 0, -1, 0\n*END STEP\n"


class CalculixCase(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="gabion_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def structure(self, text: str, **settings) -> Structure:
        scratch = Path(tempfile.mkdtemp(dir=self.folder))
        return Structure(read_settings(write(self.folder, text, **settings)), scratch)

    def settings_text(self, text: str) -> Path:
        path = self.folder / "structure.json"
        path.write_text(text, encoding="utf-8")
        return path

    def read(self, text: str):
        path = self.folder / "deck.inp"
        path.write_text(text, encoding="utf-8")
        return read_deck(path)


def uniform(structure: Structure, total: tuple[float, ...]) -> dict[str, np.ndarray]:
    """The force [N] in equal parts on all wet nodes; 2D: per metre."""
    shape = structure.surfaces[0].coordinates.shape
    return {"wall": np.full(shape, np.array(total[:shape[1]]) / shape[0])}


def at_tip(structure: Structure, force: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Along y [N], and the nodes there."""
    surface = structure.surfaces[0]
    tip = np.flatnonzero(np.isclose(surface.coordinates[:, 0], LENGTH))
    values = np.zeros_like(surface.coordinates)
    values[tip, 1] = force / len(tip) / surface.thickness
    return {"wall": values}, tip


class Decks(CalculixCase):
    def test_include_sets_and_continued_lines(self) -> None:
        (self.folder / "mesh.inc").write_text(solid(2).split("*NSET, NSET=FOOT")[0])
        deck = self.read("** a comment\n*include, input=mesh.inc\n*Nset, nset = even, generate\n2, 10, 2\n"
                         "*NSET, NSET=BOTH\neven, 1\n*ELSET, ELSET=TWICE\nALL, 2\n")
        self.assertEqual(deck.node_sets["BOTH"], [2, 4, 6, 8, 10, 1])
        self.assertEqual(deck.element_sets["TWICE"], [1, 2, 2])
        self.assertEqual([len(element.nodes) for element in deck.elements.values()], [20, 20])

    def test_errors_name_place_found_and_allowed(self) -> None:
        nodes = "*NODE\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n"
        for text, *words in (
                ("*NODE\n1, 0, zero\n", "deck.inp:2", '"ZERO"', "a number"),
                (nodes + "*ELEMENT, TYPE=CPE5\n1, 1, 2, 3\n", "deck.inp:6", "TYPE=CPE5", "CPE4"),
                (nodes + "*ELEMENT\n1, 1\n", "deck.inp:6", "without TYPE="),
                (nodes + "*ELEMENT, TYPE=CPE4\n1, 1, 2, 3\n", "deck.inp:7", "found 3 nodes, allowed: 4 of CPE4"),
                (nodes + "*ELEMENT, TYPE=CPE4\n1, 1, 2, 3, 7\n", "deck.inp:7", "node 7"),
                (nodes + "*NSET, NSET=A\nB\n", "deck.inp:7", 'node set "B"'),
                (nodes + "*NSET, NSET=A, GENERATE\n1, 4, -1\n", "deck.inp:7", "STEP > 0"),
                ("*INCLUDE, INPUT=none.inc\n", "none.inc", "No such file"),
                ("1, 2\n", "deck.inp:1", "a keyword"),
                (nodes, "no *ELEMENT")):
            with self.subTest(words):
                with self.assertRaises(DeckError) as caught:
                    self.read(text)
                for word in words:
                    self.assertIn(word, str(caught.exception))

    def test_what_a_coupled_run_cannot_keep(self) -> None:
        for change, *words in (
                (("*STATIC", "*FREQUENCY"), "*FREQUENCY", "*STATIC, *DYNAMIC"),
                (("NLGEOM", "PERTURBATION"), "PERTURBATION"),
                (("*DLOAD", "*CLOAD\n7, 2, 1.\n*DLOAD"), "*CLOAD at node 7 of a wet surface", "not wet"),
                (("*MATERIAL", "*TRANSFORM, NSET=FOOT\n1, 0, 0, 0, 1, 0\n*MATERIAL"), "*TRANSFORM at node"),
                (("*MATERIAL", "*AMPLITUDE, NAME=A\n0, 0, 1, 1\n*MATERIAL"), "*AMPLITUDE", "TIME=TOTAL TIME"),
                (("*STEP", "*RESTART, READ\n*STEP"), "*RESTART, READ"),
                (("*STEP, NLGEOM", "*STEP"), '"*STEP" with "nlgeom": true', "or neither"),
                (("*END STEP", ""), "found 1 *STEP and 0 *END STEP"),
                (("NAME=WET", "NAME=DRY"), "no *SURFACE, NAME=WET, allowed: DRY"),
                (("*MATERIAL", "*ELEMENT, TYPE=CPE4\n99, 1, 2, 3, 4\n*MATERIAL"), "TYPE=CPE4", "half of its mass",
                 "CPE8"),
                (("*MATERIAL", "*KINEMATIC\n1, 3\n*MATERIAL"), "*KINEMATIC", "*RIGID BODY"),
                (("ALL, SPOS", "ALL, S3"), "face S3 of a shell", "SPOS, SNEG")):
            with self.subTest(words):
                with self.assertRaises(DeckError) as caught:
                    self.structure((shell("S4") + WEIGHT).replace(*change))
                for word in words:
                    self.assertIn(word, str(caught.exception))

    def test_settings(self) -> None:
        start = '{"deck": "deck.inp", "interfaces": [{"name": "wall", "surface": "WET"}]'
        for text, *words in (
                ("{", "structure.json"), ('{"deck": "a"}', "/interfaces: found nothing"),
                (start + ', "step": 1}', "/step: found this key", "threads"),
                (start + ', "alpha": -0.5}', "/alpha: found -0.5, allowed: -1/3 to 0"),
                (start + ', "threads": 1.5}', "/threads", ">= 1"),
                (start + ', "procedure": "modal"}', "dynamic, static"),
                (start + ', "probes": [{"name": "A"}]}', "/probes/0", '"node"'),
                ('{"deck": "a", "interfaces": [{"name": "wall"}]}', "/interfaces/0", "element_set")):
            with self.subTest(text):
                with self.assertRaises(DeckError) as caught:
                    read_settings(self.settings_text(text))
                for word in words:
                    self.assertIn(word, str(caught.exception))

    def test_numbers_fit_what_ccx_reads(self) -> None:
        for value in (-1.2345678901234567e-5, 1 / 3, 1e-300, -9.9999999999999999e97):
            self.assertLessEqual(len(number_text(value)), 20)
            self.assertAlmostEqual(float(number_text(value)), value, delta=1e-13 * abs(value) + 1e-90)


class Surfaces(CalculixCase):
    def test_normals_point_out(self) -> None:
        """The boundary of a cube: closed, and its divergence is the volume."""
        deck = self.read(CUBE)
        surface = make_wet_surface(deck, "wall", "", "ALL")
        corners = surface.coordinates[surface.facets]
        normals = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-15)
        self.assertAlmostEqual(np.sum(normals * corners.mean(axis=1)) / 3, 1e-3, delta=1e-15)

    def test_faces_of_every_solid(self) -> None:
        """The faces of one element of each shape, away from the origin, give its volume (divergence theorem) and all
        its nodes."""
        shapes = {"C3D4": 1 / 6, "C3D10": 1 / 6, "C3D6": 1 / 2, "C3D15": 1 / 2, "C3D8": 1.0, "C3D20": 1.0}
        corners = {4: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
                   6: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
                   8: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]}
        ways = {10: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
                15: [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
                20: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]}
        for kind, volume in shapes.items():
            count = int(kind[3:])
            points = [np.array(p, float) for p in corners[{10: 4, 15: 6, 20: 8}.get(count, count)]]
            points += [(points[a] + points[b]) / 2 for a, b in ways.get(count, [])]
            rows = "".join(f"{k}, {p[0] + 3}, {p[1] - 2}, {p[2] + 1}\n" for k, p in enumerate(points, 1))
            numbers = [str(k) for k in range(count + 1)]
            numbers[0] = "1"
            element = ", ".join(numbers[:12]) + (",\n" + ", ".join(numbers[12:]) if count > 11 else "")
            with self.subTest(kind):
                deck = self.read(f"*NODE\n{rows}*ELEMENT, TYPE={kind}, ELSET=E\n{element}\n")
                surface = make_wet_surface(deck, "w", "", "E")
                self.assertEqual(len(surface.nodes), count)
                fan = [(f[0], f[k], f[k + 1]) for f in surface.facets for k in range(1, len(f) - 1)]
                parts = surface.coordinates[np.array(fan)]
                self.assertAlmostEqual(np.linalg.det(parts).sum() / 6, volume, delta=1e-14)

    def test_plane_edges_go_round_with_the_soil_on_the_right(self) -> None:
        surface = make_wet_surface(self.read(plane(n=2)), "wall", "", "ALL")
        way = surface.coordinates[surface.facets]
        area = 0.5 * np.sum(way[:, 0, 0] * way[:, 1, 1] - way[:, 1, 0] * way[:, 0, 1])
        self.assertAlmostEqual(area, LENGTH * HEIGHT, delta=1e-15)
        self.assertEqual((surface.dimension, surface.thickness), (2, WIDTH))

    def test_sides_of_shells(self) -> None:
        for side, sign in (("SPOS", -1), ("SNEG", 1)):
            surface = make_wet_surface(self.read(shell("S4").replace("SPOS", side)), "wall", "WET", "")
            a, b, c, _ = surface.coordinates[surface.facets[0]]
            self.assertEqual(np.sign(np.cross(b - a, c - a)[1]), sign)


class Statics(CalculixCase):
    def test_tip_of_a_cantilever(self) -> None:
        """P L^3 / (3 EI) (1 + 0.6 (h / L)^2), Timoshenko, of every kind of element; from its own weight on too."""
        force = 1e-3
        exact = force * LENGTH**3 / (3 * YOUNG * INERTIA) * (1 + 0.6 * (HEIGHT / LENGTH)**2)
        for kind, text in KINDS.items():
            with self.subTest(kind):
                weight = SMALL_WEIGHT if kind in ("S8R", "CPE8R") else ""
                structure = self.structure(text + weight, procedure="static", nlgeom=False)
                forces, tip = at_tip(structure, force)
                values, _ = structure.solve_step(StepRequest(1, 0, 0, 1), forces)
                start = structure.accepted.displacement[structure.surfaces[0].nodes[tip] - 1, 1]
                ratio = (values["wall"][tip, 1] - start) / exact
                np.testing.assert_allclose(ratio, 1, atol=5e-3)

    def test_plastic_strain_stays(self) -> None:
        """A bar loaded and let go, over restarts: sigma / E + (sigma - yield) / H, then the second part."""
        bar = CUBE.split("*MATERIAL")[0] + (
            "*MATERIAL, NAME=M\n*ELASTIC\n1e7, 0.3\n*PLASTIC\n1e4, 0\n2e4, 0.1\n*DENSITY\n1000\n" + SECTIONS["C3D"]
            + "*BOUNDARY\nFOOT, 3\n1, 1, 2\n2, 2\n4, 1\n")
        structure = self.structure(bar, procedure="static", nlgeom=False)
        heights = []
        for step, pressure in enumerate((1.6e4, 1.6e4, 0.0, 0.0, 1.6e4), 1):
            values, _ = structure.solve_step(StepRequest(step, 0, 0, 1), uniform(structure, (0, 0, -pressure * 0.01)))
            structure.accept_step(StepRequest(step, 0, 0, 1), True)
            heights.append(values["wall"][:, 2].mean())
        np.testing.assert_allclose(heights, -0.1 * np.array([0.0616, 0.0616, 0.06, 0.06, 0.0616]), rtol=1e-6)

    def test_a_gap_between_two_bodies_closes_and_opens(self) -> None:
        """Bars of stiffness k, contact of stiffness c: u = P / k while it is open, then (P + s g) / (k + s), s of bar
        and contact in series; over restarts."""
        gap, contact, area, side = 1e-4, 1e10, 0.01, 0.1
        k = YOUNG * area / side
        s = 1 / (1 / k + 1 / (contact * area))
        structure = self.structure(two_bars(gap, contact), procedure="static", nlgeom=False)
        for step, force in enumerate((50.0, 90.0, 150.0, 400.0, 150.0, 40.0, 0.0, 200.0), 1):
            values, _ = structure.solve_step(StepRequest(step, 0, 0, 1), uniform(structure, (force, 0, 0)))
            structure.accept_step(StepRequest(step, 0, 0, 1), True)
            exact = force / k if force < k * gap else (force + s * gap) / (k + s)
            np.testing.assert_allclose(values["wall"][:, 0], exact, rtol=1e-5, atol=1e-12, err_msg=f"{force} N")

    def test_own_weight(self) -> None:
        structure = self.structure(plane("CPE8") + SMALL_WEIGHT, nlgeom=False, probes=[{"name": "A", "node": 63}])
        weight = DENSITY * AREA * 0.1
        self.assertEqual(structure.probe_names(), ["A.ux", "A.uy"])
        self.assertAlmostEqual(structure.probes()[1] / (-weight * LENGTH**4 / (8 * YOUNG * INERTIA)), 1, delta=5e-3)

    def test_displacements_in_double_precision(self) -> None:
        """A linear deck doubles its answer to round-off, where .dat has 7 digits."""
        structure = self.structure(KINDS["S4"], procedure="static", nlgeom=False)
        once, _ = structure.solve_step(StepRequest(1, 0, 0, 1), uniform(structure, (0, 1e-3, 0)))
        twice, _ = structure.solve_step(StepRequest(1, 0, 0, 1), uniform(structure, (0, 2e-3, 0)))
        largest = np.abs(twice["wall"]).max()
        np.testing.assert_allclose(twice["wall"], 2 * once["wall"], rtol=0, atol=1e-11 * largest)


class Dynamics(CalculixCase):
    def fly(self, kind: str, steps: int, text: str = CUBE, **settings) -> list[float]:
        structure = self.structure(text, nlgeom=False, **settings)
        up = structure.dimension - 1
        force = np.eye(3)[up] * 8.0 / structure.surfaces[0].thickness
        structure.set_force_kinds({"wall": kind})
        heights = []
        for step in range(1, steps + 1):
            request = StepRequest(step, 0, (step - 1) * 0.5, 0.5)
            values, _ = structure.solve_step(request, uniform(structure, tuple(force)))
            structure.accept_step(request, True)
            heights.append(float(values["wall"][:, up].mean()))
        return heights

    def test_impulse_of_a_mean_force(self) -> None:
        """8 N on 1 kg: 4 t^2, whatever alpha; of forces at the end of the step the first one begins at zero: by
        the trapezoidal rule v1 = 2, u1 = 0.5, then v grows by 4 a step of 0.5 s. Means over the top, where the
        force acts."""
        np.testing.assert_allclose(self.fly(STEP_MEAN, 3), [1.0, 4.0, 9.0], rtol=1e-5)
        np.testing.assert_allclose(self.fly(STEP_MEAN, 3, SQUARE), [1.0, 4.0, 9.0], rtol=1e-5)
        np.testing.assert_allclose(self.fly(STEP_MEAN, 2, alpha=-0.2), [1.0, 4.0], rtol=1e-5)
        np.testing.assert_allclose(self.fly(END_OF_STEP, 3), [0.5, 2.5, 6.5], rtol=1e-5)

    def test_period_of_a_cantilever(self) -> None:
        """1.8751^2 sqrt(EI / (rho A L^4)), and what the trapezoidal rule adds to the period: (omega dt)^2 / 12."""
        omega = 1.875104**2 * math.sqrt(YOUNG * INERTIA / (DENSITY * AREA * LENGTH**4))
        dt = 2 * math.pi / omega / 30
        for kind in ("S4", "B32"):
            with self.subTest(kind):
                structure = self.structure(KINDS[kind], nlgeom=False)
                structure.set_force_kinds({"wall": STEP_MEAN})
                forces, tip = at_tip(structure, 1e-2)
                way, none = [0.0], {"wall": np.zeros_like(forces["wall"])}
                for step in range(1, 41):
                    request = StepRequest(step, 0, (step - 1) * dt, dt)
                    values, _ = structure.solve_step(request, forces if step <= 15 else none)
                    structure.accept_step(request, True)
                    way.append(float(values["wall"][tip[0], 1]))
                down = [n - way[n] / (way[n] - way[n - 1]) for n in range(17, 41) if way[n - 1] * way[n] < 0]
                self.assertEqual(len(down), 2)
                period = 2 * (down[1] - down[0]) / 30 / (1 + (2 * math.pi / 30)**2 / 12)
                self.assertAlmostEqual(period, 1, delta=0.015)

    def test_repeat_reject_cut_and_restart(self) -> None:
        """Equal accepted states give equal bits, in another process's folder too."""
        settings = {"probes": [{"name": "A", "node": 63}]}
        structure = self.structure(plane(n=10) + WEIGHT, **settings)
        random = np.random.default_rng(1)
        forces = [{"wall": 1e-2 * random.standard_normal(structure.surfaces[0].coordinates.shape)} for _ in range(3)]
        first = StepRequest(1, 0, 0, 1e-2)
        answer = structure.solve_step(first, forces[0])[0]["wall"]
        structure.solve_step(StepRequest(1, 1, 0, 5e-3), forces[1])
        structure.reject_step()
        np.testing.assert_array_equal(structure.solve_step(first, forces[0])[0]["wall"], answer)
        structure.accept_step(first, True)
        saved = structure.save_state()
        second = StepRequest(2, 0, 1e-2, 1e-2)
        answer = structure.solve_step(second, forces[2])[0]["wall"]
        other = self.structure(plane(n=10) + WEIGHT, **settings)
        other.load_state(saved)
        self.assertEqual(other.probes(), structure.probes())
        np.testing.assert_array_equal(other.solve_step(second, forces[2])[0]["wall"], answer)
        with self.assertRaisesRegex(ValueError, "another deck"):
            self.structure(plane(n=10) + WEIGHT, alpha=-0.1).load_state(saved)

    def test_a_restart_does_not_grow(self) -> None:
        """ccx adds to its reserve for multi-point constraints at each restart."""
        structure = self.structure(plane(n=2) + WEIGHT)
        reserves = []
        for step in range(1, 4):
            structure.solve_step(StepRequest(step, 0, 0, 1e-3), {})
            structure.accept_step(StepRequest(step, 0, 0, 1e-3), True)
            reserves.append(read_header(records(structure.state_file.read_bytes()))["memmpc"])
        self.assertEqual(len(set(reserves)), 1)

    def test_output_of_the_accepted_step(self) -> None:
        structure = self.structure(plane(n=2) + WEIGHT)
        structure.frames = self.folder
        structure.write_output(0.0)  # nothing is solved yet
        structure.solve_step(StepRequest(1, 0, 0, 1e-3), {})
        structure.accept_step(StepRequest(1, 0, 0, 1e-3), True)
        answer = structure.solve_step(StepRequest(2, 0, 1e-3, 1e-3), {})[0]["wall"]
        structure.write_output(1e-3)
        np.testing.assert_array_equal(structure.solve_step(StepRequest(2, 0, 1e-3, 1e-3), {})[0]["wall"], answer)
        self.assertEqual((self.folder / "frames.csv").read_text().split(), ["time,file", "0.001,frame_000001.frd"])
        self.assertIn("DISP", (self.folder / "frame_000001.frd").read_text())

    def test_section_forces_of_a_cantilever(self) -> None:
        """Shear P, moment P (L - x) at the nodes between the elements; of ten elements to 0.1 %."""
        force, count = 1e-3, 10
        structure = self.structure(beam("B31", count), procedure="static", nlgeom=False, section_forces=True)
        structure.frames = self.folder
        forces, _ = at_tip(structure, force)
        structure.solve_step(StepRequest(1, 0, 0, 1), forces)
        structure.accept_step(StepRequest(1, 0, 0, 1), True)
        structure.write_output(1.0)
        with (self.folder / "section_forces.csv").open(newline="") as table:
            rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(table)]
        self.assertEqual([row["node"] for row in rows], list(range(1, count + 2)))
        for row in rows[1:-1]:
            arm = LENGTH * (1 - (row["node"] - 1) / count)
            np.testing.assert_allclose([abs(row["shear_2"]), abs(row["moment_1"])], [force, force * arm], rtol=1e-3)
            np.testing.assert_allclose([row[name] for name in ("shear_1", "normal", "torque", "moment_2")], 0,
                                       atol=1e-8 * force)

    def test_section_forces_need_beams(self) -> None:
        with self.assertRaisesRegex(DeckError, 'no beams for "section_forces": true'):
            self.structure(plane(n=2), section_forces=True)
        shared = beam("B31", 2) + "*NODE\n90, 0, 0, 1\n91, 1, 0, 1\n*ELEMENT, TYPE=S3\n90, 1, 90, 91\n"
        with self.assertRaisesRegex(DeckError, "node 1 of beams and of others"):
            self.structure(shared, section_forces=True)
        with self.assertRaisesRegex(DeckError, "no node set HANDS for reactions, allowed: FOOT"):
            self.structure(plane(n=2), reactions=["hands"])

    def test_reactions_of_a_cantilever(self) -> None:
        """The supports take the load, from restarts too; 2D: of the whole thickness. Loads at the supports themselves
        are not in what ccx gives: the force is at the tip."""
        for kind in ("B31", "S4", "CPE8R", "C3D20"):
            with self.subTest(kind):
                structure = self.structure(KINDS[kind], procedure="static", nlgeom=False, reactions=["Foot"])
                structure.frames = Path(tempfile.mkdtemp(dir=self.folder))
                forces, _ = at_tip(structure, 1e-3)
                for step in (1, 2):
                    structure.solve_step(StepRequest(step, 0, 0, 1), forces)
                    structure.accept_step(StepRequest(step, 0, 0, 1), True)
                    structure.write_output(float(step))
                with (structure.frames / "reactions.csv").open(newline="") as table:
                    rows = list(csv.DictReader(table))
                self.assertEqual({row["time"] for row in rows}, {"1.0", "2.0"})
                sums = [sum(float(row["fy"]) for row in rows if row["time"] == time) for time in ("1.0", "2.0")]
                np.testing.assert_allclose(sums, -1e-3, rtol=1e-5)


class Problems(CalculixCase):
    def program(self, text: str) -> str:
        path = self.folder / "my_ccx"
        path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
        path.chmod(0o755)
        return str(path)

    def test_no_solution_is_for_the_coupler(self) -> None:
        structure = self.structure(plane(n=2), procedure="static")
        shape = structure.surfaces[0].coordinates.shape
        zigzag = 1e9 * np.random.default_rng(1).standard_normal(shape)
        with self.assertRaisesRegex(ConvergenceError, "ccx: "):
            structure.solve_step(StepRequest(1, 0, 0, 1), {"wall": zigzag})
        structure.reject_step()
        structure.solve_step(StepRequest(1, 0, 0, 1), uniform(structure, (0, 1e-3, 0)))

    def test_a_deck_that_ccx_refuses(self) -> None:
        with self.assertRaisesRegex(CcxError, "(?s)exit code 201.*ERROR"):
            self.structure((KINDS["S4"] + WEIGHT).replace("MATERIAL=M", "MATERIAL=N"))

    def test_missing_killed_and_stuck(self) -> None:
        with self.assertRaisesRegex(CcxError, 'no program "no_ccx" in PATH, allowed: ccx of CalculiX'):
            self.structure(KINDS["S4"], program="no_ccx")
        killed = self.structure(KINDS["S4"], program=self.program("echo about to solve; kill -KILL $$"))
        with self.assertRaisesRegex(CcxError, "(?s)ccx was ended by SIGKILL on step.inp; .*about to solve"):
            killed.solve_step(StepRequest(1, 0, 0, 1), {})
        stuck = self.structure(KINDS["S4"], program=self.program("echo $$ > pid; exec sleep 1000"), deadline=0.5)
        with self.assertRaisesRegex(CcxError, "did not end within 0.5 s"):
            stuck.solve_step(StepRequest(1, 0, 0, 1), {})
        pid = int((stuck.folder / "pid").read_text())
        end = time.monotonic() + 20
        while Path(f"/proc/{pid}").exists():
            self.assertLess(time.monotonic(), end, "it still runs")
            time.sleep(0.01)

    def test_a_restart_file_of_something_else(self) -> None:
        structure = self.structure(KINDS["B31"])
        structure.solve_step(StepRequest(1, 0, 0, 1e-3), {})
        whole = (structure.folder / "step.rout").read_bytes()
        for content, word in ((whole.replace(b"Version 2.20", b"Version 9.99"), "Version 9.99"),
                              (whole[:5000], "broken"), (b"", "ends too early"), (b"something else at all", "broken")):
            path = self.folder / "x.rin"
            path.write_bytes(content)
            with self.assertRaisesRegex(RestartFileError, word):
                read_nodal_state(path)


class Killed(CalculixCase):
    def test_no_temporary_folder_is_left(self) -> None:
        """Whatever ends the program while it waits for a coupler that is not there."""
        write(self.folder, solid())
        scratch = self.folder / "scratch"
        scratch.mkdir()
        environment = {**os.environ, "TMPDIR": str(scratch), "PYTHONPATH": str(ROOT / "protocol" / "python")}
        command = [ROOT / "structures" / "calculix" / "calculix_structure", "--coupler", "tcp://127.0.0.1:9"]
        for number in (signal.SIGKILL, signal.SIGTERM):
            with self.subTest(number.name), subprocess.Popen(command, cwd=self.folder, env=environment,
                                                             stderr=subprocess.DEVNULL) as program:
                while not list(scratch.glob("gabion_calculix_*")):
                    self.assertIsNone(program.poll(), "it ended too early")
                    time.sleep(0.02)
                (next(scratch.iterdir()) / "step.rout").write_text("of ccx")
                program.send_signal(number)
                self.assertNotEqual(program.wait(), 0)
                end = time.monotonic() + 120
                while list(scratch.iterdir()) and time.monotonic() < end:
                    time.sleep(0.02)
                self.assertEqual(list(scratch.iterdir()), [])


if __name__ == "__main__":
    if shutil.which("ccx") is None:  # scripts/setup: tests_of_lacking
        print("ccx of CalculiX is not installed: not run")
        sys.exit(77)
    unittest.main()
