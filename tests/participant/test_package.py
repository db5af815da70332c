#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""An outside project finds the installed package, builds in C99 and C++, and takes part.

    test_package.py BUILD_FOLDER BIN_FOLDER [unittest options]
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "integration")]
import launch  # noqa: E402
from launch import free_endpoint, meeting  # noqa: E402

build = binaries = Path()  # set at the end


def run(*command: object) -> str:
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=150, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cls.prefix, cls.outside = cls.folder / "installed", cls.folder / "outside"
        run("cmake", "--install", build, "--component", "gabion_participant", "--prefix", cls.prefix)
        run("cmake", "-S", HERE / "outside", "-B", cls.outside, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={cls.prefix}")
        run("cmake", "--build", cls.outside)
        scene = meeting()
        del scene["fem"]
        (cls.folder / "scene").mkdir()
        for name, content in scene.items():
            (cls.folder / "scene" / f"{name}.json").write_text(json.dumps(content), encoding="utf-8")

    def check(self, program: str, *options: str) -> tuple[int, str, subprocess.CompletedProcess]:
        """Exit code and table of the coupler's check, and how the program ended."""
        endpoint = free_endpoint()
        coupler = subprocess.Popen([binaries / "coupler", self.folder / "scene", "--check-participant", "structure",
                                    "--coupler", endpoint], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        foreign = subprocess.run([self.outside / program, endpoint, *options], capture_output=True, text=True,
                                 timeout=60, check=False)
        text = coupler.communicate(timeout=60)[0]
        return coupler.returncode, text, foreign

    def test_nothing_but_the_package_is_installed(self) -> None:
        top = {path.relative_to(self.prefix).parts[0] for path in self.prefix.rglob("*") if path.is_file()}
        self.assertEqual(top, {"include", "lib"})

    def test_in_c(self) -> None:
        code, text, foreign = self.check("spring_in_c")
        self.assertEqual((code, foreign.returncode), (0, 0), text + foreign.stderr)
        self.assertIn("(spring, pid", text)
        self.assertRegex(text, "the same steps after save, other steps and load +passed")
        self.assertRegex(foreign.stdout, "outputs: 2")

    def test_in_c_that_keeps_what_was_rejected(self) -> None:
        code, text, _ = self.check("spring_in_c", "keep")
        self.assertEqual(code, 1, text)
        self.assertRegex(text, "the same bits after reject_step +FAILED")

    def test_in_cpp(self) -> None:
        code, text, foreign = self.check("spring_in_cpp")
        self.assertEqual((code, foreign.returncode), (0, 0), text + foreign.stderr)
        self.assertRegex(text, "a skipped step +passed")
        self.assertRegex(text, "the same steps after save, other steps and load +not asked")

    def test_no_coupler(self) -> None:
        done = subprocess.run([self.outside / "spring_in_c", "nonsense"], capture_output=True, text=True, timeout=60,
                              check=False)
        self.assertEqual(done.returncode, 4)
        self.assertIn('cannot connect to the coupler at "nonsense"', done.stderr)


if __name__ == "__main__":
    build, binaries = (Path(sys.argv.pop(1)).resolve() for _ in range(2))
    launch.binaries = binaries
    unittest.main()
