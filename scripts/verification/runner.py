# SPDX-License-Identifier: BSD-3-Clause
"""Run the programs of verification problems and gather the rows that they write."""

import json
import os
import platform
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from verification.table import Row, VerificationError, by_id, read_rows

ONE_THREAD = {"OMP_THREAD_LIMIT": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
              "OMPI_MCA_mpi_yield_when_idle": "1"}
if platform.machine() == "x86_64":  # one kind of kernels, as scripts/setup says
    ONE_THREAD["OPENBLAS_CORETYPE"] = os.environ.get("OPENBLAS_CORETYPE", "Haswell")


@dataclass
class Programs:
    """Content of build/release/verification_programs.txt."""

    start: list[str]  #: command that starts a program
    paths: list[Path]

    @staticmethod
    def read(path: Path) -> "Programs":
        if not path.exists():
            raise VerificationError(f"{path}: not there; built without tests?")
        lines = path.read_text(encoding="utf-8").splitlines()
        return Programs(lines[0].split(), [Path(line) for line in lines[1:] if line])

    def command(self, program: Path, *options: str) -> list[str]:
        return [*self.start, str(program), *options]


def ids_of(programs: Programs) -> list[str]:
    """Ids of all problems: what stands before the first underscore of a suite's name."""
    found = set()
    for program in programs.paths:
        listing = subprocess.run(programs.command(program, "--gtest_list_tests"), capture_output=True,
                                 text=True, check=False, env={**os.environ, **ONE_THREAD})
        if listing.returncode != 0:
            raise VerificationError(f"{program}: does not list its problems: {listing.stderr.strip()}")
        found |= {line.partition("_")[0] for line in listing.stdout.splitlines() if line.endswith(".")}
    return sorted(found, key=lambda name: by_id(Row("", name, "")))


def check_ids(programs: Programs, ids: list[str]) -> None:
    """@raises VerificationError  an id that no program knows"""
    known = ids_of(programs)
    unknown = [name for name in ids if name not in known]
    if unknown:
        raise VerificationError(f"no problem {', '.join(unknown)}; there are {', '.join(known)}")


def run_programs(programs: Programs, ids: list[str], folder: Path, jobs: int) -> list[Row]:
    """Run the problems of `ids` (all of them when it is empty); rows sorted by id.

    A case that fails otherwise than by the bound of a row, or a program that dies, makes a row too.
    Each program leaves its output in folder/logs.
    """
    (folder / "logs").mkdir(parents=True, exist_ok=True)
    for old in (folder / "logs").iterdir():
        old.unlink()
    with ThreadPoolExecutor(jobs) as pool:
        rows = [row for some in pool.map(lambda path: _run(programs, path, ids, folder), programs.paths)
                for row in some]
    return sorted(rows, key=by_id)


def _run(programs: Programs, program: Path, ids: list[str], folder: Path) -> list[Row]:
    base = folder / "logs" / program.name
    table, report = base.with_suffix(".rows.csv"), base.with_suffix(".json")
    names = {"GABION_VERIFICATION_TABLE": str(table),
             "GABION_VERIFICATION_CURVES": str(base.with_suffix(".curves.csv"))}
    command = programs.command(program, f"--gtest_output=json:{report}")
    if ids:
        command.append("--gtest_filter=" + ":".join(f"{name}_*" for name in ids))
    with base.with_suffix(".log").open("w", encoding="utf-8") as log:
        code = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, check=False,
                              env={**os.environ, **ONE_THREAD, **names}).returncode
    rows = read_rows(table)
    if not report.exists():
        return [*rows, Row("", program.name, f"ended with exit code {code}; see {base.with_suffix('.log')}")]
    return rows + _other_failures(json.loads(report.read_text(encoding="utf-8")), rows)


def _other_failures(report: dict, rows: list[Row]) -> list[Row]:
    """A row for each case that failed although all its rows hold, or that wrote no row."""
    failures = []
    for suite in report["testsuites"]:
        for case in suite["testsuite"]:
            test = f"{suite['name']}.{case['name']}"
            own = [row for row in rows if row.test == test]
            name, what = suite["name"].partition("_")[0], f"{case['name'].replace('_', ' ')}"
            if "failures" in case and all(row.holds for row in own):
                words = " ".join(case["failures"][0]["failure"].splitlines()[:2])
                failures.append(Row(test, name, f"{what}: {words[:90]}"))
            elif not own and case.get("result") == "COMPLETED":
                failures.append(Row(test, name, f"{what}: recorded no row"))
    return failures
