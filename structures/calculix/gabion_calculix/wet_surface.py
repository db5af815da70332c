# SPDX-License-Identifier: BSD-3-Clause
"""The wet surface: a *SURFACE or an element set of the deck as vertices and linear facets.

Facets of solids and plane elements point out of the element; those of shells along the normal (SPOS, and an element
set) or against it (SNEG). Faces with nodes in the middle of their edges become several linear facets, all nodes kept.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .deck import Deck, DeckError, Element, Line, Surface
from .topology import SOLIDS, SPLIT, edges, faces, is_plane, is_shell


@dataclass(frozen=True)
class WetSurface:
    name: str  # of the interface
    dimension: int
    nodes: np.ndarray  # numbers in the deck
    coordinates: np.ndarray  # [m], num_nodes x dimension
    facets: np.ndarray | None  # num_facets x 2, 3 or 4 vertex numbers; None: bare points
    thickness: float  # [m] of plane elements; 1 in 3D: forces of the coupler times this are those of ccx


@dataclass(frozen=True)
class Face:
    element: Element
    nodes: tuple[int, ...]  # numbers in the deck: corners, middles
    against_normal: bool = False  # of shells


def make_wet_surface(deck: Deck, name: str, surface: str, element_set: str) -> WetSurface:
    """Wet surface from the *SURFACE or the element set with this name; the other name is empty. Raises DeckError."""
    if element_set:
        return of_faces(deck, name, list(faces_of_set(deck, element_set)), element_set)
    if surface not in deck.surfaces:
        raise DeckError(f"{deck.path}: found no *SURFACE, NAME={surface}, allowed: "
                        f"{', '.join(deck.surfaces) or 'none'}")
    found = deck.surfaces[surface]
    if found.of_nodes:
        return of_nodes(deck, name, found)
    return of_faces(deck, name, list(faces_of_surface(deck, found)), surface)


def faces_of_surface(deck: Deck, surface: Surface) -> Iterator[Face]:
    for line, cells in surface.entries:
        if len(cells) != 2:
            raise line.error(f'"{line.text}"', "ELEMENT, FACE or ELEMENT SET, FACE")
        for number in deck.elements_of(line, cells[0]):
            yield face_of(line, deck.elements[number], cells[1])


def face_of(line: Line, element: Element, label: str) -> Face:
    """Face of an element with a label such as S3, SPOS."""
    kind = element.type
    if is_shell(kind):
        if label not in ("SPOS", "SNEG", "S1", "S2"):
            raise line.error(f"face {label} of a shell", "SPOS, SNEG (edges of shells are no wet surface)")
        return Face(element, element.nodes, label in ("SNEG", "S1"))
    if is_plane(kind):
        choice = edges(kind)
    elif kind in SOLIDS:
        choice = faces(kind)
    else:
        raise line.error(f"an element of type {kind}",
                         "solids C3D, shells S, plane CPE and CPS (others through a *SURFACE, TYPE=NODE)")
    labels = [f"S{k + 1}" for k in range(len(choice))]
    if label not in labels:
        raise line.error(f"face {label} of {kind}", ", ".join(labels))
    return Face(element, tuple(element.nodes[k] for k in choice[labels.index(label)]))


def faces_of_set(deck: Deck, name: str) -> Iterator[Face]:
    """All shells; of solids and plane elements the faces that no other element of the deck shares."""
    if name not in deck.element_sets:
        raise DeckError(f'{deck.path}: found no element set {name}, allowed: {", ".join(deck.element_sets) or "none"}')
    shared = Counter(tuple(sorted(face.nodes)) for element in deck.elements.values() for face in all_faces(element))
    for number in dict.fromkeys(deck.element_sets[name]):
        element = deck.elements[number]
        if is_shell(element.type):
            yield Face(element, element.nodes)
            continue
        found = list(all_faces(element))
        if not found:
            raise DeckError(f"{deck.path}: found element {number} of type {element.type} in {name}, allowed: solids, "
                            "shells, plane elements (others through a *SURFACE, TYPE=NODE)")
        yield from (face for face in found if shared[tuple(sorted(face.nodes))] == 1)


def all_faces(element: Element) -> Iterator[Face]:
    """None of shells, beams and others."""
    if is_plane(element.type):
        choice = edges(element.type)
    elif element.type in SOLIDS:
        choice = faces(element.type)
    else:
        choice = []
    for face in choice:
        yield Face(element, tuple(element.nodes[k] for k in face))


def of_faces(deck: Deck, name: str, wet: list[Face], source: str) -> WetSurface:
    if not wet:
        raise DeckError(f"{deck.path}: found no face in {source}, allowed: at least one")
    plane = {is_plane(face.element.type) for face in wet}
    if len(plane) > 1:
        raise DeckError(f"{deck.path}: found plane elements and others in {source}, allowed: one kind")
    dimension = 2 if plane.pop() else 3
    nodes = np.array(list(dict.fromkeys(node for face in wet for node in face.nodes)))
    vertex = {node: k for k, node in enumerate(nodes.tolist())}
    pieces = split_2d(wet) if dimension == 2 else split_3d(wet)
    facets = np.array([[vertex[node] for node in oriented(deck, face, piece)] for face, piece in pieces])
    thickness = thickness_of(deck, set(nodes.tolist())) if dimension == 2 else 1.0
    return WetSurface(name, dimension, nodes, coordinates_of(deck, nodes, dimension), facets, thickness)


def of_nodes(deck: Deck, name: str, surface: Surface) -> WetSurface:
    numbers = [node for line, cells in surface.entries for node in deck.nodes_of(line, cells[0])]
    nodes = np.array(list(dict.fromkeys(numbers)))
    if not len(nodes):
        raise surface.line.error("no node", "at least one")
    wet = set(nodes.tolist())
    if loose := sorted(wet - {node for element in deck.elements.values() for node in element.nodes}):
        raise surface.line.error(f"node {loose[0]}, which no element has (a reference node)", "nodes of elements")
    of_plane = [is_plane(element.type) for element in deck.elements.values() if wet & set(element.nodes)]
    if any(of_plane) and not all(of_plane):
        raise surface.line.error("nodes of plane elements and of others", "one kind")
    dimension = 2 if any(of_plane) else 3
    thickness = thickness_of(deck, wet) if dimension == 2 else 1.0
    return WetSurface(name, dimension, nodes, coordinates_of(deck, nodes, dimension), None, thickness)


def coordinates_of(deck: Deck, nodes: np.ndarray, dimension: int) -> np.ndarray:
    return np.array([deck.nodes[node] for node in nodes.tolist()])[:, :dimension]


def thickness_of(deck: Deck, wet: set[int]) -> float:
    """[m] of all plane elements at these nodes."""
    touching = {number for number, element in deck.elements.items() if wet & set(element.nodes)}
    found = {value for name, value in deck.sections if touching & set(deck.element_sets.get(name, []))}
    if len(found) != 1:
        raise DeckError(f"{deck.path}: found thicknesses {sorted(found)} at the wet surface, allowed: one for all its "
                        "elements (data line of *SOLID SECTION)")
    return found.pop()


def split_2d(wet: list[Face]) -> list[tuple[Face, tuple[int, ...]]]:
    """Edges in two halves where they have a middle."""
    pieces = []
    for face in wet:
        first, last, *middle = face.nodes
        way = [first, *middle, last]
        pieces += [(face, pair) for pair in zip(way, way[1:])]
    return pieces


def split_3d(wet: list[Face]) -> list[tuple[Face, tuple[int, ...]]]:
    """Triangles, or quadrilaterals where all faces have four nodes."""
    if all(len(face.nodes) == 4 for face in wet):
        return [(face, face.nodes) for face in wet]
    return [(face, tuple(face.nodes[k] for k in piece)) for face in wet for piece in SPLIT[len(face.nodes)]]


def oriented(deck: Deck, face: Face, piece: tuple[int, ...]) -> tuple[int, ...]:
    """The facet with its normal out of the element, or on the wanted side of a shell."""
    if is_shell(face.element.type):
        return piece[::-1] if face.against_normal else piece
    corners = np.array([deck.nodes[node] for node in piece])
    inside = np.mean([deck.nodes[node] for node in face.element.nodes], axis=0)
    out = np.mean(corners, axis=0) - inside
    way = corners[1] - corners[0]
    normal = np.array([way[1], -way[0], 0.0]) if len(piece) == 2 else np.cross(way, corners[2] - corners[0])
    return piece if float(normal @ out) > 0 else piece[::-1]
