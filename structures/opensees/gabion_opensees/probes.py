# SPDX-License-Identifier: BSD-3-Clause
"""Columns of probes.csv: nodes, points of a wet surface, responses of elements."""

import numpy as np
from gabion_participant import InterfaceValues

from .errors import SettingsError
from .wet_surface import Description, WetSurface


class Probes:
    """Values in the accepted state, by the order of structure.json."""

    def __init__(self, wanted: tuple[dict, ...], described: Description, surfaces: list[WetSurface],
                 wet: list[int]) -> None:
        self.wanted, self.dimension = wanted, described.dimension
        self.nodes = list(wet)  # those whose motion is to be read, wet ones first
        self.orders: list[tuple[int, list[str]]] = []  # elements and responses
        self.points: dict[str, int] = {}  # probe -> vertex
        self.names: list[str] = []
        self.values: list[float] = []
        for probe in wanted:
            place = f'structure.json: at /probes: "{probe["name"]}"'
            if "node" in probe:
                if probe["node"] not in described.nodes:
                    raise SettingsError(f"{place}: found node {probe['node']}, allowed: a node of the model")
                self.nodes.append(probe["node"])
            elif "element" in probe:
                if probe["element"] not in described.elements:
                    raise SettingsError(f"{place}: found element {probe['element']}, allowed: an element of the model")
                self.orders.append((probe["element"], [str(word) for word in probe["response"]]))
            else:
                self.points[probe["name"]] = self.nearest(place, probe, surfaces)

    def nearest(self, place: str, probe: dict, surfaces: list[WetSurface]) -> int:
        for surface in surfaces:
            if surface.name == probe["interface"]:
                away = np.linalg.norm(surface.surface.coordinates - np.array(probe["point"], dtype=float), axis=1)
                if away.min() > 1e-6 * np.ptp(surface.surface.coordinates, axis=0).max():
                    raise SettingsError(f"{place}: found no vertex at {probe['point']}, allowed: one; the next one is "
                                        f"{surface.surface.coordinates[away.argmin()].tolist()}")
                return int(away.argmin())
        raise SettingsError(f'{place}: found interface "{probe["interface"]}", allowed: '
                            f"{', '.join(surface.name for surface in surfaces)}")

    def update(self, moved: InterfaceValues, of_nodes: list[list[float]], of_elements: list[list[float]]) -> None:
        """moved: of the vertices; of_nodes: unknowns in the order of `nodes`; of_elements: of `orders`."""
        names: list[str] = []
        values: list[float] = []
        nodes = iter(of_nodes[len(of_nodes) - sum("node" in probe for probe in self.wanted):])
        elements = iter(of_elements)
        for probe in self.wanted:
            name = probe["name"]
            if "element" in probe:
                found = next(elements)
                if not found:
                    raise SettingsError(f'structure.json: at /probes: "{name}": found response {probe["response"]} of '
                                        f"element {probe['element']}, allowed: one that it has")
                names += [name] if len(found) == 1 else [f"{name}.{k}" for k in range(1, len(found) + 1)]
                values += found
                continue
            found = next(nodes)[:self.dimension] if "node" in probe else \
                moved[probe["interface"]][self.points[name]].tolist()
            names += [f"{name}.u{axis}" for axis in "xyz"[:self.dimension]]
            values += found
        self.names, self.values = names, values
