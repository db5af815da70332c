# SPDX-License-Identifier: BSD-3-Clause
"""Rows of tables that two runs have in common."""

import csv
from pathlib import Path

Row = tuple[str, ...]


def rows_without_seconds(path: Path) -> list[Row]:
    """Texts of a table's cells as they stand in the file, columns of wall time left out; names first."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    kept = [k for k, name in enumerate(rows[0]) if not name.endswith("_seconds")]
    return [tuple(row[k] for k in kept) for row in rows]


def rows_of_steps(results: Path, table: str, first: int, last: int, whole: bool = False) -> list[Row]:
    """Names, then the rows of these steps. `whole`: the results are those of a restarted run, which has no others."""
    names, *rows = rows_without_seconds(results / f"{table}.csv")
    if whole:
        return [names, *rows]
    if table == "probes":  # one row a step, after that of time 0
        return [names, *rows[first:last + 1]]
    step = names.index("step")
    return [names, *(row for row in rows if first <= int(row[step]) <= last)]
