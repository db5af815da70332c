#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A wall whose wet cells fail: its facets leave, those behind them are wet, and soil goes through the gap."""

import json

import h5py
import launch
import numpy as np
import restart_rows
from launch import IntegrationCase, meeting, read_table

TOP, THICK = 0.4, 0.05  # [m] of a beam between two supports
SPEED, MASS = 6.0, 20.0  # [m/s, kg] of a block that falls on its middle


def scene(dim: int = 2) -> dict[str, dict]:
    """A block that breaks a beam of two layers of cells; nothing has weight."""
    wide = [] if dim == 2 else [0.1]
    mesh = {"box": {"low": [0.0, *([0.0] * len(wide)), TOP - THICK], "high": [1.0, *wide, TOP],
                    "cells": [20, *([2] * len(wide)), 2], "type": "quad4" if dim == 2 else "hex8"}}
    down = [0.0] * (dim - 1) + [-SPEED]
    files = meeting()
    files["fem"] = {
        "dimension": dim, "mesh": mesh, "mass": "lumped",
        "material": {"law": "von_mises", "density": 1000, "young_modulus": 5e6, "poisson_ratio": 0.3,
                     "yield_stress": 2e4, "hardening_modulus": 1e5, "failure_plastic_strain": 0.2},
        "supports": [{"group": "left"}, {"group": "right"}],
        "interfaces": [{"name": "wall", "groups": ["top"], "behind": ["all"]}]}
    soil = {"low": [0.45, *([0.0] * len(wide)), TOP + 0.01], "high": [0.55, *wide, TOP + 0.11],
            "cells": [4, *([4] * len(wide)), 4], "type": "quad4" if dim == 2 else "hex8"}
    files["mpm"] = {
        "dimension": dim, "gravity": [0] * dim,
        "grid": {"box": {"low": [0.0, *([0.0] * len(wide)), -0.4], "high": [1.0, *wide, 0.6],
                         "cells": [20, *([2] * len(wide)), 20], "type": "quad4" if dim == 2 else "hex8"}},
        "bodies": [{"name": "soil", "mesh": {"box": soil}, "points_per_cell": 4 if dim == 2 else 8, "velocity": down,
                    "material": {"law": "neo_hookean", "density": 2000, "young_modulus": 1e6, "poisson_ratio": 0.2}}],
        "interfaces": [{"name": "wall", "surface": {"mesh": mesh, "groups": ["top"], "behind": ["all"]}}]}
    files["coupler"]["time"] |= {"end": 0.06, "dt": 5e-4}
    files["coupler"]["output"]["interval"] = 0.01
    files["coupler"]["coupling"]["predictor"] = 1
    return files


def column(table: list[dict[str, str]], name: str) -> np.ndarray:
    return np.array([float(row[name]) for row in table])


class BreakingWall(IntegrationCase):
    def run_scene(self, *options: str, dim: int = 2, code: int = 0, **how) -> str:
        self.write_scene(scene(dim))
        return self.run_launch(*options, code=code, **how).text

    def expect_no_gain(self, dim: int) -> None:
        """Energy of soil, contact and structure never exceeds that of the throw; momentum closes."""
        probes = read_table(self.out / "probes.csv")
        names = ("soil.kinetic_energy", "soil.elastic_energy", "soil.contact_energy", "structure.kinetic_energy",
                 "structure.elastic_energy")
        energy = sum(column(probes, name) for name in names)
        self.assertLess(np.max(energy - np.minimum.accumulate(energy)), 1e-3 * energy[0])
        spent = sum(column(probes, f"structure.{name}")
                    for name in ("kinetic_energy", "elastic_energy", "plastic_work", "failed_energy"))
        imbalance = spent - column(probes, "structure.external_work")
        self.assertLess(np.max(np.abs(imbalance)), 2e-2 * energy[0])
        for axis in "xyz"[:dim]:
            error = column(probes, f"soil.momentum_error_{axis}")
            self.assertLess(np.max(np.abs(error)), 1e-6 * MASS * SPEED)

    def frames(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Facets and their vertices in the frames of the contact."""
        found = []
        for path in sorted((self.out / "mpm").glob("contact_wall_*.h5")):
            with h5py.File(path) as data:
                found.append((data["connectivity"][()], data["coordinates"][()]))
        return found

    def expect_breach(self, dim: int) -> None:
        """Cells of both layers failed, and the block is below the beam."""
        frames = self.frames()
        self.assertGreater(len({len(facets) for facets, _ in frames}), 1)
        with h5py.File(sorted((self.out / "mpm").glob("soil_*.h5"))[-1]) as data:
            height = data["coordinates"][()][:, dim - 1]
        self.assertLess(np.mean(height), TOP - 2 * THICK)
        self.assertGreater(column(read_table(self.out / "steps.csv"), "structure.failed_cells")[-1], 2)

    def test_a_block_goes_through_a_beam(self) -> None:
        text = self.run_scene()
        self.assertNotIn("they stay in the wet surface", text)
        self.expect_no_gain(2)
        self.expect_breach(2)

    def test_in_space_on_two_ranks_of_the_soil(self) -> None:
        self.run_scene("--set", "coupler.json:/time/end=0.03", dim=3, ranks={"mpm_solver": 2})
        self.expect_no_gain(3)
        self.assertGreater(len({len(facets) for facets, _ in self.frames()}), 1)

    def test_a_restart_gives_the_same_rows(self) -> None:
        """From right after the step in which the first facets left."""
        self.write_scene(scene())
        straight, first, second = (self.folder / name for name in ("straight", "first", "second"))
        self.out = straight
        self.run_launch("--set", "coupler.json:/time/end=0.02", code=0)
        failed = [int(float(row["structure.failed_cells"])) for row in read_table(straight / "steps.csv")]
        steps = next(k for k, count in enumerate(failed) if count) + 3  # the stress fades over three steps
        self.out = first
        self.run_launch("--set", f"coupler.json:/time/end={5e-4 * steps}", code=0)
        messages = json.loads((first / "summary.json").read_text())["messages"]
        self.assertEqual(messages["soil"]["set_facets"]["count"], 1)
        self.out = second
        self.run_launch("--restart", str(first), "--set", "coupler.json:/time/end=0.02", code=0)
        for table in ("steps.csv", "probes.csv"):
            old, new = (restart_rows.rows_without_seconds(out / table) for out in (straight, second))
            self.assertEqual(len(new) - 1, 40 - steps)
            self.assertEqual(new[1:], old[1 - len(new):])

    def test_what_cannot_change_is_refused(self) -> None:
        files = scene()
        del files["mpm"]["interfaces"][0]["surface"]["behind"]
        self.write_scene(files)
        self.assert_says(self.run_launch(code=2).text, 'interface "wall"', '"soil" has other vertices', '"behind"',
                         "mpm.json", "fem.json")
        files = scene()
        del files["fem"]["interfaces"][0]["behind"]
        self.write_scene(files)
        self.assert_says(self.run_launch(code=2).text, 'interface "wall"', "42 vertices of the soil's side and 0 of",
                         'equal "behind" in the surface of mpm.json and in the interface of fem.json')
        self.write_scene(scene())
        self.assert_says(self.run_launch(code=2, ranks={"fem_solver": 2}).text, "/interfaces/0/behind", "several ranks")
        files = scene()
        files["mpm"]["boulders"] = [{"name": "rock", "shape": {"radius": 0.1}, "density": 2000, "centre": [0.2, 0.0]}]
        self.write_scene(files)
        self.assert_says(self.run_launch(code=2).text, '"soil" cannot take other facets', "without boulders")


if __name__ == "__main__":
    launch.main()
