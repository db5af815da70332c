#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Write wall.msh: a post in a socket, quadrilaterals in two groups of cells. Lengths in m."""

from pathlib import Path

POST = (16.0, 16.24)
XS = [15.5, 15.75, *(16.0 + 0.08 * i for i in range(4)), 16.49, 16.74]
YS = [-1.0 + 0.125 * i for i in range(29)]  # the ground at 0, the crest at 2.5
GROUPS = ((1, 1, "foot"), (1, 2, "front"), (1, 3, "crest"), (1, 4, "back"), (2, 5, "post"), (2, 6, "socket"))


def quads() -> list[tuple[int, int]]:
    """Places (i, j) of the cells: all below the ground, those of the post above it."""
    return [(i, j) for j in range(len(YS) - 1) for i in range(len(XS) - 1) if YS[j] < -1e-9 or is_post(i)]


def is_post(i: int) -> bool:
    return POST[0] - 1e-9 < XS[i] < POST[1] - 1e-9


def main() -> None:
    cells = quads()
    corners = sorted({(i + a, j + b) for i, j in cells for a in (0, 1) for b in (0, 1)}, key=lambda c: (c[1], c[0]))
    tag = {corner: n for n, corner in enumerate(corners, 1)}
    first, last = XS.index(POST[0]), min(range(len(XS)), key=lambda i: abs(XS[i] - POST[1]))
    ground, top, right = 8, len(YS) - 1, len(XS) - 1
    blocks = {
        "foot": [((i, 0), (i + 1, 0)) for i in range(right)]
        + [((i, j), (i, j + 1)) for i in (0, right) for j in range(ground)],
        "front": [((first, j), (first, j + 1)) for j in range(ground, top)],
        "crest": [((i, top), (i + 1, top)) for i in range(first, last)],
        "back": [((last, j), (last, j + 1)) for j in range(ground, top)],
        "post": [((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in cells if is_post(i)],
        "socket": [((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in cells if not is_post(i)],
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
        f"$Entities\n0 4 2 0\n{entities}\n$EndEntities\n"
        f"$Nodes\n1 {len(corners)} 1 {len(corners)}\n2 5 0 {len(corners)}\n{nodes}\n$EndNodes\n"
        f"$Elements\n{len(GROUPS)} {number} 1 {number}\n" + "\n".join(lines) + "\n$EndElements\n", encoding="utf-8")


if __name__ == "__main__":
    main()
