#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The factor of safety in the words of scripts/plot --summary and scripts/report."""

import sys
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from plotting.strength import strength_search  # noqa: E402

SEARCH = {"phase": 1, "equilibrium_with": 1.3625, "displacement": 0.00245, "steps": []}


def summary(**search: object) -> dict:
    return {"program": "mpm_solver", "solver": {"strength_reduction": {**SEARCH, **search}}}


class Search(unittest.TestCase):
    def test_failure_has_its_factor_and_bracket(self) -> None:
        text = strength_search(summary(verdict="failure", none_with=1.36875, factor_of_safety=1.365625))
        self.assertEqual(text, "1.366: equilibrium with 1.363, none with 1.369, displacement 0.00245 m")

    def test_no_factor_is_made_up(self) -> None:
        self.assertIn("no failure found: equilibrium still with 1.363", strength_search(summary(verdict="no_failure")))
        gave_up = strength_search(summary(verdict="not_solved", none_with=1.4))
        self.assertIn("none given", gave_up)
        self.assertIn("gave up at 1.4", gave_up)

    def test_runs_without_a_search(self) -> None:
        for other in (None, {}, {"solver": {"basis": "linear"}}, {"solver": "block lu"}):
            self.assertIsNone(strength_search(other))


if __name__ == "__main__":
    unittest.main()
