#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/test_on: what it refuses, which releases it knows, its copy, mounts that leave nothing, its table.

No root is made here: that takes the network and minutes.
"""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path
from unittest import mock

from script_case import ROOT, ScriptCase

from releases import outcome
from releases.outcome import Outcome
from releases.root import MARKER, RELEASES, ReleaseError, Root, isolated

JUNIT = """<testsuite name="Linux" tests="4" failures="1" disabled="0" skipped="1">
<testcase name="a" status="run"/><testcase name="b" status="fail"/><testcase name="c" status="notrun"/>
<testcase name="d" status="run"/></testsuite>
"""


class Refusals(ScriptCase):
    def expect_refusal(self, *arguments: object, words: str) -> None:
        result = self.script("test_on", *arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(words, result.stderr)

    def test_arguments(self) -> None:
        self.expect_refusal(words="RELEASE")
        self.expect_refusal("sid", words="'bookworm', 'trixie', 'noble'")
        for scene in ("configs/nothing", "README.md", str(ROOT / "configs/granular_obstacle")):
            self.expect_refusal("trixie", "--scene", scene, words="allowed: a folder of the checkout")
        self.expect_refusal("trixie", "--programs", "--target", "coupler", words="one of them")
        self.expect_refusal("trixie", "--package", self.folder / "none.deb", words="found no file")
        package = self.write("gabion.deb", "")
        self.expect_refusal("trixie", "--package", package, "--programs", words="allowed with --root, --mirror")

    def test_help_names_the_releases(self) -> None:
        said = self.script("test_on", "--help").stdout
        for name, release in RELEASES.items():
            self.assertRegex(said, rf"{name} +{re.escape(release.title)}")

    @unittest.skipIf(os.geteuid() != 0, "as root it is refused for another reason")
    def test_folder_of_somebody_else(self) -> None:
        self.write("root/notes.txt", "mine")
        self.expect_refusal("trixie", "--root", self.folder / "root", words="was not made by this command")
        for state, words in (({"release": "noble", "whole": True}, "is a root of noble"),
                             ({"release": "trixie", "whole": False}, "did not come to its end")):
            self.write(f"root/{MARKER}", json.dumps(state))
            self.expect_refusal("trixie", "--root", self.folder / "root", words=words)
        self.assertEqual((self.folder / "root/notes.txt").read_text(), "mine")

    def test_without_keys(self) -> None:
        root = Root(self.folder / "root", "noble")
        self.assertFalse(root.check())
        with mock.patch("releases.root.KEYRINGS", self.folder), mock.patch("shutil.which", return_value="/bin/true"):
            self.assertRaisesRegex(ReleaseError, "apt-get install ubuntu-keyring", root.make, None)
        with mock.patch("shutil.which", return_value=None):
            self.assertRaisesRegex(ReleaseError, "apt-get install debootstrap", root.make, None)
        self.assertFalse(root.folder.exists())


class Releases(ScriptCase):
    def test_those_that_the_documents_name(self) -> None:
        """Debian's numbers in scripts/setup, README and the list are the same."""
        titles = {" ".join(release.title.split()[:2]) for release in RELEASES.values()}
        self.assertEqual(titles, {"Debian 12", "Debian 13", "Ubuntu 24.04"})
        setup = (ROOT / "scripts/setup").read_text(encoding="utf-8")
        tested = re.search(r"tested=\(([^)]*)\)", setup)[1].split()
        self.assertLessEqual(set(tested), set(RELEASES))


