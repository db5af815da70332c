#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scenes of configs/ that are run, for a moment."""

import json
from pathlib import Path

import launch
from launch import IntegrationCase, read_table

CONFIGS = Path(__file__).resolve().parent.parent.parent / "configs"


class FlexibleGate(IntegrationCase):
    """Soil that is laid against a structure pushes from the first moment, without a cut and out of nothing."""

    def test_first_moment(self) -> None:
        self.scene = CONFIGS / "flexible_gate"
        self.run_launch("--set", "coupler.json:/time/end=0.06", code=0)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["steps_in_contact"], summary["cuts"]), (60, 60, 0))
        rows = [{name: float(value) for name, value in row.items() if name != "status" and name != "skipped"}
                for row in read_table(self.out / "steps.csv")]
        impulse = sum(row["fx"] * row["dt"] for row in rows)
        self.assertGreaterEqual(min(row["fx"] for row in rows), 0)  # contact never pulls
        self.assertGreater(impulse, 0)
        work = sum(row["structure_work"] for row in rows)
        self.assertGreater(work, 0)
        self.assertLess(abs(sum(row["work_sum"] for row in rows)), 1e-5 * work)
        end = {name: float(value) for name, value in read_table(self.out / "probes.csv")[-1].items()}
        self.assertGreater(end["structure.foot.ux"], 0)
        self.assertLess(abs(end["soil.momentum_error_x"]), 1e-5 * impulse)
        self.assertLess(end["soil.created_energy"], 1e-5 * end["soil.gravity_work"])


if __name__ == "__main__":
    launch.main()
