#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""precice_names: an adapter for preCICE's Python bindings in a coupled run, and what is not mapped."""

import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path

import numpy as np
from fake_coupler import ROOT, ParticipantCase
from gabion_participant import UsageError, precice_names
from gabion_participant.precice_names import NotMapped
from gabion_participant.solver import END_OF_STEP, STEP_MEAN

CASE = Path(__file__).resolve().parent / "precice_case"
CONFIG = (CASE / "precice-config.xml").read_text(encoding="utf-8")
STEP = 0.1  # [s] of the coupler
sys.path[:0] = [str(CASE)]
sys.modules["precice"] = precice_names
import adapter  # noqa: E402  (it imports precice)


class AdapterCase(ParticipantCase):
    def setUp(self) -> None:
        super().setUp()
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        os.environ[precice_names.ENDPOINT] = self.coupler.endpoint
        self.addCleanup(os.environ.pop, precice_names.ENDPOINT)
        self.names = (CASE / "gabion_names.json").read_text(encoding="utf-8")

    def config(self, *changes: tuple[str, str]) -> str:
        """The case's file with texts replaced."""
        text = CONFIG
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        (self.folder / "precice-config.xml").write_text(text, encoding="utf-8")
        if self.names:
            (self.folder / "gabion_names.json").write_text(self.names, encoding="utf-8")
        return str(self.folder / "precice-config.xml")

    def participant(self, *changes: tuple[str, str], name: str = "Solid") -> precice_names.Participant:
        return precice_names.Participant(name, self.config(*changes), 0, 1)

    def solve(self, step: int, force: float, iteration: int = 0, dt: float = STEP) -> np.ndarray:
        """The displacement [m] that answers an equal force [N] on every component, num_vertices x 2."""
        self.coupler._dt = dt  # noqa: SLF001: as its own solve(), which knows another mesh
        reply = self.coupler.ask("solve_step", {"force:wall": np.full((4, 2), force)}, step=step, iteration=iteration,
                                 time=self.coupler._time, dt=dt)  # noqa: SLF001
        return reply.arrays["displacement:wall"]

    def expected(self, forces: list[float], dts: list[float], own_dt: float = 1.0) -> float:
        """Displacement after steps whose forces are linear in time, from 0."""
        state, before = (0.0, 0.0), 0.0
        for force, dt in zip(forces, dts):
            count = max(1, round(dt / min(own_dt, dt)))
            for k in range(count):
                ends = [before + (force - before) * (k + part) / count for part in (0, 1)]
                state = adapter.step(state, dt / count, *ends)
            before = force
        return state[0]


