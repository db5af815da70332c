# SPDX-License-Identifier: BSD-3-Clause
"""Section forces of beams, from a .frd in which ccx writes them in place of stresses (*EL FILE, SECTION FORCES)."""

import csv
from pathlib import Path

from .deck import Deck

# Columns of the block STRESS: SXX, SYY, SZZ, SXY, SYZ, SZX (ccx 2.20, *EL FILE). [N], [N m]
COLUMNS = ("shear_1", "shear_2", "normal", "torque", "moment_1", "moment_2")
CELL = 12  # characters of a number
FIRST = 13  # characters of a row before its numbers: " -1" and the node


def beam_nodes(deck: Deck) -> list[int]:
    return sorted({node for element in deck.elements.values() if element.type.startswith("B")
                   for node in element.nodes})


def read_section_forces(path: Path, nodes: list[int]) -> dict[int, list[float]]:
    """Node -> forces of the section, its axes 1 and 2 those of *BEAM SECTION. Raises ValueError."""
    found: dict[int, list[float]] = {}
    wanted, inside = set(nodes), False
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith(" -4"):
            inside = line.split()[1] == "STRESS"
        elif inside and line.startswith(" -1") and int(line[3:FIRST]) in wanted:
            found[int(line[3:FIRST])] = [float(line[k:k + CELL]) for k in range(FIRST, FIRST + 6 * CELL, CELL)]
    if missing := sorted(wanted - found.keys()):
        raise ValueError(f"{path}: found no section forces at node {missing[0]}, allowed: all nodes of beams")
    return found


def append_section_forces(table: Path, time: float, forces: dict[int, list[float]]) -> None:
    begin = not table.exists()
    with table.open("a", newline="", encoding="utf-8") as out:
        writer = csv.writer(out)
        if begin:
            writer.writerow(["time", "node", *COLUMNS])
        writer.writerows([time, node, *row] for node, row in forces.items())
