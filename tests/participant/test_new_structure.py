#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The structure that scripts/new-structure writes, unchanged: it builds without a warning, its test passes, the
coupler's check too.

    test_new_structure.py BUILD_FOLDER BIN_FOLDER [unittest options]
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(HERE.parent / "integration")]
from launch import free_endpoint  # noqa: E402

build = binaries = Path()  # set at the end


def run(*command: object) -> str:
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=300, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout


class NewStructure(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        run("cmake", "--install", build, "--component", "gabion_participant", "--prefix", cls.folder / "prefix")

    def write(self, language: str, dimension: int) -> Path:
        folder = self.folder / f"{language}{dimension}"
        run(ROOT / "scripts" / "new-structure", "gate", "--language", language, "--dimension", dimension, folder)
        return folder

    def build(self, folder: Path) -> None:
        run("cmake", "-S", folder, "-B", folder / "build", "-G", "Ninja",
            f"-DCMAKE_PREFIX_PATH={self.folder / 'prefix'}")
        # The linker warns of functions in the runtime of the address sanitizer, where our library was built with it.
        built = run("cmake", "--build", folder / "build").splitlines()
        self.assertEqual([line for line in built if "warning" in line and "libasan" not in line], [])
        self.assertIn("100% tests passed, 0 tests failed out of 1", run("ctest", "--test-dir", folder / "build"))

    def check(self, folder: Path) -> None:
        """Check a structure by the command of its scene, started in the scene's folder, as scripts/run does."""
        endpoint = free_endpoint()
        coupler = subprocess.Popen([binaries / "coupler", folder, "--check-participant", "gate", "--coupler", endpoint],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        command = json.loads((folder / "coupler.json").read_text())["participants"]["gate"]["command"]
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "protocol" / "python")}
        structure = subprocess.run([*command, "--coupler", endpoint], cwd=folder, env=environment, capture_output=True,
                                   text=True, timeout=600, check=False)
        text = coupler.communicate(timeout=600)[0]
        self.assertEqual((coupler.returncode, structure.returncode), (0, 0), text + structure.stderr)
        self.assertRegex(text, "the same steps after save, other steps and load +passed")
        self.assertRegex(text, "the end +passed")
        self.assertEqual(re.findall("FAILED|NOTICE|inexact|warning", text), [], text)

    def test_python(self) -> None:
        for dimension in (2, 3):
            self.check(self.write("python", dimension))

    def test_cpp(self) -> None:
        for dimension in (2, 3):
            folder = self.write("cpp", dimension)
            self.build(folder)
            self.check(folder)

    def test_c(self) -> None:
        for dimension in (2, 3):
            folder = self.write("c", dimension)
            self.build(folder)
            self.check(folder)
        done = subprocess.run([folder / "build" / "structure", "--coupler", "nonsense"], capture_output=True, text=True,
                              timeout=600, check=False)
        self.assertEqual(done.returncode, 4)
        self.assertIn('[gate] error: cannot connect to the coupler at "nonsense"', done.stderr)


if __name__ == "__main__":
    build, binaries = (Path(sys.argv.pop(1)).resolve() for _ in range(2))
    unittest.main()