class CoupledRun(AdapterCase):
    def run_adapter(self, own_dt: float, launched: bool = False) -> str:
        """Iterations, a rejected step, a cut one; returns what the adapter printed."""
        config = self.config()
        words = [sys.executable, "-m", "gabion_participant.precice_names"] if launched else [sys.executable, "-c", (
            "import sys, runpy, gabion_participant.precice_names as precice; sys.modules['precice'] = precice; "
            "sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')")]
        words += [str(CASE / "adapter.py"), config, str(own_dt)]
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "protocol" / "python"), "PYTHONDONTWRITEBYTECODE": "1"}
        if launched:
            words += ["--coupler", environment.pop(precice_names.ENDPOINT)]
        started = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
        self.addCleanup(started.kill)
        self.hello = self.coupler.welcome(run={"end": 1.0, "dt": STEP})
        self.drive(own_dt)
        out, errors = started.communicate(timeout=600)
        self.assertEqual((started.returncode, errors), (0, ""))
        return out

    def drive(self, own_dt: float) -> None:
        def near(found: np.ndarray, forces: list[float], dts: list[float]) -> None:
            np.testing.assert_allclose(found, self.expected(forces, dts, own_dt), rtol=1e-10, atol=1e-18)

        near(self.solve(1, 5.0), [5], [STEP])
        near(self.solve(1, 7.0, iteration=1), [7], [STEP])  # from the accepted state, not from the trial
        self.coupler.accept(1)
        near(self.solve(2, -3.0), [7, -3], [STEP, STEP])
        self.coupler.ask("reject_step")
        near(self.solve(2, 4.0, dt=STEP / 2), [7, 4], [STEP, STEP / 2])  # a smaller one in its place
        self.coupler.accept(2)
        near(self.solve(3, 1.0, dt=STEP / 2), [7, 4, 1], [STEP, STEP / 2, STEP / 2])
        self.coupler.accept(3)
        self.coupler.ask("finish")

    def test_with_its_import_changed(self) -> None:
        printed = self.run_adapter(own_dt=1.0)
        self.assertEqual(self.hello.fields["participant"], "structure")
        self.assertEqual(self.hello.fields["interfaces"][0]["name"], "wall")
        self.assertIs(self.hello.fields["takes_force_kinds"], True)
        np.testing.assert_array_equal(self.hello.arrays["coordinates:wall"], adapter.VERTICES)
        np.testing.assert_array_equal(self.hello.arrays["facets:wall"], [[0, 1], [1, 2], [2, 3]])
        self.assertEqual([line.split()[0] for line in printed.splitlines()], ["0.100000", "0.150000", "0.200000"])

    def test_with_steps_of_its_own(self) -> None:
        """Forces are linear in time between the ends of accepted steps, as the adapter's own steps see them."""
        self.run_adapter(own_dt=0.025)

    def test_with_nothing_changed(self) -> None:
        self.run_adapter(own_dt=1.0, launched=True)

    def test_mean_forces_hold_for_the_whole_step(self) -> None:
        seen: list[float] = []
        participant = self.participant()
        ids = participant.set_mesh_vertices("Wall-Mesh", adapter.VERTICES)

        def run() -> None:
            participant.initialize()
            while participant.is_coupling_ongoing():
                participant.requires_writing_checkpoint()
                dt = participant.get_max_time_step_size()
                seen.extend(participant.read_data("Wall-Mesh", "Force", [2], t)[0, 1] for t in (0, dt / 2, dt))
                participant.write_data("Wall-Mesh", "Displacement", ids, 0 * adapter.VERTICES)
                participant.advance(dt)
                participant.requires_reading_checkpoint()

        for kind, expected in ((END_OF_STEP, [0, 4, 8, 8, 5, 2]), (STEP_MEAN, [8, 8, 8, 2, 2, 2])):
            with self.subTest(kind):
                self.start(run)
                self.coupler.welcome()
                if kind == STEP_MEAN:
                    self.coupler.ask("set_force_kinds", kinds={"wall": STEP_MEAN})
                for step, force in ((1, 8.0), (2, 2.0)):
                    self.solve(step, force)
                    self.coupler.accept(step)
                self.coupler.ask("finish")
                self.assertEqual(self.end(), "")
                np.testing.assert_allclose(seen, expected, atol=1e-12)
                seen.clear()
                self.coupler.begin_again()
                participant = self.participant()
                ids = participant.set_mesh_vertices("Wall-Mesh", adapter.VERTICES)

    def test_other_times_than_those_of_the_coupler_are_a_warning(self) -> None:
        participant = self.participant()
        participant.set_mesh_vertices("Wall-Mesh", adapter.VERTICES)
        self.start(participant.initialize)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            self.coupler.welcome(run={"end": 2.0, "dt": STEP})
            self.coupler.ask("finish")
            self.assertEqual(self.end(), "")
        self.assertEqual([str(each.message).split(" in ")[0] for each in caught], ["max-time is 1 s"])

    def test_a_soil(self) -> None:
        participant = self.participant(name="Soil")
        for position in adapter.VERTICES:
            participant.set_mesh_vertex("Soil-Mesh", position)
        self.start(participant.initialize)
        hello = self.coupler.welcome()
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.assertEqual((hello.fields["participant"], hello.fields["sends"]["quantity"]), ("soil", "force"))
        self.assertEqual(hello.arrays["coordinates:wall"].shape, (4, 2))

    def test_in_space(self) -> None:
        self.names = ""
        for call, vertices in (("set_mesh_triangle", (0, 1, 2)), ("set_mesh_quad", (0, 1, 2, 3))):
            participant = self.participant(('name="Wall-Mesh" dimensions="2"', 'name="Wall-Mesh" dimensions="3"'))
            participant.set_mesh_vertices("Wall-Mesh", np.eye(4, 3))
            participant.set_mesh_edge("Wall-Mesh", 0, 1)
            getattr(participant, call)("Wall-Mesh", *vertices)
            self.start(participant.initialize)
            hello = self.coupler.welcome()
            self.coupler.ask("finish")
            self.assertEqual(self.end(), "")
            self.assertEqual(hello.fields["participant"], "Solid")
            self.assertEqual(hello.arrays["facets:Wall-Mesh"].tolist(), [list(vertices)])
            self.coupler.begin_again()


