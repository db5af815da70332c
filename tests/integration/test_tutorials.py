#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The files of docs/first_scene.md and docs/first_structure.md, from their text alone, run to the end; what
comes out is what the pages print."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, free_endpoint

ROOT = Path(__file__).resolve().parent.parent.parent
# A name in bold, and below it the whole file.
FILE = re.compile(r"^\*\*(\S+)\*\*\n\n```(json|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# An impact amplifies round-off: other machines give other digits of what the pages show.
SHARE = 0.1
NUMBERS = re.compile(r"structure\.(\w+)\.ux: largest ([\d.]+) mm at t = [\d.]+ s, at the end ([\d.]+) mm\n"
                     r" *horizontal force on the structure: largest ([\d.]+) N/m at t = [\d.]+ s, "
                      r"impulse ([\d.]+) N s/m")


def files_of(page: str) -> dict[str, str]:
    """Path -> text of every file that a page shows in full."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    found = {path: content for path, _, content in FILE.findall(text)}
    assert len(found) == text.count("```") // 2, f"{page}: found {list(found)}, and a block without its name"
    return found


class TutorialCase(IntegrationCase):
    def write_files(self, page: str) -> None:
        for path, text in files_of(page).items():
            file = self.folder / path
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")

    def expect_as_shown(self, page: str, probe: str, out: Path) -> None:
        """The run came to its end with the numbers of the page."""
        shown = {found[0]: found[1:] for found in NUMBERS.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))}
        said = subprocess.run([ROOT / "scripts" / "plot", out, "--summary"], check=True, capture_output=True, text=True)
        found = {each[0]: each[1:] for each in NUMBERS.findall(said.stdout)}
        self.assertIn(probe, found, said.stdout)
        names = ("largest displacement", "displacement at the end", "largest force", "impulse")
        for name, value, expected in zip(names, found[probe], shown[probe]):
            self.assertLess(abs(float(value) / float(expected) - 1), SHARE, f"{name}: {value}, on the page {expected}")


class FirstScene(TutorialCase):
    def setUp(self) -> None:
        super().setUp()
        self.write_files("first_scene.md")
        self.scene = self.folder / "my_scene"

    def test_check_says_what_the_page_shows(self) -> None:
        shown = self.run_launch("--check", code=0).text
        lines = re.findall(r"^    \[cpl\] (.+)$", (ROOT / "docs" / "first_scene.md").read_text(), re.MULTILINE)
        self.assertGreater(len(lines), 4)
        for line in lines:
            line = re.sub(r"farthest .*|^my_scene", "", line)  # round-off; a path
            self.assertIn(line, shown)

    def test_by_hand(self) -> None:
        """The commands of running.md as they stand there, on the scene of the page, to its end."""
        block = re.search(r"^    export OMP.*?(?=\n\n)", (ROOT / "docs" / "running.md").read_text(),
                          re.MULTILINE | re.DOTALL)
        (self.folder / "build" / "release").mkdir(parents=True)
        (self.folder / "build" / "release" / "bin").symlink_to(launch.binaries)
        os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        run = Launch(["/bin/bash", "-e", "-c", block[0]], self.folder, self.folder)
        self.addCleanup(run.end)
        ended = run.wait()
        self.assertEqual(ended.code, 0, ended.text)
        self.expect_as_shown("first_scene.md", "top", self.folder / "results" / "by_hand")


class FirstStructure(TutorialCase):
    """The plate that scripts/new-structure writes by the page's command, then the page's hinge."""

    def setUp(self) -> None:
        super().setUp()
        self.write_files("first_scene.md")
        self.page = (ROOT / "docs" / "first_structure.md").read_text(encoding="utf-8")
        command = re.search(r"^    (scripts/new-structure .*)$", self.page, re.MULTILINE)[1].split()
        subprocess.run([ROOT / command[0], *command[1:]], cwd=self.folder, check=True, stdout=subprocess.DEVNULL)
        self.scene = self.folder / "my_wall"
        shutil.copy(self.folder / "my_scene" / "mpm.json", self.scene)
        self.endpoint = free_endpoint()

    def start_structure(self) -> Launch:
        command = json.loads((self.scene / "coupler.json").read_text())["participants"]["structure"]["command"]
        self.assertEqual(command, ["/usr/bin/python3", "structure.py"])
        os.environ["PYTHONPATH"] = str(ROOT / "protocol" / "python")
        started = Launch([command[0], str(self.scene / command[1]), "--coupler", self.endpoint], self.folder)
        self.addCleanup(started.end)
        return started

    def check_alone(self) -> None:
        coupler = Launch([str(launch.binaries / "coupler"), str(self.scene), "--output", str(self.out),
                          "--check-participant", "structure", "--coupler", self.endpoint], self.folder)
        self.addCleanup(coupler.end)
        self.start_structure()
        ended = coupler.wait()
        self.assertEqual(ended.code, 0, ended.text)
        for check in re.findall(r"^    (\S.*?)  +passed$", self.page, re.MULTILINE):
            self.assert_says(ended.text, check, "passed")

    def run_with_soil(self) -> None:
        run = self.start("--coupler", self.endpoint, programs=("coupler",))
        soil = self.start("--coupler", self.endpoint, programs=("mpm_solver",))
        for each in (self.start_structure(), run, soil):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)

    def test_the_files_of_the_page(self) -> None:
        named = re.findall(r"^\| `(\S+)` \|", self.page, re.MULTILINE)
        self.assertEqual({path.name for path in self.scene.iterdir()}, {*named, "mpm.json"})

    def test_plate(self) -> None:
        self.check_alone()
        self.run_with_soil()
        self.expect_as_shown("first_structure.md", "plate", self.out)

    def test_hinge(self) -> None:
        self.write_files("first_structure.md")
        self.check_alone()
        self.run_with_soil()
        self.expect_as_shown("first_structure.md", "top", self.out)


if __name__ == "__main__":
    launch.main()
