#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two structures of fem_solver on one soil: a block that sags between two walls bends both alike."""

import json
import math
import subprocess
from pathlib import Path

import launch
from launch import FEM, IntegrationCase, free_endpoint, meeting, read_table

ROOT = Path(__file__).resolve().parent.parent.parent
HEIGHT, WIDTH, CELL = 0.08, 0.02, 0.01  # [m] of a wall, of its cells and those of the soil
LEFT, RIGHT = 0.1, 0.3  # [m] sides of the soil


def structure(interface: str, left: float, probe: float) -> dict:
    """A wall from `left` on; its probe A stands at the top of the side to the soil, at x = `probe`."""
    mesh = {"low": [left, 0], "high": [left + WIDTH, HEIGHT], "cells": [2, 8], "type": "quad4"}
    return FEM | {"mesh": {"box": mesh}, "interfaces": [{"name": interface, "groups": ["left", "top", "right"]}],
                  "probes": [{"name": "A", "point": [probe, HEIGHT]}]}


def surface(interface: str, left: float) -> dict:
    outline = [[left + WIDTH, 0], [left + WIDTH, HEIGHT], [left, HEIGHT], [left, 0]]
    return {"name": interface, "surface": {"polyline": outline, "spacing": CELL}, "friction": 0.3}


def scene() -> dict[str, dict]:
    files = meeting()
    files["mpm"] |= {
        "grid": {"box": {"low": [0, 0], "high": [0.4, 0.1], "cells": [40, 10], "type": "quad4"}},
        "walls": [{"group": "bottom", "condition": "slip"}],
        "gravity": [0, -9.81],
        "interfaces": [surface("wall", RIGHT), surface("mesh", LEFT - WIDTH)]}
    files["mpm"]["bodies"][0] |= {
        "mesh": {"box": {"low": [LEFT, 0], "high": [RIGHT, 0.06], "cells": [20, 6], "type": "quad4"}},
        "velocity": [0, 0],
        "material": {"law": "hencky_elastic", "density": 2650, "young_modulus": 840e3, "poisson_ratio": 0.3}}
    files["fem"] = structure("wall", RIGHT, RIGHT)
    coupler = files["coupler"]
    coupler["time"] |= {"end": 0.01}
    coupler["participants"]["fence"] = {"sends": "displacement"}
    coupler["interfaces"].append({"name": "mesh", "soil": "soil", "structure": "fence"})
    return files


class TwoStructures(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = scene()
        self.fence = self.scene / "fence"
        self.fence.mkdir(parents=True)
        (self.fence / "fem.json").write_text(json.dumps(structure("mesh", LEFT - WIDTH, LEFT)))

    def test_started_by_hand(self) -> None:
        endpoint = free_endpoint()
        self.files["coupler"]["protocol"] = {"endpoint": endpoint}
        self.write_scene(self.files)
        run = self.start()
        second = launch.Launch([str(launch.binaries / "fem_solver"), str(self.fence), "--name", "fence", "--output",
                                str(self.out), "--coupler", endpoint], self.folder)
        self.addCleanup(second.end)
        for each in (run, second):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        self.check_that_both_bend_alike()

    def test_started_by_script(self) -> None:
        if launch.binaries != ROOT / "build" / "release" / "bin":
            self.skipTest("scripts/run uses build/release only")
        self.files["coupler"]["participants"]["fence"]["command"] = [
            "fem_solver", "fence", "--name", "fence", "--output", "{output}"]
        self.write_scene(self.files)
        run = [ROOT / "scripts" / "run", self.scene, "--output", self.out, "--no-plots"]
        for options, says in ((["--check"], "valid"), ([], "completed")):
            done = subprocess.run([*run, *options], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True, timeout=launch.TIMEOUT, check=False)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertIn(says, done.stdout)
            self.assertEqual(self.out.exists(), not options)
        self.check_that_both_bend_alike()

    def check_that_both_bend_alike(self) -> None:
        for frames in ("fem", "fence"):
            self.assertTrue((self.out / frames / "structure.xdmf").exists(), frames)
        peaks = [max(abs(float(row[f"{name}.A.ux"])) for row in read_table(self.out / "probes.csv"))
                 for name in ("structure", "fence")]
        self.assertGreater(peaks[0], 1e-6)
        self.assertTrue(math.isclose(*peaks, rel_tol=1e-3), peaks)
        last = read_table(self.out / "probes.csv")[-1]
        self.assertLess(float(last["structure.A.ux"]) * float(last["fence.A.ux"]), 0)


if __name__ == "__main__":
    launch.main()
