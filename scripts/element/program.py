# SPDX-License-Identifier: BSD-3-Clause
"""The program element_test: its input put together, started, its table read."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

from element.laboratory import ElementError
from plotting.results import Table
from running.programs import PROGRAMS

CANNOT_FOLLOW = 3  # exit code: the law or the control does not go on; the table has the rows up to there


@dataclass(frozen=True)
class Soil:
    """Source of a material: a scene of mpm.json, or the blocks themselves."""

    scene: Path | None = None
    body: str | None = None
    overrides: tuple[str, ...] = ()
    blocks: dict | None = None  #: "material" and, of saturated soil, "water"

    @property
    def words(self) -> list[str]:
        if self.scene is None:
            return []
        settings = [word for each in self.overrides for word in ("--set", each)]
        return ["--scene", str(self.scene), *(["--body", self.body] if self.body else []), *settings]


@dataclass
class Run:
    """A test that the program has gone through, or as far as it could."""

    code: int
    table: Table | None  #: None: it wrote no row
    message: str  #: why it did not come to the end


def read_json(path: Path) -> dict:
    """@raises ElementError  no such file, no JSON, no object"""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ElementError(f"{path}: {error}") from error
    if not isinstance(values, dict):
        raise ElementError(f"{path}: found no object, allowed: the settings of a scene or of a test")
    return values


def run_program(folder: Path, name: str, program: dict, soil: Soil, programs: Path = PROGRAMS) -> Run:
    """Write NAME.json into the folder, run it to NAME.csv."""
    test, csv = folder / f"{name}.json", folder / f"{name}.csv"
    csv.unlink(missing_ok=True)
    test.write_text(json.dumps(program | (soil.blocks or {}), indent=1) + "\n", encoding="utf-8")
    command = [str(programs / "element_test"), str(test), "--output", str(csv), *soil.words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise ElementError(f"{command[0]}: {error.strerror}; scripts/setup builds it") from error
    return Run(done.returncode, Table(csv) if csv.exists() else None, done.stderr.strip())
