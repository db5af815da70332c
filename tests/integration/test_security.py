#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Who can reach the coupler: the sockets that it binds, and keys."""

import os
import re
import socket
import time
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, free_endpoint, meeting

FOREIGN = Path(__file__).resolve().parent / "foreign_structure.py"
NO_KEYS = {"GABION_KEY_FILE": "", "GABION_COUPLER_KEY_FILE": ""}
DEADLINE = 3  # [s] to connect


def listening(pid: int) -> set[tuple[str, int]]:
    """Addresses and ports on which a process listens for TCP, by /proc."""
    inodes = {found.group(1) for entry in Path(f"/proc/{pid}/fd").iterdir()
              if (found := re.match(r"socket:\[(\d+)\]", os.readlink(entry)))}
    result = set()
    for family, table in ((socket.AF_INET, "tcp"), (socket.AF_INET6, "tcp6")):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and fields[9] in inodes:  # 0A: LISTEN
                address, port = fields[1].split(":")
                words = b"".join(bytes.fromhex(address[i:i + 8])[::-1] for i in range(0, len(address), 8))
                result.add((socket.inet_ntop(family, words), int(port, 16)))
    return result


class SecurityCase(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = meeting()
        del self.files["mpm"], self.files["fem"]
        self.files["coupler"]["time"] = {"end": 0.05, "dt": 0.01, "dt_min": 1e-6}
        self.endpoint = free_endpoint()
        self.port = int(self.endpoint.rpartition(":")[2])

    def by_hand(self, *command: object, **environment: str) -> Launch:
        os.environ.update(NO_KEYS | environment)
        started = Launch([str(word) for word in command], self.folder)
        os.environ.update(NO_KEYS)
        self.addCleanup(started.end)
        return started

    def start_coupler(self, *options: object, **protocol: object) -> Launch:
        self.files["coupler"]["protocol"] = {"connect_deadline": DEADLINE} | protocol
        self.write_scene(self.files)
        coupler = self.by_hand(launch.binaries / "coupler", self.scene, "--output", self.out, *options)
        coupler.wait_until(lambda: "coupler.log" in os.listdir(self.out) if self.out.exists() else False, "its log")
        return coupler


class Bound(SecurityCase):
    def ports_of(self, expected_number: int, *options: str, **protocol: object) -> set[tuple[str, int]]:
        coupler = self.start_coupler(*options, **protocol)
        coupler.wait_until(lambda: len(listening(coupler.process.pid)) >= expected_number, "a listening socket")
        time.sleep(0.3)  # for any socket more
        return listening(coupler.process.pid)

    def test_by_default_one_port_of_the_loopback_device(self) -> None:
        found = self.ports_of(1)
        self.assertEqual([address for address, _ in found], ["127.0.0.1"])

    def test_the_endpoint_of_the_settings_and_no_other(self) -> None:
        self.assertEqual(self.ports_of(1, endpoint=self.endpoint), {("127.0.0.1", self.port)})

    def test_the_endpoint_of_the_command_line_and_no_other(self) -> None:
        self.assertEqual(self.ports_of(1, "--coupler", self.endpoint), {("127.0.0.1", self.port)})

    def test_all_addresses_when_asked_for(self) -> None:
        self.assertEqual(self.ports_of(1, "--coupler", f"tcp://0.0.0.0:{self.port}"), {("0.0.0.0", self.port)})

    def test_a_participant_listens_nowhere(self) -> None:
        self.start_coupler("--coupler", self.endpoint)
        soil = self.by_hand(launch.binaries / "fake_participant", "soil", self.endpoint)
        time.sleep(0.5)
        self.assertEqual(listening(soil.process.pid), set())


class Keys(SecurityCase):
    def setUp(self) -> None:
        super().setUp()
        for name in ("coupler", "soil", "structure", "stranger"):
            self.run_program("coupler", "--make-keys", self.key(name), code=0)
        known = self.folder / "known.pub"
        known.write_text("; who may connect\n" + self.key("soil.pub").read_text() + "\n"
                         + self.key("structure.pub").read_text())
        self.security = {"security": {"key_file": str(self.key("coupler")), "clients_file": "../known.pub"}}

    def key(self, name: str) -> Path:
        return self.folder / name

    def keys(self, own: str, coupler: str = "coupler") -> dict[str, str]:
        return {"GABION_KEY_FILE": str(self.key(own)), "GABION_COUPLER_KEY_FILE": str(self.key(f"{coupler}.pub"))}

    def start_soil(self, **environment: str) -> Launch:
        return self.by_hand(launch.binaries / "fake_participant", "soil", self.endpoint, **environment)

    def start_structure(self, **environment: str) -> Launch:
        return self.by_hand("/usr/bin/python3", FOREIGN, "good", "--coupler", self.endpoint, **environment)

    def start_secure(self) -> Launch:
        return self.start_coupler("--coupler", self.endpoint, **self.security)

    def test_a_run_with_keys_completes(self) -> None:
        """The participants are in C++ and in Python."""
        run = [self.start_secure(), self.start_soil(**self.keys("soil")),
               self.start_structure(**self.keys("structure"))]
        for each in run:
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        self.assertIn('"completed": true', (self.out / "summary.json").read_text())

    def refused(self, *words: str, at_once: bool, **environment: str) -> str:
        """Soil and structure come with these keys; both say the words. What the coupler says."""
        coupler = self.start_secure()
        both = [self.start_soil(**environment), self.start_structure(**environment)]
        for each in both:
            ended = each.wait()
            self.assertEqual(ended.code, 4, ended.text)
            self.assert_says(ended.text, "error: ", self.endpoint, *words)
            if at_once:
                self.assertLess(ended.seconds, DEADLINE)
        ended = coupler.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "[cpl] error: ", "did not connect")
        return ended.text

    def test_without_key(self) -> None:
        # It is chance which program closes first, so the reason is not always certain.
        self.refused("takes participants with keys only", at_once=False)

    def test_with_a_key_that_is_not_in_the_list(self) -> None:
        said = self.refused("refused participant", "does not know this participant's key", "clients_file",
                            at_once=True, **self.keys("stranger"))
        public = self.key("stranger.pub").read_text().split()[1]
        self.assert_says(said, "warning: refused a connection from 127.0.0.1", public)

    def test_with_another_couplers_key(self) -> None:
        coupler = self.start_secure()
        both = [self.start_soil(**self.keys("soil", coupler="stranger")),
                self.start_structure(**self.keys("structure", coupler="stranger"))]
        for each in both:
            ended = each.wait()
            self.assertEqual(ended.code, 4, ended.text)
            self.assert_says(ended.text, "error: ", "no answer from a coupler", "is not its public key")
        self.assertEqual(coupler.wait().code, 4)

    def test_keys_for_a_coupler_that_uses_none(self) -> None:
        coupler = self.start_coupler("--coupler", self.endpoint)
        ended = self.start_soil(**self.keys("soil")).wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "error: ", "it uses no keys")
        coupler.end()

    def test_new_keys_are_for_the_owner_and_overwrite_nothing(self) -> None:
        secret, public = self.key("soil"), self.key("soil.pub")
        self.assertEqual(secret.stat().st_mode & 0o777, 0o600)
        self.assertNotEqual(secret.read_text(), self.key("structure").read_text())
        before = secret.read_text(), public.read_text()
        ended = self.run_program("coupler", "--make-keys", secret, code=2)
        self.assert_says(ended.text, "[cpl] error: ", "exists, and is not overwritten")
        public.unlink()
        ended = self.run_program("coupler", "--make-keys", secret, code=2)
        self.assert_says(ended.text, "[cpl] error: ", "cannot be made: File exists")
        self.assertEqual(secret.read_text(), before[0])
        self.assertFalse(public.exists())

    def test_bad_key_files(self) -> None:
        secret = self.key("coupler").read_text()
        settings = self.security["security"]
        self.start_expecting(settings | {"key_file": "nowhere"}, "nowhere", "No such file")
        self.start_expecting({"key_file": settings["key_file"]}, "/protocol/security/clients_file")
        self.start_expecting(settings | {"key_file": ""}, "/protocol/security/key_file", 'found ""')
        self.start_expecting(settings | {"client": "x"}, "/protocol/security/client")
        self.start_expecting(settings | {"key_file": str(self.key("coupler.pub"))}, "found mode", "chmod 600")
        self.start_expecting(settings | {"clients_file": str(self.key("coupler"))}, 'line 1 is not "gabion-public-key')
        self.key("known.pub").write_text("; nobody\n")
        self.start_expecting(settings, "known.pub", "holds no line")
        self.key("coupler").write_text(secret[:-2])
        self.start_expecting(settings, "line 1 is not", "40 characters")
        self.key("coupler").chmod(0o640)
        self.start_expecting(settings, "found mode 640, allowed: 600")

    def start_expecting(self, security: dict[str, str], *words: str) -> None:
        with self.subTest(words):
            self.files["coupler"]["protocol"] = {"security": security}
            self.write_scene(self.files)
            ended = self.run_program("coupler", self.scene, "--output", self.out, code=2)
            self.assert_says(ended.text, "[cpl] error: ", *words)
            secret = self.key("coupler").read_text().split()[1]
            self.assertNotIn(secret[:20], ended.text)

    def test_one_of_two_files(self) -> None:
        only = {"GABION_KEY_FILE": str(self.key("soil"))}
        for started in (self.start_soil(**only), self.start_structure(**only)):
            ended = started.wait()
            self.assertNotEqual(ended.code, 0)
            self.assert_says(ended.text, "error: ", "keys: found only", "neither")


if __name__ == "__main__":
    launch.main()
