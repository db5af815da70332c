# SPDX-License-Identifier: BSD-3-Clause
"""The parts of a precice-config.xml that precice_names needs: meshes, data, who reads and writes what.

Scheme, mappings and communication of that file have no effect here: coupler.json has them
(docs/precice_names.md).
"""

import json
import xml.sax
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .errors import UsageError
from .handshake import UNITS

OWN_NAMES = "gabion_names.json"  # beside precice-config.xml, optional: names here -> names there
OWN_KEYS = ("participants", "interfaces", "quantities")


class NotMapped(UsageError):
    """A feature of preCICE that Gabion lacks. The message says what takes its place."""


@dataclass
class CoupledMesh:
    """A mesh that the participant provides; reads, writes: data -> quantity, force or displacement."""

    name: str
    dimension: int
    interface: str  # in coupler.json
    needs_connectivity: bool  # a mapping by projection names it
    reads: dict[str, str] = field(default_factory=dict)
    writes: dict[str, str] = field(default_factory=dict)


@dataclass
class PreciceConfig:
    """Settings of one participant. max_time, window: [s] as the file has them, None without; only
    compared."""

    path: Path
    participant: str  # in coupler.json
    meshes: dict[str, CoupledMesh]
    receives: str  # force of a structure, displacement of a soil
    dimension: int
    max_time: float | None
    window: float | None


class _Elements(xml.sax.ContentHandler):
    """The elements in their order, each with the name of the participant that it is in. The file's
    prefixes, as in data:vector, are never declared: so no namespaces."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str], str]] = []
        self._participant = ""

    def startElement(self, name: str, attributes: Mapping[str, str]) -> None:
        if name == "participant":
            self._participant = attributes.get("name", "")
        self.found.append((name, dict(attributes), self._participant))

    def endElement(self, name: str) -> None:
        if name == "participant":
            self._participant = ""


def read_config(path: str | Path, participant: str) -> PreciceConfig:
    """Raises UsageError for a file that cannot be read or does not name this participant, NotMapped for features that
    the coupling of a soil and a structure lacks."""
    path = Path(path)
    elements = _Elements()
    try:
        xml.sax.parse(str(path), elements)
    except (OSError, xml.sax.SAXException, ValueError) as problem:
        raise UsageError(f"{path}: cannot be read as precice-config.xml: {problem}") from problem
    if any(name == "solver-interface" for name, _, _ in elements.found):
        raise NotMapped(f"{path}: found solver-interface, of preCICE 2; allowed: one of preCICE 3")
    return _Reader(path, participant, elements.found).config()


class _Reader:
    """Collects the settings of one participant."""

    def __init__(self, path: Path, participant: str, elements: list[tuple[str, dict[str, str], str]]) -> None:
        self.path, self.participant, self.elements = path, participant, elements
        self.names = _own_names(path.parent / OWN_NAMES)

    def of(self, name: str, participant: str | None = None) -> list[dict[str, str]]:
        return [attributes for element, attributes, owner in self.elements
                if element == name and participant in (None, owner)]

    def config(self) -> PreciceConfig:
        known = [each.get("name", "") for each in self.of("participant")]
        if self.participant not in known:
            raise UsageError(f'{self.path}: found no participant "{self.participant}", '
                             f'allowed: {", ".join(known)}')
        meshes = {mesh.name: mesh for mesh in map(self.mesh, self.of("provide-mesh", self.participant))}
        self.add_data(meshes)
        dimensions = {mesh.dimension for mesh in meshes.values()}
        if len(dimensions) != 1:
            raise NotMapped(f'{self.path}: participant "{self.participant}" provides meshes of dimensions '
                            f"{sorted(dimensions)}; allowed: one mesh or more, all of 2 or all of 3")
        name = self.names["participants"].get(self.participant, self.participant)
        return PreciceConfig(self.path, name, meshes, self.receives(meshes), dimensions.pop(),
                             self.number("max-time"), self.number("time-window-size"))

    def mesh(self, provided: dict[str, str]) -> CoupledMesh:
        name = provided.get("name", "")
        dimension = next((each.get("dimensions", "") for each in self.of("mesh")
                          if each.get("name") == name), "")
        if dimension not in ("2", "3"):
            raise UsageError(f'{self.path}: mesh "{name}": found dimensions "{dimension}", allowed: 2 or 3')
        projected = any(name in (each.get("from"), each.get("to"))
                        for each in self.of("mapping:nearest-projection"))
        return CoupledMesh(name, int(dimension), self.names["interfaces"].get(name, name), projected)

    def add_data(self, meshes: dict[str, CoupledMesh]) -> None:
        for element in ("read-data", "write-data"):
            for each in self.of(element, self.participant):
                name, mesh = each.get("name", ""), each.get("mesh", "")
                if mesh not in meshes:
                    raise NotMapped(f'{self.path}: {element} "{name}" on mesh "{mesh}", which '
                                    f'"{self.participant}" does not provide; allowed: its own meshes (there '
                                    "is no direct access)")
                data = meshes[mesh].reads if element == "read-data" else meshes[mesh].writes
                data[name] = self.quantity(name, mesh)

    def quantity(self, data: str, mesh: str) -> str:
        where = f'{self.path}: data "{data}" of mesh "{mesh}"'
        if not any(each.get("name") == data for each in self.of("data:vector")):
            raise NotMapped(f"{where}: found no data:vector of this name; allowed: vectors, since forces and "
                            "displacements are all that a soil and a structure exchange")
        found = self.names["quantities"].get(data)
        word = data.lower()
        if found is None and "delta" not in word:
            found = next((quantity for quantity in UNITS if word.startswith(quantity)), None)
        if found not in UNITS:
            raise NotMapped(
                f"{where}: neither a force [N of each vertex] nor a displacement [m, total, from the "
                "reference configuration] by its name; allowed: names that begin with Force or Displacement, or "
                f'say which it is in {OWN_NAMES} beside the file: {{"quantities": {{"{data}": "force"}}}}')
        return found

    def receives(self, meshes: dict[str, CoupledMesh]) -> str:
        """Each mesh sends one quantity and may read the other one; the same on all."""
        found = set()
        for mesh in meshes.values():
            reads, writes = list(mesh.reads.values()), list(mesh.writes.values())
            if len(writes) != 1 or len(reads) > 1 or reads == writes:
                raise NotMapped(f'{self.path}: mesh "{mesh.name}" of "{self.participant}" reads '
                                f"{list(mesh.reads)} and writes {list(mesh.writes)}; allowed: one force and "
                                "one displacement, one to read and one to write")
            found.add("force" if writes == ["displacement"] else "displacement")
        if len(found) != 1:
            raise NotMapped(f'{self.path}: "{self.participant}" writes forces and displacements; allowed: '
                            "one of them, a soil sends forces, a structure displacements")
        return found.pop()

    def number(self, element: str) -> float | None:
        values = [each.get("value") for each in self.of(element)]
        return float(values[0]) if values and values[0] else None


def _own_names(path: Path) -> dict[str, dict[str, str]]:
    """Names in the coupler's files where they differ. Raises UsageError for other keys."""
    if not path.exists():
        return {key: {} for key in OWN_KEYS}
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as problem:
        raise UsageError(f"{path}: {problem}") from problem
    if not isinstance(found, dict) or not set(found) <= set(OWN_KEYS) or not all(
            isinstance(each, dict) for each in found.values()):
        raise UsageError(f"{path}: allowed: an object of {', '.join(OWN_KEYS)}, each an object of names")
    return {key: found.get(key, {}) for key in OWN_KEYS}
