# SPDX-License-Identifier: BSD-3-Clause
"""The wet facets of all ranks as one surface of linear facets that keeps every node.

Vertices and facets are numbered by their places, so that the numbers do not depend on the partition.
"""

from dataclasses import dataclass
from itertools import product

import basix
import numpy as np
from dolfinx import fem, mesh

from .model import Marker, ModelError

TIE = 1e-9  # places closer than this, by the size of the surface, have the same coordinate


@dataclass
class WetSurface:
    """coordinates [m], facets: as InterfaceMesh wants them, on all ranks the same; this rank owns `nodes` of the
    function space, which are the vertices `vertices`."""

    name: str
    coordinates: np.ndarray
    facets: np.ndarray
    nodes: np.ndarray
    vertices: np.ndarray


def make_wet_surface(V: fem.FunctionSpace, name: str, marker: Marker) -> WetSurface:
    """Raises ModelError where there is no facet."""
    domain, dim = V.mesh, V.mesh.geometry.dim
    pieces = [piece for cell, local in wet_facets(domain, marker) for piece in split_facet(V, cell, local)]
    number = V.dofmap.index_map.local_to_global
    width = len(pieces[0]) if pieces else dim
    local = np.array(pieces, dtype=np.int32).reshape(-1, width)
    places = V.tabulate_dof_coordinates()[:, :dim]
    used = np.unique(local)
    gathered = domain.comm.allgather((number(used), places[used], number(local.ravel()).reshape(local.shape)))
    parts = [part for part in gathered if len(part[0])]
    if not parts:
        raise ModelError(f'interface "{name}": found no facet of the boundary, allowed: at least one')
    nodes, first = np.unique(np.concatenate([part[0] for part in parts]), return_index=True)
    coordinates = np.concatenate([part[1] for part in parts])[first]
    order = order_of(coordinates)
    vertex = {node: k for k, node in enumerate(nodes[order].tolist())}
    facets = np.array([[vertex[node] for node in facet] for part in parts for facet in part[2].tolist()])
    owned = [(k, vertex[node]) for k, node in enumerate(number(np.arange(V.dofmap.index_map.size_local,
                                                                           dtype=np.int32)).tolist())
             if node in vertex]
    mine = np.array(owned, dtype=np.int64).reshape(-1, 2)
    return WetSurface(name, coordinates[order], in_order(facets), mine[:, 0], mine[:, 1])


def wet_facets(domain: mesh.Mesh, marker: Marker) -> list[tuple[int, int]]:
    """Cell and local number of the marked facets of the boundary that this rank owns."""
    tdim = domain.topology.dim
    for d, e in ((tdim - 1, tdim), (tdim, tdim - 1)):
        domain.topology.create_connectivity(d, e)
    outer = mesh.exterior_facet_indices(domain.topology)
    marked = np.intersect1d(outer, mesh.locate_entities_boundary(domain, tdim - 1, marker))
    cells = domain.topology.connectivity(tdim - 1, tdim)
    facets = domain.topology.connectivity(tdim, tdim - 1)
    found = []
    for facet in marked.tolist():
        cell = int(cells.links(facet)[0])
        found.append((cell, facets.links(cell).tolist().index(facet)))
    return found


def split_facet(V: fem.FunctionSpace, cell: int, local: int) -> list[tuple[int, ...]]:
    """Linear pieces between neighbouring nodes, their normals out of the cell."""
    dim = V.mesh.geometry.dim
    kind = getattr(basix.CellType, V.mesh.topology.cell_name())
    dofs = V.dofmap.cell_dofs(cell)
    places = V.tabulate_dof_coordinates()[dofs][:, :dim]
    on_facet, lattice = facet_lattice(kind, local, V.element.interpolation_points(), V.ufl_element().degree())
    node = {place: int(dofs[k]) for k, place in zip(on_facet, lattice)}
    centre = places.mean(axis=0)
    pieces = []
    for corners in lattice_pieces(set(node), V.ufl_element().degree()):
        piece = tuple(node[corner] for corner in corners)
        pieces.append(outward(V.tabulate_dof_coordinates()[list(piece)][:, :dim], centre, piece))
    return pieces


def facet_lattice(kind: basix.CellType, local: int, points: np.ndarray,
                  degree: int) -> tuple[list[int], list[tuple[int, ...]]]:
    """Nodes of the reference cell on its facet, and where they are among (degree + 1)^d places there."""
    corners = basix.geometry(kind)[basix.topology(kind)[-2][local]]
    origin, axes = corners[0], corners[1:points.shape[1]] - corners[0]
    along = (points - origin) @ np.linalg.pinv(axes)
    on_facet = np.flatnonzero(np.abs(origin + along @ axes - points).max(axis=1) < TIE)
    lattice = [tuple(place) for place in np.rint(degree * along[on_facet]).astype(int).tolist()]
    return on_facet.tolist(), lattice


def lattice_pieces(places: set[tuple[int, ...]], degree: int) -> list[tuple[tuple[int, ...], ...]]:
    """Segments, quadrilaterals, or triangles where the facet is one."""
    if len(next(iter(places))) == 1:
        return [((i,), (i + 1,)) for i in range(degree)]
    squares = [((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in product(range(degree), repeat=2)]
    if (degree, degree) in places:
        return squares
    lower = [(a, b, d) for a, b, c, d in squares if b in places and d in places]
    upper = [(b, c, d) for a, b, c, d in squares if c in places]
    return lower + upper


def outward(corners: np.ndarray, inside: np.ndarray, piece: tuple[int, ...]) -> tuple[int, ...]:
    way = corners[1] - corners[0]
    normal = np.array([way[1], -way[0]]) if len(way) == 2 else np.cross(way, corners[2] - corners[0])
    return piece if float(normal @ (corners.mean(axis=0) - inside)) > 0 else piece[::-1]


def order_of(places: np.ndarray) -> np.ndarray:
    """Order of places by x, then y, then z, where rounding does not count."""
    size = np.ptp(places, axis=0).max()
    keys = []
    for values in places.T:
        rank = np.argsort(values, kind="stable")
        steps = np.concatenate([[0], np.cumsum(np.diff(values[rank]) > TIE * size)])
        key = np.empty(len(values), dtype=np.int64)
        key[rank] = steps
        keys.append(key)
    return np.lexsort(keys[::-1])


def in_order(facets: np.ndarray) -> np.ndarray:
    """Each from its lowest vertex on, where its sense allows that, and all by their vertices."""
    if facets.shape[1] > 2:
        facets = np.array([np.roll(facet, -int(np.argmin(facet))) for facet in facets])
    return facets[np.lexsort(facets.T[::-1])]