class Copy(ScriptCase):
    def git(self, *words: str) -> None:
        subprocess.run(["git", "-C", str(self.folder / "tree"), *words], check=True, capture_output=True)

    def present(self, root: Root) -> set[str]:
        files = (path for path in root.tree.rglob("*") if path.is_symlink() or path.is_file())
        return {str(path.relative_to(root.tree)) for path in files}

    def test_tracked_files_as_they_are(self) -> None:
        self.write("tree/a/b.txt", "one")
        self.write("tree/run", "#!/bin/sh\n").chmod(0o755)
        (self.folder / "tree/link").symlink_to("a")
        self.git("init")
        self.git("add", ".")
        self.write("tree/own.txt", "not tracked")
        root = Root(self.folder / "root", "trixie")
        self.assertEqual(root.copy_tree(self.folder / "tree"), 3)
        self.assertEqual(self.present(root), {"a/b.txt", "run", "link"})
        self.assertTrue(os.access(root.tree / "run", os.X_OK))
        self.assertEqual(os.readlink(root.tree / "link"), "a")
        for made in ("build/x.o", "results/x.csv"):
            self.write(f"root/gabion/{made}", "kept")
        self.assertEqual(root.copy_tree(self.folder / "tree"), 0)
        before = (root.tree / "run").stat().st_mtime_ns
        self.write("tree/a/b.txt", "two")  # changed, not committed
        (self.folder / "tree/link").unlink()
        self.assertEqual(root.copy_tree(self.folder / "tree"), 2)
        self.assertEqual(self.present(root), {"a/b.txt", "run", "build/x.o", "results/x.csv"})
        self.assertEqual((root.tree / "a/b.txt").read_text(), "two")
        self.assertEqual((root.tree / "run").stat().st_mtime_ns, before)


class Mounts(ScriptCase):
    @unittest.skipIf(subprocess.run(isolated("true", new_ids=True), capture_output=True, check=False).returncode != 0,
                     "needs the right to mount")
    def test_nothing_is_left_when_it_is_killed(self) -> None:
        """Neither mounts nor processes."""
        place = self.folder / "place"
        place.mkdir()
        script = f"mount -t tmpfs tmpfs {place}; sleep 1000 & echo begun; wait"
        command = isolated("bash", "-c", script, new_ids=True)
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            self.assertEqual(process.stdout.readline(), "begun\n")
            self.assertNotIn(str(place), Path("/proc/self/mounts").read_text())  # nor while it runs
            process.kill()
            self.assertEqual(process.stdout.read(), "")  # ends when nobody holds it any more


class Table(ScriptCase):
    def test_row(self) -> None:
        report = self.write("tests.xml", JUNIT)
        self.assertEqual(outcome.tests(report), "2 of 3, 1 not run; failed: b")
        row = Outcome("trixie", {"compiler": "g++ 14.2.0"}, ["calculix-ccx"], "everything", "x", 30.4, "2 of 3")
        row.write(self.folder)
        self.assertEqual(outcome.read(self.folder, list(RELEASES)), [row])
        head, rows = outcome.table([row])
        self.assertEqual(len(head), len(rows[0]))
        cells = dict(zip(head, rows[0]))
        self.assertEqual((cells["compiler"], cells["lacks"], cells["PETSc"]), ("g++ 14.2.0", "calculix-ccx", ""))
        self.assertEqual(cells["minimal root to first picture [min]"], "30")

    def test_versions(self) -> None:
        """Printed output of the releases."""
        printed = {"g++": "g++ (Debian 14.2.0-19) 14.2.0\nCopyright (C) 2024", "cmake": "cmake version 3.31.6\n",
                   "mpirun": "mpirun (Open MPI) 5.0.7\n\nReport", "/usr/bin/python3": "Python 3.13.5",
                   "pkg-config": "3.22.5", "dpkg-query": "1:0.9.0-4"}
        root = mock.Mock(answer=lambda program, *_: printed[program])
        found = outcome.versions(root)
        self.assertEqual(found["compiler"], "g++ 14.2.0")
        self.assertEqual([found[key] for key in ("CMake", "PETSc", "Open MPI", "Python", "dolfinx")],
                         ["3.31.6", "3.22.5", "5.0.7", "3.13.5", "0.9.0"])
        root.answer = lambda *_: ""
        self.assertEqual(set(outcome.versions(root).values()), {"none"})


if __name__ == "__main__":
    unittest.main()
