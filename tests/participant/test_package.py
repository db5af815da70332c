#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""An outside project finds the installed package, builds in C99 and C++, and takes part.

    test_package.py BUILD_FOLDER BIN_FOLDER [unittest options]
"""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "integration")]
import launch  # noqa: E402
from launch import free_endpoint, meeting  # noqa: E402

build = binaries = Path()  # set at the end

# All that is installed: a header more is a promise more.
HEADERS = {
    "common/base": ("error.hpp", "json.hpp", "process.hpp", "timer.hpp"),
    "common/run": ("facets.hpp", "solver.hpp", "start.hpp", "state.hpp"),
    "common/settings": ("config_reader.hpp", "json_text.hpp", "keys.hpp", "nearest_word.hpp"),
    "protocol": ("gabion_participant.h", "participant.hpp", "serve.hpp"),
    "protocol/channel": ("attention.hpp", "heartbeat.hpp", "keys.hpp", "peer_watch.hpp", "socket.hpp"),
    "protocol/participant": ("connection.hpp", "own_facets.hpp", "request_source.hpp", "state_machine.hpp",
                             "step_order.hpp", "usage_error.hpp"),
    "protocol/wire": ("deadlines.hpp", "facets.hpp", "handshake.hpp", "message.hpp"),
}
LIBRARY = (r"lib/libgabion_participant\.so(\.\d+){0,3}"
           r"|lib/cmake/gabion_participant/gabion_participant(-config|_targets)[a-z-]*\.cmake")


def run(*command: object) -> str:
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=600, check=False)
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
                                 timeout=600, check=False)
        text = coupler.communicate(timeout=600)[0]
        return coupler.returncode, text, foreign

    def test_nothing_but_the_package_is_installed(self) -> None:
        found = {path.relative_to(self.prefix).as_posix() for path in self.prefix.rglob("*") if not path.is_dir()}
        self.assertEqual({name for name in found if name.startswith("include/")},
                         {f"include/gabion/{folder}/{name}" for folder, names in HEADERS.items() for name in names})
        others = {name for name in found if not name.startswith("include/")}
        self.assertEqual({name for name in others if not re.fullmatch(LIBRARY, name)}, set())
        self.assertIn("lib/libgabion_participant.so", others)
        self.assertIn("lib/cmake/gabion_participant/gabion_participant-config.cmake", others)

    def test_every_header_stands_alone(self) -> None:
        """It compiles by itself and finds all that it includes beside it: nothing else of this project is there."""
        include = self.prefix / "include" / "gabion"
        warnings = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror", "-fsyntax-only")

        def compile_alone(header: Path) -> None:
            name = header.relative_to(include)
            if header.suffix == ".h":
                run("cc", "-std=c99", *warnings, "-I", include, "-include", name, "-x", "c", "/dev/null")
            run("c++", "-std=c++20", *warnings, "-I", include, "-include", name, "-x", "c++", "/dev/null")

        headers = [include / folder / name for folder, names in HEADERS.items() for name in names]
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(compile_alone, headers))
        for header in headers:
            own = re.findall(r'^#include "([^"]+)"', header.read_text(encoding="utf-8"), re.MULTILINE)
            self.assertEqual([name for name in own if not (include / name).is_file()], [], header)

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
        done = subprocess.run([self.outside / "spring_in_c", "nonsense"], capture_output=True, text=True, timeout=600,
                              check=False)
        self.assertEqual(done.returncode, 4)
        self.assertIn('cannot connect to the coupler at "nonsense"', done.stderr)


if __name__ == "__main__":
    build, binaries = (Path(sys.argv.pop(1)).resolve() for _ in range(2))
    launch.binaries = binaries
    unittest.main()
