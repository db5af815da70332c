#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Write wall.msh: a wall on a footing, two groups of quadrilaterals, two layers of bars, links. Lengths in m."""

from pathlib import Path

H = 0.0625  # of the cells; the bars are one cell below the faces
XS = [15.5, 15.75, *(16 + H * i for i in range(9)), 16.75, 17.0]
YS = [-0.5 + H * j for j in range(49)]  # the ground at 0, the crest at 2.5
WALL = (16.0, 16.5)
GROUPS = (
    (1, 1, "foot"), (1, 2, "front"), (1, 3, "crest"), (1, 4, "back"),
    (1, 5, "bars_front"), (1, 6, "bars_back"), (1, 7, "links"), (2, 8, "wall"), (2, 9, "footing"),
)


def main() -> None:
    ground, top, right = 8, len(YS) - 1, len(XS) - 1
    first, last = XS.index(WALL[0]), XS.index(WALL[1])
    cells = [(i, j) for j in range(top) for i in range(right) if j < ground or first <= i < last]
    corners = sorted({(i + a, j + b) for i, j in cells for a in (0, 1) for b in (0, 1)}, key=lambda c: (c[1], c[0]))
    tag = {corner: n for n, corner in enumerate(corners, 1)}

    def upwards(i: int, low: int, high: int) -> list:
        return [((i, j), (i, j + 1)) for j in range(low, high)]

    def quads(of_wall: bool) -> list:
        return [((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in cells
                if (j >= ground) == of_wall]

    blocks = {
        "foot": [((i, 0), (i + 1, 0)) for i in range(right)] + upwards(0, 0, ground) + upwards(right, 0, ground),
        "front": upwards(first, ground, top),
        "crest": [((i, top), (i + 1, top)) for i in range(first, last)],
        "back": upwards(last, ground, top),
        "bars_front": upwards(first + 1, 1, top - 1),
        "bars_back": upwards(last - 1, 1, top - 1),
        "links": [((i, j), (i + 1, j)) for j in range(ground + 2, top, 4) for i in range(first + 1, last - 1)],
        "wall": quads(of_wall=True),
        "footing": quads(of_wall=False),
    }
    names = "\n".join(f'{dimension} {number} "{name}"' for dimension, number, name in GROUPS)
    entities = "\n".join(f"{number} 0 0 0 1 1 1 1 {number} 0" for _, number, _ in GROUPS)
    nodes = "\n".join([*(str(n) for n in range(1, len(corners) + 1)),
                       *(f"{XS[i]:.10g} {YS[j]:.10g} 0" for i, j in corners)])
    lines, number = [], 0
    for dimension, group, name in GROUPS:
        lines.append(f"{dimension} {group} {1 if dimension == 1 else 3} {len(blocks[name])}")
        for element in blocks[name]:
            number += 1
            lines.append(" ".join(map(str, (number, *(tag[corner] for corner in element)))))
    Path(__file__).with_name("wall.msh").write_text(
        f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(GROUPS)}\n{names}\n$EndPhysicalNames\n"
        f"$Entities\n0 7 2 0\n{entities}\n$EndEntities\n"
        f"$Nodes\n1 {len(corners)} 1 {len(corners)}\n2 8 0 {len(corners)}\n{nodes}\n$EndNodes\n"
        f"$Elements\n{len(GROUPS)} {number} 1 {number}\n" + "\n".join(lines) + "\n$EndElements\n", encoding="utf-8")


if __name__ == "__main__":
    main()
