#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scenes of configs/ that are run, for a moment."""

import json
from pathlib import Path

import launch
from launch import IntegrationCase, read_table

CONFIGS = Path(__file__).resolve().parent.parent.parent / "configs"


class Laid(IntegrationCase):
    """A scene whose soil is laid against the structure."""

    def expect_balance(self, point: str, error: float) -> None:
        """The contact pushes from the first moment, with equal work on both sides and out of nothing."""
        rows = [{name: float(value) for name, value in row.items() if name != "status" and name != "skipped"}
                for row in read_table(self.out / "steps.csv")]
        impulse = sum(row["fx"] * row["dt"] for row in rows)
        self.assertGreaterEqual(min(row["fx"] for row in rows), 0)  # contact never pulls
        self.assertGreater(impulse, 0)
        work = sum(row["structure_work"] for row in rows)
        self.assertGreater(work, 0)
        self.assertLess(abs(sum(row["work_sum"] for row in rows)), error * work)
        end = {name: float(value) for name, value in read_table(self.out / "probes.csv")[-1].items()}
        self.assertGreater(end[f"structure.{point}.ux"], 0)
        self.assertLess(abs(end["soil.momentum_error_x"]), 1e-5 * impulse)
        self.assertLess(end["soil.created_energy"], 1e-5 * end["soil.gravity_work"])


class FlexibleGate(Laid):
    """Soil that is laid against a structure pushes from the first moment, without a cut and out of nothing."""

    def test_first_moment(self) -> None:
        self.scene = CONFIGS / "flexible_gate"
        self.run_launch("--set", "coupler.json:/time/end=0.06", code=0)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["steps_in_contact"], summary["cuts"]), (60, 60, 0))
        self.expect_balance("foot", 1e-5)


class Fluids(Laid):
    """Fluids that begin beside a structure, as after their flow to it, push on it from the first moment."""

    def expect_push(self, name: str, box: dict, end: float, point: str, error: float = 1e-4) -> None:
        self.scene = CONFIGS / name
        mesh = {"box": {**box, "type": "quad4"}}
        self.run_launch("--set", f"coupler.json:/time/end={end}",
                        "--set", f"mpm.json:/bodies/0/mesh={json.dumps(mesh)}", code=0)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["steps_in_contact"]), (40, 40))
        self.expect_balance(point, error)

    def test_dam_break(self) -> None:
        water = {"low": [0.146, 0], "high": [0.292, 0.073], "cells": [30, 15]}
        self.expect_push("dam_break_elastic_wall", water, 0.02, "tip")

    def test_mud_on_barrier(self) -> None:
        mud = {"low": [1.2, 0], "high": [1.5, 0.1], "cells": [30, 10]}
        self.expect_push("mud_on_barrier", mud, 0.04, "crest")

    def test_debris_flow(self) -> None:
        """The push with and without pore pressure, with the tolerance of these scenes, 1e-3 of the force."""
        soil = {"low": [12, 0], "high": [14, 1], "cells": [8, 4]}
        impulses = []
        for name in ("debris_flow_barrier", "debris_flow_barrier_drained"):
            self.out = self.folder / name
            self.expect_push(name, soil, 0.1, "crest", 2e-3)
            impulses.append(sum(float(row["fx"]) * float(row["dt"]) for row in read_table(self.out / "steps.csv")))
        self.assertGreater(impulses[0], 1.5 * impulses[1])


class RingNet(Laid):
    """A net whose ropes draw in its posts before soil that is laid against it pushes."""

    def test_first_moment(self) -> None:
        self.scene = CONFIGS / "ring_net"
        mesh = {"box": {"low": [0.4, 0, 0], "high": [1, 0.8, 0.4], "cells": [6, 8, 4], "type": "hex8"}}
        self.run_launch("--set", "coupler.json:/time/end=0.02",
                        "--set", f"mpm.json:/bodies/0/mesh={json.dumps(mesh)}", code=0)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["steps_in_contact"], summary["cuts"]), (20, 20, 0))
        self.expect_balance("post", 1e-3)
        start = {name: float(value) for name, value in read_table(self.out / "probes.csv")[0].items()}
        self.assertAlmostEqual(start["structure.post.uy"], 0.31e-3, delta=0.02e-3)  # 0.30 mm by OpenSees
        self.assertAlmostEqual(start["structure.post.ux"], 0, delta=1e-7)
        self.assertLess(start["structure.axial_max_top_rope"], 1)


class SensitiveClay(IntegrationCase):
    """The bank rests on what holds it, and fails as soon as that is gone; the lost support takes no energy along."""

    def test_release(self) -> None:
        self.scene = CONFIGS / "sensitive_clay"
        self.run_launch("--set", "coupler.json:/time/end=0.4", "--set", "coupler.json:/output/interval=0.1", code=0)
        rows = [{name: float(value) for name, value in row.items()} for row in read_table(self.out / "probes.csv")]
        energies = {round(row["time"], 6): row["soil.kinetic_energy"] for row in rows}
        weight = rows[-1]["soil.mass"] * 9.81
        self.assertLess(energies[0.1], 1e-6 * weight)  # as if all of it had fallen by a thousandth of a millimetre
        self.assertGreater(energies[0.4], 100 * energies[0.1])
        self.assertGreater(rows[-1]["soil.plastic_dissipation"], 0.1 * rows[-1]["soil.gravity_work"])
        self.assertLess(rows[-1]["soil.created_energy"], 1e-5 * rows[-1]["soil.gravity_work"])


if __name__ == "__main__":
    launch.main()
