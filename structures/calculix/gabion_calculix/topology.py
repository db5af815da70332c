# SPDX-License-Identifier: BSD-3-Clause
"""Element types of CalculiX: how many nodes, which faces, how a face becomes linear facets."""

# Number of nodes by the type's name without its variants (R, I, T, ... at the end).
NUM_NODES = {
    "C3D4": 4, "C3D6": 6, "C3D8": 8, "C3D10": 10, "C3D15": 15, "C3D20": 20,
    "S3": 3, "S4": 4, "S6": 6, "S8": 8, "M3D3": 3, "M3D4": 4, "M3D6": 6, "M3D8": 8,
    "CPE3": 3, "CPE4": 4, "CPE6": 6, "CPE8": 8, "CPS3": 3, "CPS4": 4, "CPS6": 6, "CPS8": 8,
    "CAX3": 3, "CAX4": 4, "CAX6": 6, "CAX8": 8,
    "B21": 2, "B31": 2, "B32": 3, "T2D2": 2, "T3D2": 2, "T3D3": 3,
    "SPRINGA": 2, "SPRING1": 1, "SPRING2": 2, "DASHPOTA": 2, "GAPUNI": 2, "MASS": 1, "DCOUP3D": 1,
}
VARIANTS = {"C3D8R", "C3D8I", "C3D10T", "C3D20R", "C3D20RI", "S4R", "S8R", "M3D4R", "M3D8R", "CPE4R", "CPE8R",
            "CPS4R", "CPS8R", "CAX4R", "CAX8R", "B31R", "B32R"}

# Corners of the faces of solids, numbered from 0, in the order S1, S2, ...
TETRAHEDRON = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
WEDGE = ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
HEXAHEDRON = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
# Nodes in the middle of edges of quadratic elements, by the two corners of the edge.
TETRAHEDRON_MIDDLE = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}
WEDGE_MIDDLE = {(0, 1): 6, (1, 2): 7, (0, 2): 8, (3, 4): 9, (4, 5): 10, (3, 5): 11, (0, 3): 12, (1, 4): 13, (2, 5): 14}
HEXAHEDRON_MIDDLE = {(0, 1): 8, (1, 2): 9, (2, 3): 10, (0, 3): 11, (4, 5): 12, (5, 6): 13, (6, 7): 14, (4, 7): 15,
                     (0, 4): 16, (1, 5): 17, (2, 6): 18, (3, 7): 19}
SOLIDS = {
    "C3D4": (TETRAHEDRON, {}), "C3D10": (TETRAHEDRON, TETRAHEDRON_MIDDLE),
    "C3D6": (WEDGE, {}), "C3D15": (WEDGE, WEDGE_MIDDLE),
    "C3D8": (HEXAHEDRON, {}), "C3D20": (HEXAHEDRON, HEXAHEDRON_MIDDLE),
}
# Triangles of faces of 6 and 8 nodes: corners first, then the middles after each corner.
SPLIT = {
    3: ((0, 1, 2),),
    4: ((0, 1, 2), (0, 2, 3)),
    6: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    8: ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)),
}


def base_type(name: str) -> str | None:
    """`C3D20` of `C3D20R`; None: not known."""
    if name in NUM_NODES:
        return name
    if name in VARIANTS:
        return name.rstrip("RIT")
    return None


def is_shell(base: str) -> bool:
    return base in ("S3", "S4", "S6", "S8")


def is_plane(base: str) -> bool:
    return base.startswith(("CPE", "CPS"))


def edges(base: str) -> list[tuple[int, ...]]:
    """Edges of a plane element, in the order S1, S2, ...: two corners, and the middle if there is one."""
    count = NUM_NODES[base]
    corners = 3 if count in (3, 6) else 4
    found = [(k, (k + 1) % corners) for k in range(corners)]
    return [(*edge, corners + k) for k, edge in enumerate(found)] if count > corners else found


def faces(base: str) -> list[tuple[int, ...]]:
    """Faces of a solid, in the order S1, S2, ...: corners, and the middles after them."""
    corners, middle = SOLIDS[base]
    return [face + tuple(middle[tuple(sorted((a, b)))] for a, b in zip(face, face[1:] + face[:1]) if middle)
            for face in corners]
