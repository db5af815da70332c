#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Write levee.msh: a levee on its ground, quadrilaterals in upright columns. Lengths in m."""

from pathlib import Path

PROFILE = [(0.0, 1.0), (4.0, 1.0), (7.5, 3.0), (9.0, 3.0), (12.5, 1.0), (16.0, 1.0)]
COLUMNS, ROWS = 64, 12


def top(x: float) -> float:
    """Height of the ground or the levee."""
    for (x0, z0), (x1, z1) in zip(PROFILE, PROFILE[1:]):
        if x <= x1:
            return z0 + (z1 - z0) * (x - x0) / (x1 - x0)
    return PROFILE[-1][1]


def main() -> None:
    width = PROFILE[-1][0] / COLUMNS
    corners = [(i * width, top(i * width) * j / ROWS) for i in range(COLUMNS + 1) for j in range(ROWS + 1)]
    tag = {(i, j): i * (ROWS + 1) + j + 1 for i in range(COLUMNS + 1) for j in range(ROWS + 1)}
    cells = [(tag[i, j], tag[i + 1, j], tag[i + 1, j + 1], tag[i, j + 1])
             for i in range(COLUMNS) for j in range(ROWS)]
    nodes = "\n".join([*(str(n) for n in range(1, len(corners) + 1)), *(f"{x:.10g} {z:.10g} 0" for x, z in corners)])
    lines = "\n".join(" ".join(map(str, (number, *cell))) for number, cell in enumerate(cells, 1))
    Path(__file__).with_name("levee.msh").write_text(
        f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 1 0 0\n$EndEntities\n"
        f"$Nodes\n1 {len(corners)} 1 {len(corners)}\n2 1 0 {len(corners)}\n{nodes}\n$EndNodes\n"
        f"$Elements\n1 {len(cells)} 1 {len(cells)}\n2 1 3 {len(cells)}\n{lines}\n$EndElements\n", encoding="utf-8")


if __name__ == "__main__":
    main()
