#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Participants that do not fit the coupler are refused, with both values named."""

import launch
from launch import IntegrationCase, Launch, free_endpoint, meeting


class Handshake(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        files = meeting()
        files["coupler"]["protocol"] = {"connect_deadline": 50}  # who is refused is so at once: nobody waits in vain
        self.write_scene(files)

    def with_fake(self, version: str) -> tuple[str, str]:
        """Text of a coupler without solvers, and its answer to a foreign participant of this version."""
        endpoint = free_endpoint()
        coupler = self.start("--coupler", endpoint, programs=("coupler",))  # the soil does not come
        fake = Launch([str(launch.binaries / "fake_participant"), "structure", endpoint, "--version", version,
                       "--connect-deadline", "50"], self.folder)
        self.addCleanup(fake.end)
        fake.wait_until(lambda: "welcome" in fake.text() or fake.process.poll() is not None, "an answer")
        if "welcome" not in fake.text():
            coupler.wait_until(lambda: "was refused" in coupler.text(), "the coupler said so")
        coupler.end()
        return coupler.text(), fake.text()

    def test_another_major_version_is_refused(self) -> None:
        said, answer = self.with_fake("2.0")
        words = ("structure", "was refused", "protocol version: coupler 1.4, participant 2.0")
        self.assert_says(said, "[cpl] error: ", *words)
        self.assert_says((self.out / "coupler.log").read_text(), *words)
        self.assert_says(answer, "refused", "protocol version: coupler 1.4, participant 2.0")

    def test_another_minor_version_is_welcome(self) -> None:
        """Another minor version is accepted: the test above was refused for its major version."""
        _, answer = self.with_fake("1.7")
        self.assert_says(answer, "welcome")

    def test_another_scene_is_refused(self) -> None:
        setting = {"fem_solver": ["--set", "fem.json:/material/young_modulus=2e6"]}
        ended = self.run_launch(code=4, own=setting)
        words = ('participant "structure"', "was refused", "scene hash", "coupler ", "participant ")
        self.assert_says(ended.text, "[cpl] error: ", *words)
        self.assert_says((self.out / "coupler.log").read_text(), *words)
        self.assertEqual(ended.text.count("error: "), 1, ended.text)  # both solvers know it, and have the same terminal

    def test_the_same_name_twice_is_refused(self) -> None:
        ended = self.run_launch(code=4, own={"fem_solver": ["--name", "soil"]})
        self.assert_says(ended.text, "[cpl] error: ", "was refused", '"soil"')

    def test_unknown_name_is_refused(self) -> None:
        ended = self.run_launch(code=4, own={"fem_solver": ["--name", "fence"]})
        self.assert_says(ended.text, "[cpl] error: ", "was refused", "participant name", "fence", "structure")


if __name__ == "__main__":
    launch.main()
