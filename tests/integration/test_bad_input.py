#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Wrong input through the real programs: exit code 2, file and place named, the whole launch ends."""

import json

import launch
from launch import IntegrationCase, meeting


class BadInput(IntegrationCase):
    def refused(self, files: dict[str, dict], *words: str) -> None:
        self.write_scene(files)
        ended = self.run_launch(code=2)
        self.assert_says(ended.text, "error: ", *words)
        said = [line for line in ended.text.splitlines() if "error: " in line and words[1] in line]
        self.assertEqual(len(said), 1, ended.text)  # at the one terminal of all
        for program, participant in (("mpm_solver", "soil"), ("fem_solver", "structure")):
            if words[0] == f"[{program[:3]}]":  # which tells the coupler
                self.assert_says((self.out / "coupler.log").read_text(),
                                 f'[cpl] error: participant "{participant}" ({program}) cannot begin: ', words[1])
                self.assertIn("cannot begin", json.loads((self.out / "summary.json").read_text())["reason"])

    def test_unknown_key(self) -> None:
        files = meeting()
        material = files["mpm"]["bodies"][0]["material"]
        material["frictoin_angle"] = material.pop("friction_angle")
        self.refused(files, "[mpm]", "scene/mpm.json: at /bodies/0/material/friction_angle: missing")
        material["friction_angle"] = 20
        self.refused(files, "[mpm]", "scene/mpm.json: at /bodies/0/material/frictoin_angle: unknown key",
                     'did you mean "friction_angle"')

    def test_wrong_type(self) -> None:
        files = meeting()
        files["fem"]["material"]["young_modulus"] = "stiff"
        self.refused(files, "[fem]", "scene/fem.json: at /material/young_modulus", '"stiff"', "number")

    def test_negative_density(self) -> None:
        files = meeting()
        files["mpm"]["bodies"][0]["material"]["density"] = -2650
        self.refused(files, "[mpm]", "scene/mpm.json: at /bodies/0/material/density: found -2650", "> 0")

    def test_time_step_of_zero(self) -> None:
        files = meeting()
        files["coupler"]["time"]["dt"] = 0
        self.refused(files, "[cpl]", "scene/coupler.json: at /time/dt: found 0", "> 0")

    def test_missing_mesh_file(self) -> None:
        files = meeting()
        files["fem"]["mesh"] = {"file": "wall.msh"}
        self.refused(files, "[fem]", "scene/wall.msh")

    def test_unknown_surface_group(self) -> None:
        files = meeting()
        files["fem"]["interfaces"][0]["groups"] = ["left", "up"]
        self.refused(files, "[fem]", "scene/fem.json: at /interfaces/0/groups", '"up"', "bottom", "top")

    def test_interface_without_partner(self) -> None:
        files = meeting()
        files["fem"]["interfaces"][0]["name"] = "fence"
        self.refused(files, "[cpl]", "scene/coupler.json: at /interfaces/0/name: found \"wall\"", '"structure"',
                     "fence")

    def test_surfaces_too_far_apart(self) -> None:
        files = meeting()
        files["mpm"]["interfaces"][0]["surface"]["polyline"][2:] = [[0.249, 0.05], [0.249, 0]]
        self.refused(files, "[cpl]", 'interface "wall"', "soil vertex", "(0.249, 0", "0.001", "m away",
                     "allowed: 1e-06 m (coupling/mapping/tolerance)")

    def test_normals_the_wrong_way_round(self) -> None:
        files = meeting()
        files["mpm"]["interfaces"][0]["surface"]["polyline"].reverse()
        files["mpm"]["bodies"][0]["mesh"]["box"].update(low=[0.04, 0], high=[0.12, 0.06])  # nearer, the soil sees it
        self.refused(files, "[cpl]", 'interface "wall"', "normal", "out of the structure")

    def test_coupler_file_missing_in_a_coupled_launch(self) -> None:
        files = meeting()
        del files["coupler"]
        self.refused(files, "[cpl]", "scene/coupler.json: missing")

    def test_broken_json(self) -> None:
        self.write_scene(meeting())
        (self.scene / "mpm.json").write_text('{"dimension": 2,\n "grid": {,}\n}')
        ended = self.run_launch(code=2)
        self.assert_says(ended.text, "error: ", "scene/mpm.json: not valid JSON", "line 2")


if __name__ == "__main__":
    launch.main()
