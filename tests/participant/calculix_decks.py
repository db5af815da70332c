# SPDX-License-Identifier: BSD-3-Clause
"""Small decks for tests: a cantilever along x, of every kind of element."""

import json
from pathlib import Path

LENGTH, WIDTH, HEIGHT = 1.0, 0.1, 0.05  # [m] along x, z, y
YOUNG, DENSITY = 1e7, 1000.0  # [Pa], [kg/m3]
AREA, INERTIA = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12  # [m2], [m4]: bends in y

MATERIAL = f"*MATERIAL, NAME=M\n*ELASTIC\n{YOUNG}, 0\n*DENSITY\n{DENSITY}\n"
SECTIONS = {
    "C3D": "*SOLID SECTION, ELSET=ALL, MATERIAL=M\n",
    "S": f"*SHELL SECTION, ELSET=ALL, MATERIAL=M\n{HEIGHT}\n",
    "B": f"*BEAM SECTION, ELSET=ALL, MATERIAL=M, SECTION=RECT\n{WIDTH}, {HEIGHT}\n0, 0, 1\n",
    "CPE": f"*SOLID SECTION, ELSET=ALL, MATERIAL=M\n{WIDTH}\n",
}


def numbered(rows: list[str]) -> str:
    return "".join(f"{number}, {row}\n" for number, row in enumerate(rows, 1))


def lattice(counts: tuple[int, int, int], size: tuple[float, float, float]) -> str:
    """Nodes, x fastest; y and z around 0."""
    nx, ny, nz = counts
    return "*NODE\n" + numbered([
        f"{size[0] * i / max(nx - 1, 1)}, {size[1] * (j / max(ny - 1, 1) - 0.5)}, "
        f"{size[2] * (k / max(nz - 1, 1) - 0.5)}"
        for k in range(nz) for j in range(ny) for i in range(nx)])


def solid(n: int = 10) -> str:
    """C3D20, one element over the height and the width; wet on the top."""
    def node(i: int, j: int, k: int) -> int:
        return 1 + i + (2 * n + 1) * (j + 3 * k)

    corners = [(0, 0, 2), (2, 0, 2), (2, 0, 0), (0, 0, 0), (0, 2, 2), (2, 2, 2), (2, 2, 0), (0, 2, 0)]
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    shape = corners + [tuple((a + b) // 2 for a, b in zip(corners[p], corners[q])) for p, q in pairs]
    rows = [", ".join(str(node(2 * e + i, j, k)) for i, j, k in shape[:12]) + ",\n"  # at most 16 cells a line
            + ", ".join(str(node(2 * e + i, j, k)) for i, j, k in shape[12:]) for e in range(n)]
    foot = ", ".join(str(node(0, j, k)) for j in range(3) for k in range(3) if (j, k) != (1, 1))
    return deck("C3D20", lattice((2 * n + 1, 3, 3), (LENGTH, HEIGHT, WIDTH)), rows, f"*NSET, NSET=FOOT\n{foot}\n",
                "ALL, S5\n")


def shell(kind: str = "S8R", n: int = 10) -> str:
    """A shell in the plane y = 0, one element across; wet on both sides is one side: SPOS."""
    per = 2 if kind == "S8R" else 1

    def node(i: int, k: int) -> int:
        return 1 + i + (per * n + 1) * k

    corners = [(0, 0), (per, 0), (per, per), (0, per)]
    middle = [(1, 0), (2, 1), (1, 2), (0, 1)] if per == 2 else []
    rows = [", ".join(str(node(per * e + i, k)) for i, k in corners + middle) for e in range(n)]
    nodes = lattice((per * n + 1, 1, per + 1), (LENGTH, 0, WIDTH))
    foot = ", ".join(str(node(0, k)) for k in range(per + 1))
    return deck(kind, nodes, rows, f"*NSET, NSET=FOOT\n{foot}\n", "ALL, SPOS\n", rotations=True)


def beam(kind: str = "B32", n: int = 10) -> str:
    per = 2 if kind == "B32" else 1
    rows = [", ".join(str(1 + per * e + i) for i in range(per + 1)) for e in range(n)]
    nodes = lattice((per * n + 1, 1, 1), (LENGTH, 0, 0)) + f"*NSET, NSET=LINE, GENERATE\n1, {per * n + 1}\n"
    return deck(kind, nodes, rows, "*NSET, NSET=FOOT\n1\n", "LINE\n", rotations=True)


def plane(kind: str = "CPE8R", n: int = 10, section: str = SECTIONS["CPE"]) -> str:
    """Per WIDTH of thickness; wet on the top, and at the end."""
    def node(i: int, j: int) -> int:
        return 1 + i + (2 * n + 1) * j

    shape = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    rows = [", ".join(str(node(2 * e + i, j)) for i, j in shape) for e in range(n)]
    foot = ", ".join(str(node(0, j)) for j in range(3))
    text = deck(kind, lattice((2 * n + 1, 3, 1), (LENGTH, HEIGHT, 0)), rows, f"*NSET, NSET=FOOT\n{foot}\n",
                f"ALL, S3\n{n}, S2\n")
    return text.replace(SECTIONS["CPE"], section)


def two_bars(gap: float, contact: float) -> str:
    """Two cubes of 0.1 m in a row, LENGTH of each; the first one's end is wet and may come to the second one, whose far
    end is held. gap [m]; contact: pressure by overclosure [N/m3]."""
    side = 0.1
    rows = [f"{x}, {y}, {z}" for x in (0, side, side + gap, 2 * side + gap) for z in (0, side) for y in (0, side)]
    # C3D8 along x: faces S1 at its beginning, S2 at its end
    cells = [", ".join(str(8 * k + node) for node in (1, 2, 4, 3, 5, 6, 8, 7)) for k in range(2)]
    return ("*NODE\n" + numbered(rows) + "*ELEMENT, TYPE=C3D8, ELSET=ALL\n" + numbered(cells)
            + "*NSET, NSET=HELD\n1, 2, 3, 4, 13, 14, 15, 16\n*NSET, NSET=EVERY, GENERATE\n1, 16\n"
            + "*SURFACE, NAME=WET\n1, S2\n*SURFACE, NAME=OTHER\n2, S1\n" + MATERIAL + SECTIONS["C3D"]
            + "*SURFACE INTERACTION, NAME=TOUCH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
            + f"{contact:g}\n*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE\nWET, OTHER\n"
            + "*BOUNDARY\nHELD, 1\nEVERY, 2, 3\n")


def deck(kind: str, nodes: str, elements: list[str], foot: str, wet: str, rotations: bool = False) -> str:
    section = next(text for name, text in SECTIONS.items() if kind.startswith(name))
    surface = "*SURFACE, NAME=WET, TYPE=NODE\n" if kind.startswith("B") else "*SURFACE, NAME=WET\n"
    return (nodes + f"*ELEMENT, TYPE={kind}, ELSET=ALL\n" + numbered(elements) + foot + surface + wet + MATERIAL
            + section + f"*BOUNDARY\nFOOT, 1, {6 if rotations else 3}\n")


def write(folder: Path, text: str, **settings) -> Path:
    """Deck and structure.json, whose path is returned."""
    (folder / "deck.inp").write_text(text, encoding="utf-8")
    path = folder / "structure.json"
    path.write_text(json.dumps({"deck": "deck.inp", "interfaces": [{"name": "wall", "surface": "WET"}]} | settings))
    return path
