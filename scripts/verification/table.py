# SPDX-License-Identifier: BSD-3-Clause
"""Rows of the verification table: read, sorted, as text, Markdown and CSV."""

import csv
import re
from dataclasses import asdict, dataclass, fields
from pathlib import Path

HEAD = ["id", "problem", "exact", "computed", "measure", "bound", "s", ""]
SIGNS = {"relative_error": ("relative", "<="), "absolute_error": ("absolute", "<="), "order": ("order", ">=")}


class VerificationError(Exception):
    """Programs, tables or ids that are missing or cannot be read."""


@dataclass
class Row:
    """One result, as tests/support/verification_row.hpp writes it."""

    test: str  #: GoogleTest suite and case
    id: str
    what: str
    exact: float | None = None
    computed: float | None = None
    unit: str = ""
    measure: str = ""
    value: float | None = None
    bound: float | None = None
    holds: bool = False
    limitation: str = ""
    seconds: float | None = None

    @property
    def verdict(self) -> str:
        if not self.holds:
            return "FAILED"
        return "limit" if self.limitation else "ok"

    def cells(self) -> list[str]:
        """Texts below HEAD; a failure without numbers leaves theirs empty."""
        if self.value is None:
            return [self.id, self.what, "", "", "", "", "", self.verdict]
        name, sign = SIGNS[self.measure]
        unit = f" {self.unit}" if self.unit else ""
        judged = f"{self.value:.2f}" if self.measure == "order" else f"{self.value:.1e}"
        return [self.id, self.what, f"{self.exact:.6g}{unit}", f"{self.computed:.6g}{unit}",
                f"{name} {judged}", f"{sign} {self.bound:.3g}", f"{self.seconds:.2f}", self.verdict]


def read_rows(path: Path) -> list[Row]:
    """Rows of one program; none when it wrote none.

    @raises VerificationError  not such a table
    """
    if not path.exists():
        return []
    numbers = {"exact", "computed", "value", "bound", "seconds"}
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames != [field.name for field in fields(Row)]:
            raise VerificationError(f"{path}: found the columns {reader.fieldnames}")
        # A crash may leave half a row at the end.
        whole = [line for line in reader if None not in line.values()]
    return [Row(**{name: float(text) if name in numbers else text == "true" if name == "holds" else text
                   for name, text in line.items()}) for line in whole]


def by_id(row: Row) -> tuple:
    """V2 comes before V14."""
    return tuple(int(part) if part.isdigit() else part for part in re.split(r"(\d+)", row.id))


def limits(rows: list[Row]) -> list[tuple[str, str]]:
    """Id and words of each limitation, once."""
    return list(dict.fromkeys((row.id, row.limitation) for row in rows if row.limitation))


def text_table(rows: list[Row]) -> str:
    """Aligned columns, then what the limits are."""
    cells = [HEAD, *[row.cells() for row in rows]]
    widths = [max(len(line[i]) for line in cells) for i in range(len(HEAD))]
    lines = ["  ".join(text.ljust(width) for text, width in zip(line, widths)).rstrip() for line in cells]
    return "\n".join([*lines, *[f"limit, {name}: {text}" for name, text in limits(rows)]])


def markdown_table(rows: list[Row]) -> str:
    lines = [HEAD, ["---"] * len(HEAD), *[row.cells() for row in rows]]
    table = ["| " + " | ".join(text.replace("|", "\\|") for text in line) + " |" for line in lines]
    notes = [f"- {name}: {text}" for name, text in limits(rows)]
    return "\n".join([*table, *(["", "Limits:", "", *notes] if notes else [])]) + "\n"


def write_tables(folder: Path, rows: list[Row]) -> None:
    """table.csv with every digit and table.md."""
    with (folder / "table.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [*[field.name for field in fields(Row)], "verdict"])
        writer.writeheader()
        writer.writerows([{**asdict(row), "verdict": row.verdict} for row in rows])
    (folder / "table.md").write_text(markdown_table(rows), encoding="utf-8")
