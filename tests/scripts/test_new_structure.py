#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/new-structure: what it writes and what it refuses. tests/participant/test_new_structure.py runs it."""

import json
import os
import re
import subprocess
import unittest

from script_case import ROOT, ScriptCase

FILES = {"python": {"model.py", "structure.py", "test_model.py"},
         "cpp": {"CMakeLists.txt", "model.cpp", "model.hpp", "structure.cpp", "test_model.cpp"},
         "c": {"CMakeLists.txt", "model.c", "model.h", "structure.c", "test_model.c"}}


class NewStructure(ScriptCase):
    def new(self, *arguments: object) -> subprocess.CompletedProcess:
        return self.script("new-structure", *arguments)

    def refused(self, *arguments: object) -> str:
        done = self.new(*arguments)
        self.assertEqual(done.returncode, 2, done.stdout)
        return done.stderr

    def test_files_without_placeholders(self) -> None:
        for language, files in FILES.items():
            with self.subTest(language):
                folder = self.folder / language
                done = self.new("gate", "--language", language, folder)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(f"scripts/run {folder} --check-participant gate", done.stdout)
                self.assertEqual({path.name for path in folder.iterdir()}, files | {"README.md", "coupler.json"})
                for path in folder.iterdir():
                    self.assertEqual(re.findall("__[A-Z]+__", path.read_text()), [], path)
                scene = json.loads((folder / "coupler.json").read_text())
                self.assertEqual(set(scene["participants"]), {"soil", "gate"})
                self.assertEqual(scene["interfaces"][0]["structure"], "gate")
                self.assertLessEqual((folder / "README.md").read_text().count("\n"), 60)

    def test_its_own_test(self) -> None:
        """The test passes as written, in both dimensions, and fails for another model."""
        environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
        for dimension in (2, 3):
            folder = self.folder / str(dimension)
            self.assertEqual(self.new("gate", folder, "--language", "python", "--dimension", dimension).returncode, 0)
            command = ["/usr/bin/python3", folder / "test_model.py"]
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
            self.assertEqual(done.returncode, 0, done.stderr)
            model = folder / "model.py"
            text = model.read_text()
            self.assertIn("MASS / dt * v -", text)
            model.write_text(text.replace("MASS / dt * v -", "MASS / dt * 0.99 * v -"))
            self.assertNotEqual(subprocess.run(command, capture_output=True, check=False, env=environment).returncode,
                                0)

    def test_nothing_is_written_over(self) -> None:
        folder = self.folder / "gate"
        self.write("gate/mpm.json", "{}")  # no file of the script: it may be there
        self.assertEqual(self.new("gate", "--language", "c", folder).returncode, 0)
        (folder / "model.c").write_text("mine")
        (folder / "structure.c").unlink()
        self.assertIn("has CMakeLists.txt, README.md, coupler.json, model.c, model.h, test_model.c already",
                      self.refused("gate", "--language", "c", folder))
        self.assertEqual((folder / "model.c").read_text(), "mine")
        self.assertFalse((folder / "structure.c").exists())
        self.assertIn("is there and is no folder", self.refused("gate", "--language", "c", self.write("file", "")))

    def test_folder_of_the_name(self) -> None:
        done = subprocess.run([ROOT / "scripts" / "new-structure", "my.gate-1", "--language", "cpp"], cwd=self.folder,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('settings.name = "my.gate-1"', (self.folder / "my.gate-1" / "structure.cpp").read_text())

    def test_wrong_words(self) -> None:
        self.assertIn('found NAME "a b", allowed: 1 to 64 letters', self.refused("a b", "--language", "c", self.folder))
        self.assertIn('found NAME "soil"', self.refused("soil", "--language", "c", self.folder))
        self.assertIn("--language", self.refused("gate"))
        self.assertIn("invalid choice: 'fortran'", self.refused("gate", "--language", "fortran"))
        self.assertIn("invalid choice: 4", self.refused("gate", "--language", "c", "--dimension", "4"))
        self.assertEqual(list(self.folder.iterdir()), [])


if __name__ == "__main__":
    unittest.main()
