#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/setup: which packages are missing, and what scripts/test says of tests that need another one."""

import re
import subprocess
import unittest

from script_case import ROOT, ScriptCase

LISTED = "  Test  #1: structure\n  Test #20: scripts.report_browser\n"
LISTS = {"scripts": "tests/scripts", "integration": "tests/integration"}  # first word of a test: where it is


class Setup(ScriptCase):
    def sourced(self, commands: str, *installed: str) -> str:
        """Output of commands after scripts/setup, on a machine with these packages."""
        answer = "".join(f"installed {name}\n" for name in installed)
        script = f"source {ROOT}/scripts/setup; dpkg-query() {{ printf '%s' \"$installed\"; return 1; }}; {commands}"
        done = subprocess.run(["bash", "-c", script], env={"installed": answer, "PATH": "/usr/bin:/bin"}, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        return done.stdout

    def test_missing_packages(self) -> None:
        self.assertEqual(self.sourced("missing_of b c a", "a", "x"), "b\nc\n")
        self.assertEqual(self.sourced("missing_of b a", "a", "b"), "")

    def test_tests_that_were_not_run(self) -> None:
        say = f"say_not_run '{LISTED}'"
        self.assertEqual(self.sourced(say, "chromium", "libdeal.ii-dev"), "")
        self.assertEqual(self.sourced(say), "not run: scripts.report_browser; it needs: apt-get install "
                                            "--no-install-recommends chromium\n")
        self.assertEqual(self.sourced("say_not_run '  Test #1: structure'"), "")  # it was not asked for

    def test_tests_of_a_module_that_were_not_run(self) -> None:
        listed = "  Test #3: participant.opensees\n  Test #4: structure\n"
        say = f"say_not_run '{listed}'"
        self.assertEqual(self.sourced(f"has_module() {{ false; }}; {say}", "chromium"),
                         "not run: participant.opensees; it needs: /usr/bin/python3 -m pip install openseespy\n")
        self.assertEqual(self.sourced(f"has_module() {{ true; }}; {say}", "chromium"), "")
        self.assertEqual(self.sourced("has_module $python json && ! has_module $python no_such_module && echo right"),
                         "right\n")

    def test_tests_of_modules_exist_and_say_when_they_are_not_run(self) -> None:
        named = re.search(r"tests_of_wheels=\((.*)\)", (ROOT / "scripts" / "setup").read_text())[1]
        tests = [test for group in re.findall(r'\]="([^"]+)"', named) for test in group.split()]
        self.assertGreater(len(tests), 1)
        for test in tests:
            folder, name = test.split(".")
            lists = (ROOT / "tests" / folder / "CMakeLists.txt").read_text()
            self.assertIn(f"{test} PROPERTIES SKIP_RETURN_CODE 77", lists)
            self.assertIn("sys.exit(77)", (ROOT / "tests" / folder / f"test_{name}.py").read_text())

    def test_named_tests_exist_and_say_when_they_are_not_run(self) -> None:
        named = re.search(r"tests_of_optional=\((.*)\)", (ROOT / "scripts" / "setup").read_text())[1]
        tests = re.findall(r"\[\S+\]=(\w+)\.(\w+)", named)
        self.assertEqual(len(tests), named.count("["))
        for kind, name in tests:
            folder = ROOT / LISTS[kind]
            self.assertIn(f"{kind}.{name} PROPERTIES SKIP_RETURN_CODE 77", (folder / "CMakeLists.txt").read_text())
            self.assertIn("sys.exit(77)", (folder / f"test_{name}.py").read_text())


if __name__ == "__main__":
    unittest.main()
