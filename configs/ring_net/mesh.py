#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Write net.msh: ropes of a net, posts, stays and the springs of the feet as lines, the meshes as facets. Lengths in m.

x downhill, y across, z normal to the bed. The net is in the plane x = 1, its edges are on the posts and on the bed.
"""

from pathlib import Path

WIDTH, HEIGHT = 0.8, 0.5
ACROSS, UP = 16, 10  # meshes
STUB = 0.05  # of the springs of the feet, outwards


def node(i: int, k: int) -> int:
    return 1 + i * (UP + 1) + k


def main() -> None:
    nodes = [(1.0, WIDTH * i / ACROSS, HEIGHT * k / UP) for i in range(ACROSS + 1) for k in range(UP + 1)]
    anchors, stubs = len(nodes) + 1, len(nodes) + 3
    nodes += [(0.4, 0.0, 0.0), (0.4, WIDTH, 0.0), (1.0, -STUB, 0.0), (1.0, WIDTH + STUB, 0.0)]
    posts = (0, ACROSS)
    blocks = {
        "feet": [[node(i, 0)] for i in posts],
        "bed": [[node(i, 0)] for i in range(1, ACROSS)],
        "anchors": [[n] for n in range(anchors, anchors + 2)],
        "stub_ends": [[n] for n in range(stubs, stubs + 2)],
        "across": [[node(i, k), node(i + 1, k)] for k in range(1, UP) for i in range(ACROSS)],
        "upwards": [[node(i, k), node(i, k + 1)] for i in range(1, ACROSS) for k in range(UP)],
        "top_rope": [[node(i, UP), node(i + 1, UP)] for i in range(ACROSS)],
        "posts": [[node(i, k), node(i, k + 1)] for i in posts for k in range(UP)],
        "stays": [[anchors + n, node(i, UP)] for n, i in enumerate(posts)],
        "foot_springs": [[node(i, 0), stubs + n] for n, i in enumerate(posts)],
        # normals uphill
        "net": [[node(i, k), node(i, k + 1), node(i + 1, k + 1), node(i + 1, k)]
                for i in range(ACROSS) for k in range(UP)],
    }
    dimension = {1: 0, 2: 1, 4: 2}  # by the number of nodes
    kinds = {0: 15, 1: 1, 2: 3}  # Gmsh's
    groups = [(dimension[len(members[0])], number, name) for number, (name, members) in enumerate(blocks.items(), 1)]
    names = "\n".join(f'{d} {number} "{name}"' for d, number, name in groups)
    entities = "\n".join(f"{number} 0 0 0 {'1 1 1 ' if d else ''}1 {number}{' 0' if d else ''}"
                         for d, number, _ in groups)
    counts = " ".join(str(sum(d == each for d, _, _ in groups)) for each in range(4))
    places = "\n".join([*(str(n) for n in range(1, len(nodes) + 1)),
                        *(" ".join(f"{x:.10g}" for x in place) for place in nodes)])
    lines, number = [], 0
    for d, group, name in groups:
        lines.append(f"{d} {group} {kinds[d]} {len(blocks[name])}")
        for element in blocks[name]:
            number += 1
            lines.append(" ".join(map(str, (number, *element))))
    last = groups[-1][1]
    Path(__file__).with_name("net.msh").write_text(
        f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(groups)}\n{names}\n$EndPhysicalNames\n"
        f"$Entities\n{counts}\n{entities}\n$EndEntities\n"
        f"$Nodes\n1 {len(nodes)} 1 {len(nodes)}\n2 {last} 0 {len(nodes)}\n{places}\n$EndNodes\n"
        f"$Elements\n{len(groups)} {number} 1 {number}\n" + "\n".join(lines) + "\n$EndElements\n", encoding="utf-8")


if __name__ == "__main__":
    main()
