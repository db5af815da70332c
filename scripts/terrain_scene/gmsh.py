# SPDX-License-Identifier: BSD-3-Clause
"""Meshes as files of Gmsh."""

from pathlib import Path

import numpy as np


def write_cells(nodes: np.ndarray, cells: np.ndarray, path: Path, groups: dict[str, np.ndarray] | None = None) -> None:
    """Gmsh 4.1 as text: hexahedra or, of nodes n x 2, quadrilaterals. groups: facets m x 4 or m x 2 by the name of
    their group."""
    dim = nodes.shape[1]
    cell, facet = {2: (3, 1), 3: (5, 3)}[dim]  # numbers of Gmsh for their shapes
    nodes = np.column_stack([nodes, np.zeros((len(nodes), 3 - dim))])
    groups = groups or {}
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat"]
    if groups:
        lines += ["$PhysicalNames", str(len(groups)), *(f'{dim - 1} {k + 1} "{name}"' for k, name in enumerate(groups)),
                  "$EndPhysicalNames", "$Entities",
                  " ".join(map(str, [0] * (dim - 1) + [len(groups), 1] + [0] * (3 - dim)))]
        box = " ".join(f"{v:.9g}" for v in (*nodes.min(axis=0), *nodes.max(axis=0)))
        lines += [f"{k + 1} {box} 1 {k + 1} 0" for k in range(len(groups))] + [f"1 {box} 0 0", "$EndEntities"]
    lines += ["$Nodes", f"1 {len(nodes)} 1 {len(nodes)}", f"{dim} 1 0 {len(nodes)}",
              *(str(k + 1) for k in range(len(nodes))), *(f"{x:.12g} {y:.12g} {z:.12g}" for x, y, z in nodes),
              "$EndNodes"]
    total = len(cells) + sum(len(facets) for facets in groups.values())
    lines += ["$Elements", f"{1 + len(groups)} {total} 1 {total}"]
    tag = 0
    for kind, dimension, entity, rows in [(facet, dim - 1, k + 1, facets) for k,
                                          facets in enumerate(groups.values())] + [
            (cell, dim, 1, cells)]:
        lines.append(f"{dimension} {entity} {kind} {len(rows)}")
        for row in rows:
            tag += 1
            lines.append(f"{tag} " + " ".join(str(v + 1) for v in row))
    path.write_text("\n".join([*lines, "$EndElements", ""]), encoding="ascii")
