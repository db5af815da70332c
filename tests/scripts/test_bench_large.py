#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The studies of scripts/bench on large soil, in space and on ranks, with made-up runs."""

import contextlib
import csv
import io
import json
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
from script_case import ROOT, ScriptCase

import made_up_results as made_up
from plotting.results import Results
from studies import ranks, run_out_3d, size
from studies.measures import Measured
from studies.runner import Runner


class MadeUpCylinder(Runner):
    """Cylinders of sand that stay as they are."""

    def run(self, label: str, scene: str, settings: list[str]) -> Measured:
        mesh = json.loads(next(text for text in settings if "bodies/0/mesh" in text).partition("=")[2])["file"]
        self.cubes = Path(mesh).read_text().split("$Elements\n")[1].splitlines()[1].split()[3]
        ratio = float(label.split("_")[1]) if label.startswith("a_") else run_out_3d.CHANGED
        cells = int(label.split("_")[3 if label.startswith("a_") else 1]) if "cells" in label else 10
        cylinder = run_out_3d.Cylinder(ratio, cells)
        middles = cylinder.edge * (np.indices((2 * cells, 2 * cells, cylinder.layers)).reshape(3, -1).T + 0.5)
        points = middles[np.hypot(middles[:, 0], middles[:, 1]) < run_out_3d.RADIUS]
        assert self.cubes == str(len(points)), "the mesh is another one"
        made_up.write_series(self.folder / label / "mpm", "soil", [(0.0, points, None, {}), (1.0, points, None, {})])
        summary = {"completed": True, "steps": 10, "newton_iterations": 45, "cuts": 0, "cpu_seconds": 2.5,
                   "solver": {"points": len(points)}}
        (self.folder / label / "summary.json").write_text(json.dumps(summary))
        return Measured(Results(self.folder / label))


class RunOut(ScriptCase):
    def test_a_cylinder_that_stays_has_its_own_size(self) -> None:
        with contextlib.redirect_stdout(io.StringIO()):
            run_out_3d.run_out_3d(MadeUpCylinder(self.folder, reuse=False, settings=[]))
        rows = []
        for cells, ratios in run_out_3d.RATIOS.items():
            of_cells = list(csv.reader((self.folder / f"{cells} cells a radius.csv").read_text().splitlines()))[1:]
            self.assertEqual([float(row[0]) for row in of_cells], list(ratios))
            rows += of_cells
        changed = list(csv.reader((self.folder / "a = 0.9, one thing changed.csv").read_text().splitlines()))[1:]
        self.assertEqual([row[0] for row in changed], list(run_out_3d.FACTORS))
        for row in rows:
            self.assertAlmostEqual(float(row[2]), 0, delta=0.03, msg="run-out: a third of a cube's edge")
            self.assertAlmostEqual(float(row[7]), float(row[0]), delta=0.01, msg="height")

    def test_fronts_of_a_circle_and_single_grains(self) -> None:
        angle = np.linspace(0.001, np.pi / 2 - 0.001, 2000)
        r = np.linspace(0.0, 0.3, 120)
        x, y = np.outer(r, np.cos(angle)).ravel(), np.outer(r, np.sin(angle)).ravel()
        x, y = np.append(x, 0.5), np.append(y, 0.01)  # one far away
        np.testing.assert_allclose(run_out_3d.fronts(x, y, 0.005, 0.1), 0.3025, rtol=1e-9)

    def test_volume_under_a_cone_and_a_drum(self) -> None:
        r = np.array([0.1, 0.35, 0.9, 1.0])
        self.assertAlmostEqual(run_out_3d.volume_under(r, 1 - r), np.pi / 3 - np.pi * 0.01 * 0.1 / 3)
        self.assertAlmostEqual(run_out_3d.volume_under(r, np.full(4, 2.0)), 2 * np.pi)

    def test_laws(self) -> None:
        np.testing.assert_allclose([run_out_3d.run_out_law(a) for a in (0.5, 1.5, 4)], [0.62, 1.86, 3.2])
        self.assertEqual([run_out_3d.height_law(a) for a in (0.5, 3)], [0.5, 0.74])
        # A cone of that height has the volume of the cylinder.
        self.assertAlmostEqual((1 + run_out_3d.cone_law(2)) ** 2 * 0.74 / 3, 2)

    def test_the_scene_is_one_of_the_study(self) -> None:
        scene = json.loads((ROOT / "configs" / run_out_3d.SCENE / "mpm.json").read_text())
        settings = dict(text.removeprefix("mpm.json:/").split("=", 1)
                        for text in run_out_3d.Cylinder(0.9).settings("cylinder.msh"))
        self.assertEqual(scene["grid"], json.loads(settings["grid"]))
        self.assertEqual(scene["bodies"][0]["mesh"], json.loads(settings["bodies/0/mesh"]))
        for key, value in scene["time"].items():
            self.assertEqual(value, json.loads(settings[f"time/{key}"]), key)


