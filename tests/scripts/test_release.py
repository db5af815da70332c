#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What says twice what stands elsewhere: version, packages of the container, dependencies of the Debian package."""

import re
import subprocess
import unittest

from script_case import ROOT, ScriptCase


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
        left_out = re.search(r"/scripts/\(([^)]*)\)\$", text_of("cmake/install.cmake"))[1].split("|")
        for name in left_out:
            self.assertTrue((ROOT / "scripts" / name).exists(), name)


if __name__ == "__main__":
    unittest.main()
