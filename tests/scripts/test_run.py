#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/run refuses what it cannot do before it installs, builds or starts anything."""

import unittest

from script_case import ScriptCase


class Usage(ScriptCase):
    def expect_refusal(self, *arguments: object, words: str) -> None:
        result = self.script("run", *arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(words, result.stderr)
        self.assertEqual(result.stdout, "")

    def scene(self, *files: str) -> str:
        for file in files:
            self.write(f"scene/{file}", "{}")
        return str(self.folder / "scene")

    def test_help(self) -> None:
        result = self.script("run", "--help")
        self.assertEqual(result.returncode, 0)
        self.assertIn("--ranks mpm=N,fem=N", result.stdout)

    def test_no_scene(self) -> None:
        self.expect_refusal(words="which scene?")

    def test_scene_that_is_not_there(self) -> None:
        self.expect_refusal(self.folder / "nowhere", words="no such scene folder; there are: configs/")

    def test_two_scenes(self) -> None:
        self.expect_refusal("a", "b", words="one scene at a time")

    def test_unknown_option(self) -> None:
        self.expect_refusal("a", "--outptu", words="unknown option --outptu")

    def test_option_without_value(self) -> None:
        for option in ("--output", "--restart"):
            self.expect_refusal("a", option, words=f"{option} needs a value")

    def test_ranks(self) -> None:
        scene = self.scene("mpm.json")
        for found in ("soil=2", "mpm=0", "2", "mpm=2,fem=x"):
            self.expect_refusal(scene, "--ranks", found, words="allowed: mpm=N,fem=N")

    def test_empty_scene(self) -> None:
        self.expect_refusal(self.scene("notes.txt"), words="none of coupler.json, mpm.json, fem.json")

    def test_check_of_a_participant_without_coupler(self) -> None:
        self.expect_refusal(self.scene("mpm.json"), "--check-participant", "soil", words="has no coupler.json")

    def test_both_checks(self) -> None:
        self.expect_refusal(self.scene("coupler.json"), "--check", "--check-participant", "soil", words="one at a time")

    def test_two_solvers_without_coupler(self) -> None:
        self.expect_refusal(self.scene("mpm.json", "fem.json"), words="no coupler.json")


if __name__ == "__main__":
    unittest.main()
