#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A structure that begins displaced by two cells of the soil, which has its surface there from the outset."""

import json

import launch
import restart_rows
from launch import IntegrationCase, meeting, read_table

CELL = 0.05  # [m] of the soil's grid
SHIFT = -0.1  # [m] of a plate at the start, from its top at TOP
TOP, GAP, SPEED = 0.4, 0.02, 1.0  # [m, m/s] of a block that falls on the plate: gap to where it begins


def scene(shift: float = SHIFT, gap: float = GAP) -> dict[str, dict]:
    files = meeting()
    bottom = TOP + shift + gap
    files["fem"] |= {
        "mesh": {"box": {"low": [0, TOP - 0.1], "high": [1, TOP], "cells": [20, 2], "type": "quad4"}},
        "gravity": [0, 0], "supports": [],
        "prescribed": [{"group": "bottom", "component": "x", "table": [[0, 0]]},
                       {"group": "bottom", "component": "y", "table": [[0, shift]]}],
        "interfaces": [{"name": "wall", "groups": ["top"]}],
        "probes": [{"name": "A", "point": [0.5, TOP]}]}
    files["mpm"] |= {
        "grid": {"box": {"low": [0, 0], "high": [1, 1], "cells": [20, 20], "type": "quad4"}},
        "walls": [], "gravity": [0, 0],
        "interfaces": [{"name": "wall", "surface": {"polyline": [[0.9, TOP], [0.1, TOP]], "spacing": CELL}}]}
    files["mpm"]["bodies"][0] |= {
        "mesh": {"box": {"low": [0.4, bottom], "high": [0.6, bottom + 0.1], "cells": [4, 2], "type": "quad4"}},
        "velocity": [0, -SPEED],
        "material": {"law": "neo_hookean", "density": 2000, "young_modulus": 1e6, "poisson_ratio": 0.2}}
    files["coupler"]["time"] |= {"end": 0.03, "dt": 1e-3}
    files["coupler"]["output"]["interval"] = 0.01
    files["coupler"]["coupling"]["predictor"] = 2
    return files


class DisplacedStart(IntegrationCase):
    def steps(self, out: str = "out") -> list[dict[str, str]]:
        return read_table(self.folder / out / "steps.csv")

    def test_the_soil_meets_the_plate_where_it_begins(self) -> None:
        self.write_scene(scene())
        ended = self.run_launch(code=0)
        self.assert_says(ended.text, 'interfaces of soil start displaced: "wall" by up to 0.1 m')
        self.assert_says(ended.text, "[mpm]", "wall: smallest gap to the soil 0.02 m")
        rows = self.steps()
        touched = [float(row["time"]) for row in rows if float(row["fy"]) != 0]
        self.assertAlmostEqual(touched[0], GAP / SPEED, delta=1.01e-3)  # a step
        self.assertEqual(sum(int(row["cuts"]) for row in rows), 0)
        probes = read_table(self.out / "probes.csv")
        self.assertAlmostEqual(float(probes[0]["structure.A.uy"]), SHIFT, delta=1e-12)
        before = [row for row in rows if float(row["time"]) < touched[0]]
        self.assertEqual({float(row["soil_work"]) for row in before}, {0.0})

    def test_a_restart_gives_the_same_rows(self) -> None:
        self.write_scene(scene())
        for ranks in ({}, {"mpm_solver": 2}):
            straight, first, second = (self.folder / f"{name}_{len(ranks)}" for name in ("straight", "first", "second"))
            self.out = straight
            self.run_launch(code=0, ranks=ranks)
            self.out = first
            self.run_launch("--set", "coupler.json:/time/end=0.022", code=0, ranks=ranks)
            self.out = second
            self.run_launch("--restart", str(first), code=0, ranks=ranks)
            old, new = (restart_rows.rows_without_seconds(out / "steps.csv") for out in (straight, second))
            self.assertEqual(len(new), 9)
            self.assertEqual(new[1:], old[-8:])
        one, two = self.steps("straight_0"), self.steps("straight_1")
        for a, b in zip(one, two, strict=True):
            self.assertAlmostEqual(float(a["fy"]), float(b["fy"]), delta=1e-6 * max(1.0, abs(float(a["fy"]))))

    def test_soil_inside_the_plate_is_refused_before_the_first_step(self) -> None:
        self.write_scene(scene(shift=0.02, gap=-0.02))  # none at the reference
        for options in (("--check",), ()):
            ended = self.run_launch(*options, code=2)
            self.assert_says(ended.text, "inside", '"wall" by up to 0.02 m', "displaced from where they are")

    def test_a_beam_that_sags(self) -> None:
        """A soft beam between two ends, by more than a cell under its weight."""
        files = scene()
        files["fem"] |= {
            "mesh": {"box": {"low": [0, TOP - 0.05], "high": [1, TOP], "cells": [20, 2], "type": "quad4"}},
            "material": {"law": "neo_hookean", "formulation": "enhanced", "density": 2500, "young_modulus": 2e6,
                         "poisson_ratio": 0},
            "gravity": [0, -9.81], "prescribed": [], "supports": [{"group": "left"}, {"group": "right"}]}
        files["mpm"]["bodies"][0]["mesh"]["box"] |= {"low": [0.4, TOP + 0.005], "high": [0.6, TOP + 0.105]}
        files["mpm"]["gravity"] = [0, -9.81]
        files["coupler"]["time"]["end"] = 0.01
        self.write_scene(files)
        self.run_launch(code=0)
        sag = -float(read_table(self.out / "probes.csv")[0]["structure.A.uy"])
        self.assertGreater(sag, CELL)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertIs(summary["completed"], True)
        self.assertEqual(summary["cuts"], 0)
        self.assertEqual(summary["messages"]["soil"]["set_start"]["count"], 1)


if __name__ == "__main__":
    launch.main()
