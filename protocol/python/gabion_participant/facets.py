# SPDX-License-Identifier: BSD-3-Clause
"""Facets of interfaces that change between steps (protocol/README.md, section 6)."""

from collections.abc import Callable, Sequence

import numpy as np

from .errors import ProtocolError, UsageError
from .message import Message
from .solver import InterfaceFacets, InterfaceMesh


def checked_facets(mesh: InterfaceMesh, facets: np.ndarray, call: str) -> np.ndarray:
    """Facets of an interface as the wire has them. Raises UsageError for another shape, or a vertex that is none."""
    width = mesh.facets.shape[1]
    array = np.asarray(facets)
    if array.size == 0:
        return np.zeros((0, width), dtype="<i8")
    if array.ndim != 2 or array.shape[1] != width or not np.issubdtype(array.dtype, np.integer):
        raise UsageError(f'{call}: found {array.dtype} of shape {list(array.shape)} for "{mesh.name}", '
                         f"allowed: integers, num_facets x {width}")
    if array.min() < 0 or array.max() >= len(mesh.coordinates):
        raise UsageError(f'{call}: found vertices {array.min()} to {array.max()} of "{mesh.name}", '
                         f"allowed: 0 to {len(mesh.coordinates) - 1}")
    return array.astype("<i8")


def read_facets(message: Message, interfaces: Sequence[InterfaceMesh]) -> InterfaceFacets:
    """Arrays "facets:<interface>" of the interfaces that the message has. Raises ProtocolError for a vertex that is
    none, and for an interface without facets."""
    facets = {}
    for mesh in interfaces:
        name = f"facets:{mesh.name}"
        if name not in message.arrays:
            continue
        where = f'message "{message.type}", "{name}"'
        if mesh.facets is None:
            raise ProtocolError(f"{where}: the interface has no facets")
        own = facets[mesh.name] = message.integers(name, (-1, mesh.facets.shape[1]))
        if own.size and not (0 <= own.min() and own.max() < len(mesh.coordinates)):
            raise ProtocolError(f"{where}: a facet names vertex {own.min() if own.min() < 0 else own.max()}, "
                                f"there are {len(mesh.coordinates)}")
    return facets


class ChangingFacets:
    """Facets of the interfaces of a structure that may change, and which of them the coupler knows."""

    def __init__(self) -> None:
        self.now: InterfaceFacets = {}  # in the accepted state
        self._sent: InterfaceFacets = {}
        self._loaded: InterfaceFacets | None = None  # that were written so far, while a state is loaded

    def let_change(self, mesh: InterfaceMesh) -> None:
        """Note an interface with the facets of the beginning. Raises UsageError where it has none."""
        if mesh.facets is None:
            raise UsageError(f'set_facets_may_change: found interface "{mesh.name}" without facets, allowed: one that '
                             "has some at the beginning")
        self.now[mesh.name] = self._sent[mesh.name] = mesh.facets

    def write(self, mesh: InterfaceMesh, facets: np.ndarray, accepted: bool) -> None:
        """Set all facets of an interface. `accepted`: the code has just got to know that a step was accepted. Raises
        UsageError for a wrong time or wrong facets."""
        if mesh.name not in self.now:
            raise UsageError(f'write_facets: found interface "{mesh.name}", allowed: those of set_facets_may_change, '
                             f"{sorted(self.now)}")
        if not accepted and self._loaded is None:
            raise UsageError("write_facets: allowed after an accepted step, before is_coupling_ongoing, and while a "
                             "state is loaded")
        checked = checked_facets(mesh, facets, "write_facets")
        (self.now if self._loaded is None else self._loaded)[mesh.name] = checked

    def while_loading(self, load: Callable[[], None]) -> None:
        """Run a code's function that loads a state, in which it has to write the facets of each interface."""
        self._loaded = {}
        load()
        for name in self.now:
            if name not in self._loaded:
                raise UsageError(f'load: no facets were written for "{name}", allowed: a call of write_facets in it, '
                                 "since they may change")
        self.now, self._loaded = self._loaded, None
        self.forget()

    def forget(self) -> None:
        """Send all of them again: after "load" the coupler may know others."""
        self._sent = {}

    def put_changed(self, accepted: Message) -> None:
        """Add to an answer "accepted" those that are others than those sent last."""
        for name, facets in self.now.items():
            if name in self._sent and np.array_equal(self._sent[name], facets):
                continue
            accepted.arrays[f"facets:{name}"] = self._sent[name] = facets
