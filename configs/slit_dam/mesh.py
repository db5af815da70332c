#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Write posts.msh, the axes of three tubes as beams, and posts.ply, their sides and tops for the soil. Lengths in m."""

from math import cos, pi, sin
from pathlib import Path

X, YS = 5.5, (0.625, 1.875, 3.125)
HEIGHT, BEAMS = 3.5, 14
RADIUS, CORNERS = 0.2032, 8  # the outline of fem_solver: an octagon in the circle


def write_beams(path: Path) -> None:
    """Groups of lines post_1, ... upwards, and of points foot_1, ..."""
    posts = range(1, len(YS) + 1)
    groups = [(0, k, f"foot_{k}") for k in posts] + [(1, len(YS) + k, f"post_{k}") for k in posts]
    nodes = [(X, y, HEIGHT * i / BEAMS) for y in YS for i in range(BEAMS + 1)]
    lines, number = [], 0
    for dimension, group, _ in groups:
        first = ((group - 1) % len(YS)) * (BEAMS + 1) + 1
        elements = [(first,)] if dimension == 0 else [(first + i, first + i + 1) for i in range(BEAMS)]
        lines.append(f"{dimension} {group} {15 if dimension == 0 else 1} {len(elements)}")
        for element in elements:
            number += 1
            lines.append(" ".join(map(str, (number, *element))))
    names = "\n".join(f'{dimension} {group} "{name}"' for dimension, group, name in groups)
    feet = "\n".join(f"{k} {X:g} {y:g} 0 1 {k}" for k, y in enumerate(YS, 1))
    curves = "\n".join(f"{len(YS) + k} 0 0 0 1 1 1 1 {len(YS) + k} 0" for k in posts)
    places = "\n".join([*map(str, range(1, len(nodes) + 1)), *(f"{x:g} {y:g} {z:g}" for x, y, z in nodes)])
    path.write_text(
        f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(groups)}\n{names}\n$EndPhysicalNames\n"
        f"$Entities\n{len(YS)} {len(YS)} 0 0\n{feet}\n{curves}\n$EndEntities\n"
        f"$Nodes\n1 {len(nodes)} 1 {len(nodes)}\n1 {len(YS) + 1} 0 {len(nodes)}\n{places}\n$EndNodes\n"
        f"$Elements\n{len(groups)} {number} 1 {number}\n" + "\n".join(lines) + "\n$EndElements\n", encoding="utf-8")


def write_surface(path: Path) -> None:
    """Triangles on the facets of the beams' outline, normals into the soil, open below."""
    vertices, triangles = [], []
    for y in YS:
        first = len(vertices)
        for i in range(BEAMS + 1):
            for k in range(CORNERS):
                angle = 2 * pi * k / CORNERS
                vertices.append((X + RADIUS * cos(angle), y + RADIUS * sin(angle), HEIGHT * i / BEAMS))
        for i in range(BEAMS):
            for k in range(CORNERS):
                a, b = first + i * CORNERS + k, first + i * CORNERS + (k + 1) % CORNERS
                triangles += [(a, b, b + CORNERS), (a, b + CORNERS, a + CORNERS)]
        top = first + BEAMS * CORNERS
        triangles += [(top, top + k, top + k + 1) for k in range(1, CORNERS - 1)]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}",
             *(f"property double {axis}" for axis in "xyz"),
             f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header",
             *(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices),
             *(f"3 {a} {b} {c}" for a, b, c in triangles)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    folder = Path(__file__).parent
    write_beams(folder / "posts.msh")
    write_surface(folder / "posts.ply")
