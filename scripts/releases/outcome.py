# SPDX-License-Identifier: BSD-3-Clause
"""Versions and results on a release, as a row of the table."""

import json
import re
import xml.etree.ElementTree
from dataclasses import asdict, dataclass, field
from pathlib import Path

from releases.root import Root

# Column -> command inside a root, and where the version stands in what it prints.
VERSIONS = {
    "compiler": (["g++", "--version"], r"^(g\+\+) .* (\d+\.\d+\.\d+)$"),
    "CMake": (["cmake", "--version"], r"version (\S+)"),
    "PETSc": (["pkg-config", "--modversion", "PETSc"], r"(\S+)"),
    "SLEPc": (["pkg-config", "--modversion", "SLEPc"], r"(\S+)"),
    "HDF5": (["dpkg-query", "-W", "-f", "${Version}", "libhdf5-openmpi-dev"], r"^([\d.]+\d)"),
    "Open MPI": (["mpirun", "--version"], r"\) (\S+)"),
    "Python": (["/usr/bin/python3", "--version"], r"Python (\S+)"),
    "dolfinx": (["dpkg-query", "-W", "-f", "${Version}", "python3-dolfinx"], r"^(?:\d+:)?([\d.]+\d)"),
}
LACKING = 'source scripts/setup; missing_of "${!use_of_lacking[@]}"'


@dataclass
class Outcome:
    """A row: the release and its versions, what it lacks, and what ran there."""

    release: str
    versions: dict[str, str] = field(default_factory=dict)
    lacking: list[str] = field(default_factory=list)
    built: str = ""  # targets
    scene: str = ""  # that ran, and drew pictures
    minutes: float | None = None  # [min] from the minimal root to the first picture, packages and build included
    tests: str = ""

    def write(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{self.release}.json").write_text(json.dumps(asdict(self), indent=1) + "\n", encoding="utf-8")


def read(folder: Path, names: list[str]) -> list[Outcome]:
    """Outcomes of the releases that were written before."""
    files = [folder / f"{name}.json" for name in names]
    return [Outcome(**json.loads(file.read_text(encoding="utf-8"))) for file in files if file.exists()]


def versions(root: Root) -> dict[str, str]:
    found = {}
    for column, (command, pattern) in VERSIONS.items():
        match = re.search(pattern, root.answer(*command), re.MULTILINE)
        found[column] = " ".join(match.groups()) if match else "none"
    return found


def lacking(root: Root) -> list[str]:
    """Packages that scripts/setup would install where the release had them."""
    return root.answer("bash", "-c", LACKING).split()


def tests(report: Path) -> str:
    """Passed of run, by ctest's file in the form of JUnit."""
    suite = xml.etree.ElementTree.parse(report).getroot()
    number = {key: int(suite.get(key, "0")) for key in ("tests", "failures", "skipped", "disabled")}
    run = number["tests"] - number["skipped"] - number["disabled"]
    failed = [case.get("name", "") for case in suite.iter("testcase") if case.get("status") == "fail"]
    return (f"{run - number['failures']} of {run}" + f", {number['skipped']} not run" * (number["skipped"] > 0)
            + f"; failed: {', '.join(failed)}" * bool(failed))


def table(outcomes: list[Outcome]) -> tuple[list[str], list[list[str]]]:
    """Head and rows."""
    head = ["release", *VERSIONS, "lacks", "built", "scene", "minimal root to first picture [min]", "tests passed"]
    return head, [[each.release, *(each.versions.get(column, "") for column in VERSIONS),
                   ", ".join(each.lacking) or "-", each.built, each.scene,
                   "" if each.minutes is None else f"{each.minutes:.0f}", each.tests] for each in outcomes]
