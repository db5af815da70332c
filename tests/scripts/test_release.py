#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Facts that stand in two places: version, packages of the container, dependencies of the Debian package."""

import ast
import re
import subprocess
import unittest
from pathlib import Path

from script_case import ROOT, ScriptCase

from releases.notes import ReleaseNotesError, notes


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def of_setup(expression: str) -> set[str]:
    """Words of an array of scripts/setup."""
    done = subprocess.run(["bash", "-c", f"source '{ROOT}/scripts/setup'; printf '%s\\n' {expression}"],
                          capture_output=True, text=True, check=True)
    return set(done.stdout.split())


class Release(ScriptCase):
    def test_version_of_the_citation(self) -> None:
        version = re.search(r"^project\(\w+ VERSION (\S+)", text_of("CMakeLists.txt"), re.MULTILINE)[1]
        self.assertEqual(re.search(r"^version: (\S+)$", text_of("CITATION.cff"), re.MULTILINE)[1], version)

    def test_container_has_the_packages_of_setup(self) -> None:
        run = text_of("Containerfile").replace("\\\n", " ")
        installed = re.search(r"--no-install-recommends (.*?) && ", run)[1].split()
        loops = [set(each.split()) for each in re.findall(r"for name in ([^;]*);", run)]
        wanted = of_setup('"${packages[@]}"')
        choices = [set(each.split("|")) for each in wanted if "|" in each]
        self.assertEqual(set(installed), {each for each in wanted if "|" not in each} | {"$slepc", "$lacking"})
        self.assertEqual(len(installed), len(set(installed)))
        self.assertEqual(loops, [*choices, of_setup('"${!use_of_lacking[@]}"')])

    def test_package_needs_what_the_scripts_need(self) -> None:
        cmake = text_of("cmake/install.cmake").replace("\\\n", "")
        named = {kind: re.search(rf'CPACK_DEBIAN_PACKAGE_{kind} "([^"]*)"', cmake)[1].split(", ")
                 for kind in ("DEPENDS", "RECOMMENDS", "SUGGESTS")}
        every = {each.split()[0] for names in named.values() for each in names}
        wanted = {each for each in of_setup('"${packages[@]}"') if each.startswith("python3")}
        self.assertLessEqual(wanted | of_setup('"${!use_of_lacking[@]}"'), every)

    def test_what_works_on_sources_alone_exists(self) -> None:
        for name in left_out():
            self.assertTrue((ROOT / "scripts" / name).exists(), name)

    def test_package_has_what_its_scripts_import(self) -> None:
        """No script or module that is installed imports one that is not."""
        ours = {path.stem for path in (ROOT / "scripts").iterdir() if path.suffix == ".py" or path.is_dir()}
        missing = [f"{path.relative_to(ROOT)}: {name}" for path in installed_python() for name in imported(path) & ours
                   if name in left_out()]
        self.assertEqual(missing, [])


def left_out() -> list[str]:
    """Scripts and their modules that cmake --install leaves out."""
    return re.search(r"/scripts/\(([^)]*)\)\$", text_of("cmake/install.cmake"))[1].split("|")


def installed_python() -> list[Path]:
    found = []
    for path in sorted((ROOT / "scripts").rglob("*")):
        if path.is_file() and path.relative_to(ROOT / "scripts").parts[0] not in left_out():
            if path.suffix == ".py" or (not path.suffix and path.read_bytes()[:30].startswith(b"#!/usr/bin/python3")):
                found.append(path)
    return [*found, *(ROOT / "gabion").glob("*.py")]


def imported(path: Path) -> set[str]:
    """First names of the modules that a file imports, inside functions too."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {each.name.split(".")[0] for each in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(node.module.split(".")[0])
    return found


class Notes(ScriptCase):
    CHANGES = """# Changelog

## [1.2.0] - 2026-05-04

### Added

- One, because
  of this.

### Fixed

- Two.

### Added: contact

- Three.

## [1.1.0] - 2025-01-01

### Added

- Old.
"""

    def checkout(self, changes: str = CHANGES, version: str = "1.2.0", dated: str = "2026-05-04") -> Path:
        self.write("CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\nproject(gabion VERSION 1.2.0)\n")
        self.write("CITATION.cff", f"version: {version}\n" + (f'date-released: "{dated}"\n' if dated else ""))
        self.write("CHANGELOG.md", changes)
        return self.folder

    def test_one_kind_stands_together(self) -> None:
        self.assertEqual(notes(self.checkout(), final=True), """# Gabion 1.2.0, 2026-05-04

## Added

- One, because of this.

### Contact

- Three.

## Fixed

- Two.
""")

    def test_what_does_not_agree(self) -> None:
        undated = self.CHANGES.replace("2026-05-04", "unreleased")
        for given, words in (({"version": "1.1.9"}, "CITATION.cff: found version 1.1.9, allowed: 1.2.0"),
                             ({"changes": self.CHANGES.replace("1.2.0", "1.3.0")}, "CHANGELOG.md: found version 1.3.0"),
                             ({"changes": undated}, "found unreleased, allowed: the date of the release"),
                             ({"changes": self.CHANGES.replace("2026-05-04", "May")}, "found the date May"),
                             ({"dated": "2026-05-05"}, "found date-released 2026-05-05, allowed: 2026-05-04"),
                             ({"dated": ""}, "found no line date-released: 2026-05-04"),
                             ({"changes": self.CHANGES.replace("### Fixed", "### Mended")}, "the heading ### Mended"),
                             ({"changes": self.CHANGES.replace("- Two", "Two")}, 'found "Two." before any entry'),
                             ({"changes": "# Changelog\n"}, "found no heading")):
            with self.subTest(words):
                with self.assertRaises(ReleaseNotesError) as raised:
                    notes(self.checkout(**given), final=True)
                self.assertIn(words, str(raised.exception))
        self.assertIn("# Gabion 1.2.0, unreleased", notes(self.checkout(undated, dated="")))

    def test_notes_of_this_version(self) -> None:
        done = self.python_script("release_notes")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        listed = sum(line.startswith("- ") for line in text_of("CHANGELOG.md").split("\n## [")[1].splitlines())
        self.assertEqual(sum(line.startswith("- ") for line in done.stdout.splitlines()), listed)


if __name__ == "__main__":
    unittest.main()
