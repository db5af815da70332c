#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""pip installs gabion_participant without a network, and leaves its folder as it was."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "protocol" / "python"


def everything_in(folder: Path) -> dict[str, bytes | None]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else None
            for path in folder.rglob("*") if "gabion_participant/__pycache__" not in path.as_posix()}


class Install(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.source = self.folder / "python"
        shutil.copytree(SOURCE, self.source, ignore=shutil.ignore_patterns("__pycache__"))
        self.before = everything_in(self.source)

    def python(self, *words: object, path: Path | None = None) -> str:
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        if path:
            environment["PYTHONPATH"] = str(path)
        done = subprocess.run([sys.executable, *map(str, words)], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, cwd=self.folder, env=environment, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def backend(self, function: str) -> Path:
        """File that a function of the backend makes, in the folder."""
        code = (f"import os, sys; sys.path.insert(0, {str(self.source)!r}); os.chdir({str(self.source)!r}); "
                f"import build_wheel; print(build_wheel.{function}({str(self.folder)!r}))")
        return self.folder / self.python("-c", code).strip()

    def check_tree(self) -> None:
        self.assertEqual(everything_in(self.source), self.before)

    def check_import(self, path: Path, place: Path) -> None:
        code = "import gabion_participant.process as module; print(module.__file__)"
        self.assertEqual(self.python("-c", code, path=path).strip(), str(place / "gabion_participant" / "process.py"))

    def test_pip(self) -> None:
        target = self.folder / "installed"
        try:
            self.python("-m", "pip", "--version")
        except AssertionError:
            self.skipTest("no pip here")
        self.python("-m", "pip", "install", "--no-index", "--no-deps", "--target", target, self.source)
        self.check_tree()
        self.check_import(target, target)
        code = ("import importlib.metadata as m; "
                "print(m.version('gabion-participant'), m.requires('gabion-participant'))")
        self.assertRegex(self.python("-c", code, path=target), r"^\d+\.\d+\.\d+ \['numpy>=\S+', 'pyzmq>=\S+'\]$")

    def test_wheel(self) -> None:
        wheel = self.backend("build_wheel")
        self.check_tree()
        target = self.folder / "unpacked"
        shutil.unpack_archive(wheel, target, "zip")
        self.check_import(target, target)
        first = wheel.read_bytes()
        self.assertEqual(self.backend("build_wheel").read_bytes(), first)

    def test_editable_wheel_names_the_sources(self) -> None:
        target = self.folder / "unpacked"
        shutil.unpack_archive(self.backend("build_editable"), target, "zip")
        self.check_tree()
        self.assertEqual((target / "gabion_participant.pth").read_text().strip(), str(self.source))

    def test_archive_of_the_sources_builds_too(self) -> None:
        shutil.unpack_archive(self.backend("build_sdist"), self.folder / "sources")
        self.check_tree()
        (self.source,) = (self.folder / "sources").iterdir()
        self.assertTrue((self.source / "PKG-INFO").is_file())
        self.assertTrue(self.backend("build_wheel").is_file())


if __name__ == "__main__":
    unittest.main()
