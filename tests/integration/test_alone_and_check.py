#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Solvers without coupler, --check, and --set."""

import json
import os
import shutil

import launch
from launch import ALONE, IntegrationCase, meeting, read_table


class Alone(IntegrationCase):
    def test_soil_alone(self) -> None:
        """A block that slides without friction and meets nothing keeps its speed."""
        self.write_scene({"mpm": {**meeting()["mpm"], **ALONE}})
        self.run_program("mpm_solver", self.scene, "--output", self.out, code=0)
        probes = read_table(self.out / "probes.csv")
        self.assertEqual([float(row["time"]) for row in probes], [0, 0.001, 0.002, 0.003, 0.004, 0.005])
        for row in probes:
            self.assertAlmostEqual(float(row["momentum_x"]), 0.5 * 12.72, delta=1e-7)
        self.assertAlmostEqual(float(probes[-1]["front"]) - float(probes[0]["front"]), 0.0025, delta=1e-4)
        self.assertEqual(self.assert_frames_open(self.out / "mpm", "soil"), [0, 0.002, 0.004, 0.005])
        self.check_summary("mpm_solver")

    def test_structure_alone(self) -> None:
        """The wall stands at rest under its weight, and stays there."""
        self.write_scene({"fem": {**meeting()["fem"], **ALONE}})
        self.run_program("fem_solver", self.scene, "--output", self.out, code=0)
        probes = read_table(self.out / "probes.csv")
        sag = -1100 * 9.81 * 0.05**2 / (2 * 1e6)  # [m] linear theory
        for row in probes:
            self.assertAlmostEqual(float(row["A.uy"]), sag, delta=1e-3 * abs(sag))
            self.assertAlmostEqual(float(row["A.ux"]), 0, delta=1e-9)
        self.assertEqual(self.assert_frames_open(self.out / "fem", "structure"), [0, 0.002, 0.004, 0.005])
        self.check_summary("fem_solver")

    def check_summary(self, program: str) -> None:
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertIs(summary["completed"], True)
        self.assertEqual((summary["program"], summary["steps"]), (program, 5))
        self.assertEqual(len(read_table(self.out / "steps.csv")), 5)
        self.assertGreater(summary["solver"]["peak_memory"]["largest_rank"], 10_000_000)

    def test_without_time_alone_is_an_error(self) -> None:
        self.write_scene({"mpm": meeting()["mpm"]})
        ended = self.run_program("mpm_solver", self.scene, "--output", self.out, code=2)
        self.assert_says(ended.text, "[mpm] error:", "mpm.json: at /time: missing")


class Advice(IntegrationCase):
    """mpm_solver says how many ranks pay; that of a coupled scene is asked without the coupler."""

    def test_few_points(self) -> None:
        for parts in ({"mpm": {**meeting()["mpm"], **ALONE}}, meeting()):
            self.write_scene(parts)
            said = self.run_program("mpm_solver", self.scene, "--advise-ranks", "8", code=0).text
            self.assertTrue(said.startswith("1\0"), said)
            self.assertTrue(said.endswith(" points in the plane: several ranks are not advised in the plane\0"), said)

    def test_a_fault_of_the_scene_is_one_here(self) -> None:
        self.write_scene({"mpm": {**meeting()["mpm"], **ALONE, "dimension": 4}})
        ended = self.run_program("mpm_solver", self.scene, "--advise-ranks", "0", code=2)
        self.assert_says(ended.text, "mpm.json: at /dimension")