class Ranks(ScriptCase):
    ONE = ranks.Count(points=1000, steps=10, newton=40, linear=400, seconds=8.0, memory=1e9)
    EIGHT = replace(ONE, seconds=2.0, memory=0.25e9, share=1.2, neighbours=7, messages=4000, message_bytes=8e6,
                    collectives=2000, waiting=0.25)

    def test_counts_are_read(self) -> None:
        made_up.write_table(self.folder / "steps.csv", ["step", "wall_seconds"], [[1, 0.5], [2, 1.5]])
        soil = {"points": 1000, "newton_iterations": 8, "linear_iterations": 80,
                "peak_memory": {"largest_rank": 5, "all_ranks": 9}}
        (self.folder / "summary.json").write_text(json.dumps({"cpu_seconds": 0.5, "solver": soil}))
        self.assertEqual(ranks.count_of(self.folder), ranks.Count(1000, 2, 8, 80, 2.0, 5, 0.5))
        self.assertEqual(ranks.count_of(self.folder).computing, 0.5 / 8)
        soil["ranks"] = {"number": 2, "largest_share": 1.1, "neighbours": 1}
        soil["mpi"] = {"messages": {"largest_rank": 30, "all_ranks": 50},
                       "message_bytes": {"largest_rank": 7, "all_ranks": 9},
                       "collectives": {"largest_rank": 3, "all_ranks": 6},
                       "waiting_seconds": {"largest_rank": 1, "all_ranks": 1}}
        (self.folder / "summary.json").write_text(json.dumps({"cpu_seconds": 0.5, "solver": soil}))
        self.assertEqual(ranks.count_of(self.folder), ranks.Count(1000, 2, 8, 80, 2.0, 5, 0.5, 1.1, 1, 30, 7, 3, 0.25))

    def test_a_row(self) -> None:
        self.assertEqual(ranks.row(8, self.EIGHT, self.ONE),
                         [8, 4, 4, 10, 0.25, 1.2, 7, 100, 400, 200, 800, 50, "25 %"])

    def test_the_model_gives_back_what_was_counted(self) -> None:
        parts = ranks.modelled(self.ONE, self.EIGHT, (8, 8), 3, 1)
        np.testing.assert_allclose(parts,
                                   [0.2 / 8 * 1.2, 100 * ranks.LATENCY, 2e5 / ranks.BANDWIDTH, 50 * 3 * ranks.LATENCY])

    def test_the_model_grows_like_surface_and_volume(self) -> None:
        few = ranks.modelled(self.ONE, self.EIGHT, (8, 64), 3, 8)
        self.assertAlmostEqual(few[0], 0.2 / 8 * 1.2)  # as many points a rank
        self.assertAlmostEqual(few[1], 100 * 26 / 7 * ranks.LATENCY)
        self.assertAlmostEqual(few[2], 2e5 * 1.5 / ranks.BANDWIDTH)  # 4.5 shared sides of a part instead of 3
        self.assertAlmostEqual(few[3], 50 * 6 * ranks.LATENCY)
        eighth = ranks.modelled(self.ONE, self.EIGHT, (8, 64), 3, 1)
        self.assertAlmostEqual(eighth[2] / few[2], 0.25)  # an eighth of the volume has a quarter of the surface

    def test_sizes_are_those_asked_for(self) -> None:
        for name, soil in ranks.SOILS.items():
            settings = ranks.settings_of(soil, 1.0)
            body = settings["bodies"][0]
            points = np.prod(body["mesh"]["box"]["cells"]) * body["points_per_cell"]
            self.assertEqual(f"{points:,} points", name.partition(", ")[2])


class Size(ScriptCase):
    def test_memory_of_what_a_larger_run_has_more(self) -> None:
        def summary(points: int, each: float) -> dict:
            memory = {field: 1e6 + points * each * (k + 1) for k, field in enumerate(size.FIELDS)}
            peak = 5e7 + sum(memory.values()) + 100 * points
            return {"solver": {"points": points, "memory": memory, "peak_memory": {"largest_rank": peak}}}

        name, points, *fields, other, total, wanted = size.memory_row("tri3", summary(5000, 10), summary(1000, 10))
        self.assertEqual((name, points, wanted), ("tri3", 5000, 0.6))
        np.testing.assert_allclose(fields, [0.01 * (k + 1) for k in range(len(size.FIELDS))])
        self.assertAlmostEqual(other, 0.1)
        self.assertAlmostEqual(total, 0.28 + 0.1)

    def test_every_form_has_a_goal(self) -> None:
        self.assertEqual(set(size.SIZES), set(size.WANTED))


if __name__ == "__main__":
    unittest.main()
