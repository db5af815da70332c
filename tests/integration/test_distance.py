#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A structure that is far away: behind a wire of 1 and 20 ms, encrypted. The result is the same to the bit, and a
wire that breaks is found."""

import os
import time
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, free_endpoint, meeting, read_table
from relay import Relay

TABLES = ("steps.csv", "iterations.csv", "probes.csv")


def port_of(endpoint: str) -> int:
    return int(endpoint.rpartition(":")[2])


def rows(folder: Path) -> dict[str, list[dict[str, str]]]:
    """All that does not tell the time of day."""
    return {name: [{key: value for key, value in row.items() if "seconds" not in key}
                   for row in read_table(folder / name)] for name in TABLES}


class Distance(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        for name in ("coupler", "soil", "structure"):
            self.run_program("coupler", "--make-keys", self.folder / name, code=0)
        (self.folder / "clients.pub").write_text(
            (self.folder / "soil.pub").read_text() + (self.folder / "structure.pub").read_text())
        self.files = meeting()
        self.protocol = {"security": {"key_file": str(self.folder / "coupler"), "clients_file": "../clients.pub"}}

    def by_hand(self, program: str, endpoint: str, out: Path, *options: str) -> Launch:
        started = Launch([str(launch.binaries / program), str(self.scene), "--output", str(out), "--coupler", endpoint,
                          *options], self.folder)
        self.addCleanup(started.end)
        return started

    def start_all(self, out: Path, delay: float | None) -> tuple[list[Launch], Relay | None]:
        """delay: of the structure's wire [s]; None: it has none."""
        self.files["coupler"]["protocol"] = self.protocol
        self.write_scene(self.files)
        near = free_endpoint()
        far, relay = near, None
        if delay is not None:
            far = free_endpoint()
            relay = Relay(port_of(far), port_of(near), delay)
            self.addCleanup(relay.close)
        key = ("--coupler-key-file", str(self.folder / "coupler.pub"), "--key-file")
        coupler = self.by_hand("coupler", near, out)
        coupler.wait_until(out.exists, "the folder of results")
        return [coupler, self.by_hand("mpm_solver", near, out, *key, str(self.folder / "soil")),
                self.by_hand("fem_solver", far, out, *key, str(self.folder / "structure"))], relay

    def run_all(self, name: str, delay: float | None) -> tuple[dict[str, list[dict[str, str]]], float]:
        """Rows of the tables, and seconds an iteration."""
        out = self.folder / name
        begin = time.monotonic()
        started, relay = self.start_all(out, delay)
        for each in started:
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        if relay is not None:
            self.assertGreater(relay.bytes_passed, 10_000)
        found = rows(out)
        return found, (time.monotonic() - begin) / len(found["iterations.csv"])

    def test_the_result_does_not_know_of_it(self) -> None:
        near, seconds = self.run_all("near", None)
        self.assertGreater(len(near["iterations.csv"]), 30)
        print(f"an iteration with start and end: {1e3 * seconds:.1f} ms near", end="")
        for delay in (1e-3, 20e-3):
            far, seconds = self.run_all(f"far_{delay}", delay)
            self.assertEqual(far, near)
            print(f", {1e3 * seconds:.1f} ms with {1e3 * delay:g} ms each way", end="")
        print()

    def test_a_wire_that_breaks(self) -> None:
        self.files = launch.endless(in_contact=True)
        self.protocol |= {"silence_deadline": 5, "heartbeat": 0.5}
        out = self.folder / "broken"
        (coupler, soil, structure), relay = self.start_all(out, 1e-3)
        coupler.wait_until(lambda: (out / "steps.csv").exists() and len(read_table(out / "steps.csv")) > 3, "steps")
        relay.cut()
        ended = coupler.wait()
        self.assertEqual(ended.code, 4, ended.text)
        # Both sides count to 5 s; the process of whoever is first is gone for the other one.
        self.assertRegex(ended.text, r'\[cpl\] error: participant "structure".*(is silent for|has died)')
        ended = structure.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assertRegex(ended.text, r"the coupler .*(is silent for|has died)")
        self.assertEqual(soil.wait().code, 4)


if __name__ == "__main__":
    os.environ.update({"GABION_KEY_FILE": "", "GABION_COUPLER_KEY_FILE": ""})
    launch.main()
