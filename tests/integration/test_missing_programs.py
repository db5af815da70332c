#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A program that is started without the others says who is missing, and ends."""

import json

import launch
from launch import IntegrationCase, meeting

DEADLINE = 1.5  # [s] protocol/connect_deadline of these scenes


class MissingPrograms(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        files = meeting()
        files["coupler"]["protocol"] = {"connect_deadline": DEADLINE}
        self.write_scene(files)

    def test_coupler_alone(self) -> None:
        ended = self.run_program("coupler", self.scene, "--output", self.out, code=4)
        self.assertGreater(ended.seconds, DEADLINE)
        words = ("error: ", '"soil"', '"structure"', "did not connect", "connect_deadline in coupler.json")
        self.assert_says(ended.text, *words)
        self.assert_says((self.out / "coupler.log").read_text(), *words)

    def test_coupler_and_one_solver(self) -> None:
        for present, missing in (("mpm_solver", "structure"), ("fem_solver", "soil")):
            with self.subTest(present):
                ended = self.run_launch(code=4, programs=("coupler", present))
                self.assert_says(ended.text, "[cpl] error: ", f'"{missing}"', "did not connect")
                self.assertNotIn("interrupted", ended.text)

    def test_solver_alone_on_a_coupled_scene(self) -> None:
        for program, prefix in (("mpm_solver", "mpm"), ("fem_solver", "fem")):
            with self.subTest(program):
                ended = self.run_program(program, self.scene, "--output", self.out, code=2)
                self.assert_says(ended.text, f"[{prefix}] error: ", "coupler.json", "--coupler tcp://host:port")
                self.assertFalse(self.out.exists())

    def test_both_solvers_without_coupler(self) -> None:
        ended = self.run_launch(code=2, programs=("mpm_solver", "fem_solver"))
        self.assert_says(ended.text, "error: ", "a coupler has to be part of the launch")

    def test_no_coupler_at_that_address(self) -> None:
        endpoint = "tcp://127.0.0.1:9"  # nobody listens on the discard port
        ended = self.run_program("fem_solver", self.scene, "--output", self.out, "--coupler", endpoint,
                                 "--connect-deadline", DEADLINE, code=4)
        self.assert_says(ended.text, "[fem] error: ", '"structure"', "no answer", endpoint, "--connect-deadline")
        self.assertGreater(ended.seconds, DEADLINE)


if __name__ == "__main__":
    launch.main()