class Check(IntegrationCase):
    FILE = {"coupler": "coupler", "mpm_solver": "mpm", "fem_solver": "fem"}

    def test_good_scene(self) -> None:
        self.write_scene(meeting())
        before = sorted(self.folder.iterdir())
        for program, file in self.FILE.items():
            ended = self.run_program(program, self.scene, "--output", self.out, "--check", code=0)
            self.assert_says(ended.text, f"{file}.json: valid")
        self.assertEqual(sorted(self.folder.iterdir()), before)  # nothing is written

    def test_scenes_of_the_project(self) -> None:
        configs = launch.Path(__file__).resolve().parents[2] / "configs"
        checked = 0
        for program, file in self.FILE.items():
            for scene in sorted(configs.glob(f"*/{file}.json")):
                with self.subTest(scene=scene.parent.name, program=program):
                    self.run_program(program, scene.parent, "--output", self.out, "--check", code=0)
                    checked += 1
        self.assertGreaterEqual(checked, 8)

    def test_bad_scene(self) -> None:
        for program, file in self.FILE.items():
            with self.subTest(program):
                files = meeting()
                files[file]["surprise"] = 1
                self.write_scene(files)
                ended = self.run_program(program, self.scene, "--check", code=2)
                self.assert_says(ended.text, f"{file}.json: at /surprise: unknown key")


    def test_groups_that_nothing_uses(self) -> None:
        mesh = launch.Path(__file__).resolve().parents[1] / "unit" / "mesh" / "data" / "plate.msh"
        fem = {"dimension": 2, "mesh": {"file": "plate.msh"}, "material": meeting()["fem"]["material"],
               "supports": [{"group": "outside"}], "tractions": [{"group": "hole", "traction": [1, 0]}], **ALONE}
        self.write_scene({"fem": fem})
        shutil.copy(mesh, self.scene)
        ended = self.run_program("fem_solver", self.scene, "--check", code=0)
        self.assert_says(ended.text, "warning: ", "fem.json: at /mesh", 'the facet group "between" of plate.msh')
        self.assert_says(ended.text, "warning: ", "fem.json: at /mesh", "cell groups inlay, plate", "one material")
        self.assertEqual(ended.text.count("warning"), 2, ended.text)


class Set(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.write_scene(meeting())

    def test_end_of_the_run(self) -> None:
        self.run_launch("--set", "coupler.json:/time/end=0.002", "--set", "fem.json:/probes/0/name=tip", code=0)
        probes = read_table(self.out / "probes.csv")
        self.assertEqual(float(probes[-1]["time"]), 0.002)
        self.assertIn("structure.tip.ux", probes[0])
        resolved = json.loads((self.out / "resolved_config.json").read_text())
        self.assertEqual(resolved["coupler.json"]["time"]["end"], 0.002)

    def refused(self, setting: str, *words: str) -> None:
        with self.subTest(setting):
            ended = self.run_program("coupler", self.scene, "--check", "--set", setting, code=2)
            self.assert_says(ended.text, "[cpl] error:", *words)

    def test_wrong_settings(self) -> None:
        self.refused("cuopler.json:/time/end=1", 'no file "cuopler.json"', 'did you mean "coupler.json"')
        self.refused("coupler.json:/time/ned=1", "coupler.json: at /time/ned: unknown key", '"end"')
        self.refused("coupler.json:/time/end/x=1", "--set coupler.json:/time/end/x=1:")
        self.refused("coupler.json:/participants/soil/sends=heat", "at /participants/soil/sends", '"heat"')
        self.refused("coupler.json:/time/end=soon", "at /time/end", '"soon"', "number")
        self.refused("coupler.json:time/end=1", "allowed: FILE:/json/pointer=VALUE")
        self.refused("coupler.json:/time/end", "allowed: FILE:/json/pointer=VALUE")
        self.refused("coupler.json:/interfaces/7/name=x", 'found entry "7" of /interfaces, allowed: 0 to 0')


class CommandLine(IntegrationCase):
    def test_wrong_lines(self) -> None:
        self.run_program("coupler", code=2)
        self.run_program("coupler", self.folder, "--outptu", "x", code=2)
        ended = self.run_program("coupler", self.folder / "nowhere", code=2)
        self.assert_says(ended.text, "nowhere: no such scene folder")
        ended = self.run_program("coupler", self.folder, code=2)
        self.assert_says(ended.text, "holds none of coupler.json, mpm.json, fem.json")
        self.write_scene(meeting())
        ended = self.run_program("coupler", self.scene, "--check", "--log-level", "loud", code=2)
        self.assert_says(ended.text, '"loud"', "debug, info, warn, error")
        (self.scene / "coupler.json").write_text('{"time": {\n"end": }}')
        ended = self.run_program("coupler", self.scene, "--check", code=2)
        self.assert_says(ended.text, "coupler.json: not valid JSON", "line 2")
        self.assertEqual(os.listdir(self.folder), ["scene"])


if __name__ == "__main__":
    launch.main()