class Refused(AdapterCase):
    def expect(self, kind: type, words: str, action, *arguments, **how) -> None:
        with self.assertRaises(kind) as caught:
            action(*arguments, **how)
        self.assertIn(words, str(caught.exception))

    def test_configurations(self) -> None:
        wall = 'write-data name="Displacement" mesh="Wall-Mesh"'
        for words, *changes in (
                ("of preCICE 2", ("<precice-configuration>", "<precice-configuration><solver-interface/>")),
                ("found no data:vector", (wall, 'write-data name="Temperature" mesh="Wall-Mesh"')),
                ("not provide; allowed: its own meshes", (wall, 'write-data name="Displacement" mesh="Soil-Mesh"')),
                ('reads [\'Force\'] and writes []', (f"<{wall} />", "")),
                ("neither a force [N of each vertex] nor a displacement", ("Displacement", "DisplacementDelta")),
                ("neither a force", ('"Force"', '"Stress"'))):
            self.expect(NotMapped, words, self.participant, *changes)
        self.expect(UsageError, 'found dimensions "4"', self.participant, ('"Wall-Mesh" dimensions="2"',
                                                                             '"Wall-Mesh" dimensions="4"'))
        self.expect(UsageError, "allowed: Soil, Solid", self.participant, name="Fluid")
        self.expect(UsageError, "cannot be read as precice-config", self.participant, ("</precice-configuration>", ""))
        missing = str(self.folder / "none.xml")
        self.expect(UsageError, "cannot be read", precice_names.Participant, "Solid", missing, 0, 1)
        self.expect(NotMapped, "found process 1 of 2", precice_names.Participant, "Solid", self.config(), 1, 2)

    def test_names_of_our_own(self) -> None:
        self.names = json.dumps({"quantities": {"Stress": "force"}})
        participant = self.participant(('"Force"', '"Stress"'))
        self.assertEqual(participant.get_data_dimensions("Wall-Mesh", "Stress"), 2)
        for names in ('{"meshes": {}}', '{"interfaces": []}', "[]", "{"):
            self.names = names
            self.expect(UsageError, "gabion_names.json: ", self.participant)

    def test_no_endpoint(self) -> None:
        del os.environ[precice_names.ENDPOINT]
        self.addCleanup(os.environ.setdefault, precice_names.ENDPOINT, "")
        self.expect(UsageError, "where is the coupler?", self.participant)

    def test_calls(self) -> None:
        participant = self.participant()
        self.assertEqual(participant.set_mesh_vertices("Wall-Mesh", adapter.VERTICES).tolist(), [0, 1, 2, 3])
        self.assertEqual(participant.get_mesh_vertex_size("Wall-Mesh"), 4)
        self.assertIs(participant.requires_mesh_connectivity_for("Wall-Mesh"), True)
        self.assertIs(participant.requires_gradient_data_for("Wall-Mesh", "Force"), False)
        for call in ("set_mesh_tetrahedron", "set_mesh_tetrahedra", "reset_mesh", "write_gradient_data",
                     "map_and_read_data", "write_and_map_data", "set_mesh_access_region",
                     "get_mesh_vertex_ids_and_coordinates"):
            self.expect(NotMapped, call, getattr(participant, call), "Wall-Mesh", [[0, 0]])
        self.expect(NotMapped, "couples volumes in 2D", participant.set_mesh_triangle, "Wall-Mesh", 0, 1, 2)
        self.expect(NotMapped, "there are no initial data", participant.write_data, "Wall-Mesh", "Displacement", [0],
                    [[0, 0]])
        self.expect(UsageError, 'found mesh "Fluid-Mesh", allowed: Wall-Mesh', participant.get_mesh_dimensions,
                    "Fluid-Mesh")
        self.expect(UsageError, 'found data "Velocity"', participant.get_data_dimensions, "Wall-Mesh", "Velocity")
        self.expect(UsageError, "num_vertices x 2", participant.set_mesh_vertex, "Wall-Mesh", [0, 0, 0])
        self.expect(NotMapped, "precice.Interface is of preCICE 2", lambda: precice_names.Interface)
        self.assertRegex(precice_names.get_version_information(), rb"^gabion_participant, protocol \d")

    def test_values(self) -> None:
        """Each wrong call within a step says what is allowed; the right ones go on afterwards."""
        participant = self.participant()
        ids = participant.set_mesh_vertices("Wall-Mesh", adapter.VERTICES)

        def run() -> None:
            participant.initialize()
            participant.requires_writing_checkpoint()
            self.expect(UsageError, "allowed: 0 to 0.1 s", participant.read_data, "Wall-Mesh", "Force", ids, 0.2)
            self.expect(UsageError, 'found data "Displacement"', participant.read_data, "Wall-Mesh", "Displacement",
                        ids, 0)
            self.expect(UsageError, "found vertex ids 4 to 4", participant.read_data, "Wall-Mesh", "Force", [4], 0)
            write = participant.write_data
            self.expect(UsageError, 'found data "Force"', write, "Wall-Mesh", "Force", ids, adapter.VERTICES)
            self.expect(UsageError, "found values of shape [4] for", write, "Wall-Mesh", "Displacement", ids,
                        np.zeros(4))
            write("Wall-Mesh", "Displacement", ids[:3], np.zeros((3, 2)))
            self.expect(UsageError, "write_data for all vertices", participant.advance, 0.1)
            self.expect(UsageError, "set_mesh_vertices: allowed before", participant.set_mesh_vertices, "Wall-Mesh",
                        [[0, 0]])
            write("Wall-Mesh", "Displacement", ids[3], [[1.0, 2.0]])
            participant.advance(0.1)
            self.assertIs(participant.is_coupling_ongoing(), False)

        def run_to_the_end() -> None:
            try:
                run()
            finally:
                participant.finalize()  # tells the coupler, which else would wait

        self.start(run_to_the_end)
        self.coupler.welcome()
        self.assertEqual(self.solve(1, 1.0).tolist(), [[0, 0]] * 3 + [[1, 2]])
        self.coupler.accept(1)
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")


