#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/setup: which packages are missing, and what scripts/test says of tests that need another one."""

import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path

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

    def test_a_choice_is_missing_when_none_of_its_packages_is_installed(self) -> None:
        self.assertEqual(self.sourced("missing_choices 'a|b' 'c|d' e", "b", "x"), "c|d\ne\n")
        self.assertEqual(self.sourced("missing_choices 'a|b' c", "a", "c"), "")

    def test_of_a_choice_the_first_that_the_release_has(self) -> None:
        known = "is_available() { [[ $1 == b || $1 == d ]]; }; "
        self.assertEqual(self.sourced(known + "chosen_of 'a|b|d' e 'f|g'"), "b\ne\nf\n")
        self.assertEqual(self.sourced(known + "available_of a b"), "b\n")

    def test_availability(self) -> None:
        """apt-cache may write its lines one by one, or be slow; nothing reads only the first ones of them."""
        policy = ("set -euo pipefail; apt-cache() { [[ $2 != unknown ]] || return 0; echo \"$2:\"; "
                  "echo \"  Candidate: $2\"; sleep 0.2; echo '  Version table:'; echo '     1.0 500'; }; ")
        for name, available in (("1.0", True), ("1:3.22+dfsg1-1", True), ("(none)", False), ("unknown", False)):
            said = self.sourced(f"{policy} is_available '{name}' && echo yes || echo no")
            self.assertEqual(said, "yes\n" if available else "no\n", name)

    def test_what_the_release_lacks_is_no_error(self) -> None:
        every = ("is_available() { [[ $1 != calculix-ccx ]]; }; require_writable() { :; }; mkdir() { :; }; "
                 "quietly() { printf '%s ' \"${@: -2}\"; }; ")
        required = "missing_choices() { :; }; "
        self.assertEqual(self.sourced(every + required + "install_packages"), "")  # nothing to do, nothing to say
        said = self.sourced(every + "missing_choices() { echo 'a|b'; }; sudo() { :; }; install_packages")
        self.assertIn("has no package calculix-ccx, which runs structures of CalculiX", said)
        self.assertIn("Installing 1 packages and what they need: a\n", said)
        self.assertEqual(self.sourced("say_not_run '  Test #1: participant.calculix'", "chromium"),
                         "not run: participant.calculix; it needs the package calculix-ccx, which some releases lack\n")

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

    def test_failed_tests_are_shown_at_the_end(self) -> None:
        logs = "build/Testing/Temporary"
        passed = "1/2 Testing: a\nOutput:\nfine\n<end of output>\nTest Passed.\n"
        failed = "2/2 Testing: b\nOutput:\nfound 1, expected 2\n<end of output>\nTest Failed.\n"
        self.write(f"{logs}/LastTest.log", passed + failed)
        say = f"say_failed {self.folder}/build"
        self.assertEqual(self.sourced(say), "")  # nothing failed
        self.write(f"{logs}/LastTestsFailed.log", "2:b\n")
        self.assertRegex(self.sourced(say), r"^failed: b; the end of what it printed \(.*/LastTest.log has all\):\n"
                                            r"2/2 Testing: b\nOutput:\nfound 1, expected 2\n$")

    def expect_tests_that_may_be_skipped(self, array: str) -> None:
        """Each test named in an array of scripts/setup exists, and ends with 77 where it cannot run."""
        named = re.search(array + r"=\((.*)\)", (ROOT / "scripts" / "setup").read_text())[1]
        tests = [test for group in re.findall(r'\]="([^"]+)"', named) for test in group.split()]
        self.assertGreater(len(tests), 1)
        for test in tests:
            folder, name = test.split(".")
            lists = (ROOT / "tests" / folder / "CMakeLists.txt").read_text()
            self.assertIn(f"{test} PROPERTIES SKIP_RETURN_CODE 77", lists)
            self.assertIn("sys.exit(77)", (ROOT / "tests" / folder / f"test_{name}.py").read_text())

    def test_tests_of_modules_exist_and_say_when_they_are_not_run(self) -> None:
        self.expect_tests_that_may_be_skipped("tests_of_wheels")

    def test_tests_of_lacking_packages_exist_and_say_when_they_are_not_run(self) -> None:
        self.expect_tests_that_may_be_skipped("tests_of_lacking")

    def test_named_tests_exist_and_say_when_they_are_not_run(self) -> None:
        named = re.search(r"tests_of_optional=\((.*)\)", (ROOT / "scripts" / "setup").read_text())[1]
        tests = re.findall(r"\[\S+\]=(\w+)\.(\w+)", named)
        self.assertEqual(len(tests), named.count("["))
        for kind, name in tests:
            folder = ROOT / LISTS[kind]
            self.assertIn(f"{kind}.{name} PROPERTIES SKIP_RETURN_CODE 77", (folder / "CMakeLists.txt").read_text())
            self.assertIn("sys.exit(77)", (folder / f"test_{name}.py").read_text())


