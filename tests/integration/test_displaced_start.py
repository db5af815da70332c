#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A structure that begins displaced by more than a cell of the soil, which has its surface there from the outset."""

import json
import re

import launch
import restart_rows
from launch import IntegrationCase, meeting, read_table

CELL = 0.05  # [m] of the soil's grid
TOP, SAG = 0.4, 0.07208  # [m] top of a beam, and what it sags by in the middle
GAP, SPEED = 0.02, 1.0  # [m, m/s] of a block that falls on it: gap to the middle, where it begins


def scene(pull: float = -9.81, bottom: float = TOP - SAG + GAP) -> dict[str, dict]:
    """A soft beam between two ends under its weight; soil that has none."""
    files = meeting()
    files["fem"] |= {
        "mesh": {"box": {"low": [0, TOP - 0.05], "high": [1, TOP], "cells": [20, 2], "type": "quad4"}},
        "material": {"law": "neo_hookean", "density": 2500, "young_modulus": 1.5e6,
                     "poisson_ratio": 0},
        "gravity": [0, pull], "supports": [{"group": "left"}, {"group": "right"}],
        "interfaces": [{"name": "wall", "groups": ["top"]}],
        "probes": [{"name": "A", "point": [0.5, TOP]}]}
    files["mpm"] |= {
        "grid": {"box": {"low": [0, 0], "high": [1, 1], "cells": [20, 20], "type": "quad4"}},
        "walls": [], "gravity": [0, 0],
        "interfaces": [{"name": "wall", "surface": {"polyline": [[0.9, TOP], [0.1, TOP]], "spacing": CELL}}]}
    files["mpm"]["bodies"][0] |= {
        "mesh": {"box": {"low": [0.45, bottom], "high": [0.55, bottom + 0.1], "cells": [4, 4], "type": "quad4"}},
        "velocity": [0, -SPEED],
        "material": {"law": "neo_hookean", "density": 2000, "young_modulus": 1e6, "poisson_ratio": 0.2}}
    files["coupler"]["time"] |= {"end": 0.03, "dt": 1e-3}
    files["coupler"]["output"]["interval"] = 0.01
    files["coupler"]["coupling"]["predictor"] = 2
    return files


class DisplacedStart(IntegrationCase):
    def steps(self, out: str = "out") -> list[dict[str, str]]:
        return read_table(self.folder / out / "steps.csv")

    def test_the_soil_meets_the_beam_where_it_begins(self) -> None:
        self.write_scene(scene())  # inside the beam at the reference
        ended = self.run_launch(code=0)
        self.assert_says(ended.text, 'interfaces of soil start displaced: "wall" by up to 0.0721 m')
        gap = float(re.findall(r"wall: smallest gap to the soil (\S+) m", ended.text)[-1])
        self.assertGreater(gap, 0.9 * GAP)
        self.assertLess(gap, 1.001 * GAP)
        rows, summary = self.steps(), json.loads((self.out / "summary.json").read_text())
        touched = [float(row["time"]) for row in rows if float(row["fy"]) != 0]
        self.assertAlmostEqual(touched[0], gap / SPEED, delta=1.01e-3)  # a step
        self.assertEqual({float(row["soil_work"]) for row in rows if float(row["time"]) < touched[0]}, {0.0})
        self.assertAlmostEqual(float(read_table(self.out / "probes.csv")[0]["structure.A.uy"]), -SAG, delta=1e-4)
        self.assertEqual(summary["messages"]["soil"]["set_start"]["count"], 1)
        self.assertNotIn("set_start", summary["messages"]["structure"])

    def test_a_sag_of_more_than_a_cell_fails_no_step(self) -> None:
        """If the soil stood at the reference until the first step, each dt would fail."""
        self.assertGreater(SAG, CELL)
        self.write_scene(scene(bottom=TOP + 0.005))
        self.run_launch("--set", "coupler.json:/time/end=0.005", code=0)
        self.assertEqual(json.loads((self.out / "summary.json").read_text())["cuts"], 0)

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

    def test_soil_inside_the_beam_is_refused_before_the_first_step(self) -> None:
        self.write_scene(scene(pull=9.81, bottom=TOP))  # none at the reference
        for option in ((), ("--check",)):
            ended = self.run_launch(*option, code=2)
            self.assert_says(ended.text, "inside", '"wall" by up to 0.0721 m', "displaced from their place")
        self.assertFalse((self.out / "steps.csv").exists())


if __name__ == "__main__":
    launch.main()