class Names(unittest.TestCase):
    """The calls of the bindings, and the page that says what each becomes."""

    CALLS = {"initialize", "advance", "finalize", "get_mesh_dimensions", "get_data_dimensions",
             "is_coupling_ongoing", "is_time_window_complete", "get_max_time_step_size",
             "requires_initial_data", "requires_writing_checkpoint", "requires_reading_checkpoint",
             "requires_mesh_connectivity_for", "set_mesh_vertex", "get_mesh_vertex_size", "set_mesh_vertices",
             "set_mesh_edge", "set_mesh_edges", "set_mesh_triangle", "set_mesh_triangles", "set_mesh_quad",
             "set_mesh_quads", "set_mesh_tetrahedron", "set_mesh_tetrahedra", "reset_mesh", "write_data",
             "read_data", "write_and_map_data", "map_and_read_data", "write_gradient_data",
             "requires_gradient_data_for", "set_mesh_access_region", "get_mesh_vertex_ids_and_coordinates",
             "start_profiling_section", "stop_last_profiling_section"}

    def test_all_are_there_and_no_other(self) -> None:
        found = {name for name in vars(precice_names.Participant) if not name.startswith("_")}
        self.assertEqual(found, self.CALLS)

    def test_the_page_has_them_all(self) -> None:
        page = (ROOT / "docs" / "precice_names.md").read_text(encoding="utf-8")
        first_cells = " ".join(line.split("|")[1] for line in page.splitlines() if line.startswith("|"))
        named = {re.sub(r"([A-Z])", lambda letter: "_" + letter[1].lower(), word)
                 for word in re.findall(r"`(\w+)`", first_cells)}
        self.assertEqual(self.CALLS - named, set())


if __name__ == "__main__":
    unittest.main()