class Tree(ScriptCase):
    """A tree of its own with scripts/setup in it."""

    def setUp(self) -> None:
        super().setUp()
        self.folder.chmod(0o755)
        self.tree = self.folder / "tree"
        (self.tree / "scripts").mkdir(parents=True)
        shutil.copy(ROOT / "scripts" / "setup", self.tree / "scripts" / "setup")
        self.write("tree/CMakeLists.txt", "")

    def sourced(self, commands: str, *prefix: str, **environment: str) -> tuple[int, str]:
        """Exit code and output of commands after `source scripts/setup`; cmake and ninja only say their words."""
        fakes = "cmake() { echo cmake \"$@\" >&2; }; ninja() { echo \"$said\"; }"
        script = f"set -euo pipefail; source scripts/setup; {fakes}; {commands}"
        done = subprocess.run([*prefix, "bash", "-c", script, "scripts/run"], cwd=self.tree, text=True, check=False,
                              env={"PATH": "/usr/bin:/bin", "said": "", **environment}, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        return done.returncode, done.stdout

    def configured_for(self, home: Path) -> None:
        """Write a build folder as if everything was configured, for the sources in `home`."""
        self.write("tree/build/release/CMakeCache.txt", f"A:BOOL=ON\nCMAKE_HOME_DIRECTORY:INTERNAL={home}\n")
        self.write("tree/build/release/build.ninja", "")
        self.write("tree/build/release/cmake_lists.txt", "./CMakeLists.txt\n")

    def test_cdpath(self) -> None:
        code, said = self.sourced('printf "%s|" "$root"; cd scripts; env', CDPATH=f"{self.tree}:/tmp")
        self.assertEqual((code, said.split("|")[0]), (0, str(self.tree)), said)
        self.assertNotIn("CDPATH", said.split("|")[1])

    def test_build_folder_of_another_tree_is_configured_anew(self) -> None:
        self.configured_for(self.tree)
        self.assertEqual(self.sourced("configure"), (0, ""))
        (self.folder / "link").symlink_to(self.tree)
        self.configured_for(self.folder / "link")
        self.assertEqual(self.sourced("configure"), (0, ""))
        for home in (self.folder, self.folder / "gone"):  # copied, moved
            self.configured_for(home)
            code, said = self.sourced("configure; cat build/configure.log")
            self.assertEqual(code, 0, said)
            self.assertIn("build/release comes from another folder: everything is built anew", said)
            self.assertIn("cmake --fresh --preset release", said)

    def as_somebody_else(self) -> list[str]:
        """Words before a command that make it run without the right to write in the tree."""
        if os.geteuid() == 0:
            return ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
        for path in (self.tree, *self.tree.rglob("*")):
            path.chmod(path.stat().st_mode & ~0o222)
            self.addCleanup(path.chmod, 0o755)
        return []

    def test_tree_of_somebody_else(self) -> None:
        refusal = f"scripts/run: {self.tree}/build cannot be written by "
        code, said = self.sourced("build_targets coupler", *self.as_somebody_else())
        self.assertEqual(code, 2)
        self.assertIn(refusal, said)
        self.assertIn("its owner can build them with scripts/setup", said)

    def test_built_tree_of_somebody_else(self) -> None:
        self.configured_for(self.tree)
        self.write("tree/build/lock", "")
        other = self.as_somebody_else()
        self.assertEqual(self.sourced("build_targets coupler", *other, said="ninja: no work to do."), (0, ""))
        code, said = self.sourced("build_targets coupler", *other, said="[1/2] Building")
        self.assertEqual(code, 2, said)
        self.assertIn("are older than their sources", said)


if __name__ == "__main__":
    unittest.main()
