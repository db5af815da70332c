# SPDX-License-Identifier: BSD-3-Clause
"""Wet surfaces of a model: its nodes by structure.json, the surface around them by gabion_participant."""

from dataclasses import dataclass

import numpy as np
from gabion_participant import offset_surface
from gabion_participant.offset_surface import OffsetSurface, rotation_matrices, turned

from .errors import SettingsError


@dataclass(frozen=True)
class Motion:
    """Motion of the nodes of one surface."""

    u: np.ndarray  # [m] num_nodes x dim
    angles: np.ndarray | None  # the unknowns of OpenSees: num_nodes, in 3D x 3, sums of spins; None: no rotations
    rotation: np.ndarray | None  # angles; in 3D matrices


class WetSurface:
    """tags: of its nodes in the model; surface: over them, in this order."""

    def __init__(self, name: str, tags: list[int], surface: OffsetSurface, unknowns: int) -> None:
        self.name, self.tags, self.surface = name, tags, surface
        self.dimension = surface.nodes.shape[1]
        self.has_rotations = unknowns > self.dimension
        angles = np.zeros(len(tags)) if self.dimension == 2 else np.zeros((len(tags), 3))
        rotation = angles if self.dimension == 2 else rotation_matrices(angles, 3)
        own = (angles, rotation) if self.has_rotations else (None, None)
        self.at_rest = Motion(np.zeros(surface.nodes.shape), *own)

    def motion(self, before: Motion, unknowns: np.ndarray) -> Motion:
        """Motion with these unknowns (num_nodes x all of a node), a step after `before`."""
        u = unknowns[:, :self.dimension]
        if not self.has_rotations:
            return Motion(u, None, None)
        if self.dimension == 2:
            return Motion(u, unknowns[:, 2], unknowns[:, 2])
        angles = unknowns[:, 3:6]
        return Motion(u, angles, turned(before.rotation, angles - before.angles))

    def displacement(self, motion: Motion) -> np.ndarray:
        """[m] of the points."""
        return self.surface.displacement(motion.u, motion.rotation)

    def loads(self, force: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Forces and moments, num_nodes x all unknowns of a node."""
        forces = self.surface.forces(force)
        if not self.has_rotations:
            return forces
        moments = self.surface.moments(force, arms)
        return np.column_stack([forces, moments])


class Description:
    """A model: nodes, elements, variables."""

    def __init__(self, described: dict, variables: dict) -> None:
        self.dimension: int = described["dimension"]
        self.nodes: dict[int, tuple] = described["nodes"]  # tag -> place, unknowns
        self.elements: dict[int, list[int]] = described["elements"]
        self.constrained = set(described["constrained"])
        self.version: str = described["version"]
        self.variables = variables

    def numbers(self, place: str, value: list | str) -> list:
        """A list, or the variable of the model with this name."""
        if isinstance(value, list):
            return value
        found = self.variables.get(value)
        if not isinstance(found, list):
            lists = [name for name, content in self.variables.items() if isinstance(content, list)]
            raise SettingsError(f'{place}: found "{value}", allowed: a list, or a list of numbers of the model: '
                                f"{', '.join(lists) or 'it has none'}")
        return found

    def require_nodes(self, place: str, tags: list) -> None:
        for tag in tags:
            if tag not in self.nodes:
                raise SettingsError(f"{place}: found node {tag}, allowed: a node of the model")
            if tag in self.constrained:
                raise SettingsError(f"{place}: found node {tag}, which a multi-point constraint ties to another, "
                                    "allowed: free or supported nodes, such as the retained one")

    def coordinates(self, tags: list[int]) -> np.ndarray:
        return np.array([self.nodes[tag][0] for tag in tags], dtype=float)

    def unknowns(self, place: str, tags: list[int]) -> int:
        """Number of unknowns of each of these nodes."""
        counts = {self.nodes[tag][1] for tag in tags}
        dim = self.dimension
        allowed = (dim, 3 * (dim - 1))
        if len(counts) != 1 or not counts <= set(allowed):
            raise SettingsError(f"{place}: found nodes with {', '.join(map(str, sorted(counts)))} unknowns, allowed: "
                                f"all with {allowed[0]}, or with {allowed[1]}, the rotations too")
        return counts.pop()


def make_wet_surface(described: Description, entry: dict) -> WetSurface:
    """Wet surface from an entry of "interfaces". Raises SettingsError."""
    shape = next(key for key in entry if key != "name")
    place = f'structure.json: at /interfaces: "{entry["name"]}": /{shape}'
    wanted = dict(entry[shape])
    if (shape == "line") != (described.dimension == 2):
        raise SettingsError(f"{place}: found in a model with -ndm {described.dimension}, allowed: line with 2, shell "
                            "and tube with 3")
    try:
        make = {"line": line, "shell": shell, "tube": tube}[shape]
        tags, surface = make(described, place, wanted)
    except ValueError as problem:
        raise SettingsError(f"{place}: {problem}") from problem
    return WetSurface(entry["name"], tags, surface, described.unknowns(place, tags))


def nodes_of(described: Description, place: str, value: list | str) -> tuple[list[int], np.ndarray]:
    tags = described.numbers(f"{place}/nodes", value)
    described.require_nodes(f"{place}/nodes", tags)
    if len(tags) < 2 or len(set(tags)) != len(tags):
        raise SettingsError(f"{place}/nodes: found {len(tags)} nodes, {len(set(tags))} different ones, allowed: two or "
                            "more, each once")
    return tags, described.coordinates(tags)


def line(described: Description, place: str, wanted: dict) -> tuple[list[int], OffsetSurface]:
    tags, axis = nodes_of(described, place, wanted.pop("nodes"))
    return tags, offset_surface.outline(axis, **wanted)


def tube(described: Description, place: str, wanted: dict) -> tuple[list[int], OffsetSurface]:
    tags, axis = nodes_of(described, place, wanted.pop("nodes"))
    if "rectangle" in wanted:
        section = offset_surface.rectangle(*wanted.pop("rectangle"))
    else:
        section = offset_surface.circle(*wanted.pop("circle"))
    return tags, offset_surface.tube(axis, section, **wanted)


def shell(described: Description, place: str, wanted: dict) -> tuple[list[int], OffsetSurface]:
    if "elements" in wanted:
        elements = described.numbers(f"{place}/elements", wanted.pop("elements"))
        for tag in elements:
            if tag not in described.elements:
                raise SettingsError(f"{place}/elements: found {tag}, allowed: an element of the model")
        facets = [described.elements[tag][:4] for tag in elements]
    else:
        facets = described.numbers(f"{place}/facets", wanted.pop("facets"))
    if len({len(facet) for facet in facets}) != 1 or len(facets[0]) not in (3, 4):
        raise SettingsError(f"{place}: found facets of {sorted({len(facet) for facet in facets})} nodes, allowed: all "
                            "of 3 or all of 4")
    tags = list(dict.fromkeys(tag for facet in facets for tag in facet))
    described.require_nodes(place, tags)
    index = {tag: k for k, tag in enumerate(tags)}
    numbered = np.array([[index[tag] for tag in facet] for facet in facets])
    return tags, offset_surface.shell(described.coordinates(tags), numbered, **wanted)
