# SPDX-License-Identifier: BSD-3-Clause
"""Forces of supports on the structure, from the .dat that ccx writes for *NODE PRINT with RF."""

import csv
from pathlib import Path


def read_reactions(path: Path) -> list[tuple[int, float, float, float]]:
    """Node and its force [N] of all sets, in the order of the file. Raises ValueError."""
    rows, inside = [], False
    for line in path.read_text(encoding="utf-8").splitlines():
        cells = line.split()
        if line.lstrip().startswith("forces (fx,fy,fz)"):
            inside = True
        elif inside and len(cells) == 4 and cells[0].isdigit():
            rows.append((int(cells[0]), *map(float, cells[1:])))
        elif cells:
            inside = False
    if not rows:
        raise ValueError(f"{path}: found no forces of supports")
    return rows


def append_reactions(table: Path, time: float, rows: list[tuple[int, float, float, float]]) -> None:
    begin = not table.exists()
    with table.open("a", newline="", encoding="utf-8") as out:
        writer = csv.writer(out)
        if begin:
            writer.writerow(["time", "node", "fx", "fy", "fz"])
        writer.writerows([time, *row] for row in rows)
