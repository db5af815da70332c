# SPDX-License-Identifier: BSD-3-Clause
"""The parts of an input deck that the coupling needs: nodes, elements, sets, surfaces, thicknesses, steps.

Everything else is left to ccx, which reads the same lines.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from .topology import NUM_NODES, base_type

MAX_INCLUDES = 20  # deep


class DeckError(ValueError):
    """An error in the user's deck or settings; the text says where, what was found, what is allowed."""


@dataclass(frozen=True)
class Line:
    file: Path
    number: int
    text: str

    def error(self, found: str, allowed: str) -> DeckError:
        return DeckError(f"{self.file}:{self.number}: found {found}, allowed: {allowed}")

    def cells(self) -> list[str]:
        """Data of the line, upper case, without spaces; a comma at the end adds none."""
        cells = [cell.strip().upper() for cell in self.text.split(",")]
        return cells[:-1] if cells[-1] == "" else cells

    def integer(self, cell: str, what: str) -> int:
        try:
            return int(cell)
        except ValueError:
            raise self.error(f'"{cell}"', what) from None

    def number_in(self, cell: str) -> float:
        try:
            return float(cell.replace("D", "E"))
        except ValueError:
            raise self.error(f'"{cell}"', "a number") from None


@dataclass(frozen=True)
class Card:
    """A keyword with its parameters, and the data lines that follow it."""

    line: Line
    keyword: str  # such as *NODE
    parameters: dict[str, str]  # upper case; a parameter without value: ""
    data: list[Line]
    first: int  # of its lines in Deck.lines
    last: int  # one behind

    def name(self, parameter: str) -> str:
        if not self.parameters.get(parameter):
            raise self.line.error(f"{self.keyword} without {parameter}=", f"{self.keyword}, {parameter}=NAME")
        return self.parameters[parameter]


@dataclass(frozen=True)
class Element:
    type: str  # without variants, such as C3D20
    nodes: tuple[int, ...]


@dataclass(frozen=True)
class Surface:
    line: Line
    of_nodes: bool
    entries: list[tuple[Line, list[str]]]  # element or set and face; node or set


@dataclass
class Deck:
    path: Path
    lines: list[Line] = field(default_factory=list)  # with all *INCLUDE put in
    cards: list[Card] = field(default_factory=list)
    nodes: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    elements: dict[int, Element] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, Surface] = field(default_factory=dict)
    sections: list[tuple[str, float]] = field(default_factory=list)  # element set, thickness [m] of *SOLID SECTION

    def nodes_of(self, line: Line, name: str) -> list[int]:
        """Nodes named by a node's number or the name of a set."""
        return members(line, name, self.nodes, self.node_sets, "node")

    def elements_of(self, line: Line, name: str) -> list[int]:
        return members(line, name, self.elements, self.element_sets, "element")

    def cards_of(self, *keywords: str) -> list[Card]:
        return [card for card in self.cards if card.keyword in keywords]


def members(line: Line, name: str, there: dict, sets: dict[str, list[int]], kind: str) -> list[int]:
    if name.lstrip("-").isdigit():
        number = int(name)
        if number not in there:
            raise line.error(f"{kind} {number}, which is not defined", f"a {kind} of the deck")
        return [number]
    if name not in sets:
        raise line.error(f'{kind} set "{name}", which is not defined here',
                         f"a number, {', '.join(sets) or 'no set yet'}")
    return sets[name]


def parameters_of(line: Line) -> tuple[str, dict[str, str]]:
    """`*SURFACE, NAME=WET` -> *SURFACE, {NAME: WET}; CalculiX ignores case and spaces."""
    first, *rest = ["".join(cell.split()) for cell in line.text.split(",")]
    found = {}
    for cell in rest:
        key, _, value = cell.partition("=")
        if key:
            found[key.upper()] = value if key.upper() == "INPUT" else value.upper()
    return first.upper(), found


def read_lines(path: Path, depth: int = 0) -> Iterator[Line]:
    """All lines but comments and empty ones, with those of *INCLUDE in its place."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as problem:
        raise DeckError(f"{path}: {problem.strerror}") from problem
    for number, content in enumerate(text.splitlines(), 1):
        line = Line(path, number, content.strip())
        if not line.text or line.text.startswith("**"):
            continue
        if not "".join(line.text.split()).upper().startswith("*INCLUDE"):
            yield line
            continue
        name = parameters_of(line)[1].get("INPUT", "")
        if not name or depth == MAX_INCLUDES:
            raise line.error(f'"{line.text}"', f"*INCLUDE, INPUT=FILE, at most {MAX_INCLUDES} in one another")
        yield from read_lines(path.parent / name, depth + 1)


def split_cards(lines: list[Line]) -> Iterator[Card]:
    at = 0
    while at < len(lines):
        line, first = lines[at], at
        if not line.text.startswith("*"):
            raise line.error(f'"{line.text}"', "a keyword, such as *NODE, before any data")
        text = line.text
        while text.endswith(",") and at + 1 < len(lines) and not lines[at + 1].text.startswith("*"):
            at += 1
            text += lines[at].text
        keyword, parameters = parameters_of(Line(line.file, line.number, text))
        at += 1
        begin = at
        while at < len(lines) and not lines[at].text.startswith("*"):
            at += 1
        yield Card(line, keyword, parameters, lines[begin:at], first, at)


def add_nodes(deck: Deck, card: Card) -> None:
    added = []
    for line in card.data:
        number, *rest = line.cells()
        place = [line.number_in(cell) if cell else 0.0 for cell in rest[:3]]
        node = line.integer(number, "NODE, X, Y, Z")
        deck.nodes[node] = (*place, *[0.0] * (3 - len(place)))
        added.append(node)
    if "NSET" in card.parameters:
        deck.node_sets.setdefault(card.name("NSET"), []).extend(added)


def add_elements(deck: Deck, card: Card) -> None:
    base = base_type(card.name("TYPE"))
    if base is None:
        raise card.line.error(f"TYPE={card.parameters['TYPE']}", ", ".join(NUM_NODES))
    count, added, pending = NUM_NODES[base], [], []
    for line in card.data:
        pending += [line.integer(cell, "ELEMENT, NODE, NODE, ...") for cell in line.cells()]
        if len(pending) > count + 1:
            raise line.error(f"{len(pending) - 1} nodes", f"{count} of {card.parameters['TYPE']}")
        if len(pending) == count + 1:
            for node in pending[1:]:
                if node not in deck.nodes:
                    raise line.error(f"node {node}, which is not defined before", "a node of the deck")
            deck.elements[pending[0]] = Element(base, tuple(pending[1:]))
            added.append(pending[0])
            pending = []
    if pending:
        raise card.data[-1].error(f"{len(pending) - 1} nodes", f"{count} of {card.parameters['TYPE']}")
    if "ELSET" in card.parameters:
        deck.element_sets.setdefault(card.name("ELSET"), []).extend(added)


def add_set(card: Card, name: str, target: dict[str, list[int]], find: Callable[[Line, str], list[int]]) -> None:
    added = target.setdefault(name, [])
    for line in card.data:
        cells = line.cells()
        if "GENERATE" not in card.parameters:
            for cell in cells:
                added += find(line, cell)
            continue
        bounds = [line.integer(cell, "FIRST, LAST, STEP") for cell in cells]
        if len(bounds) not in (2, 3) or (len(bounds) == 3 and bounds[2] <= 0):
            raise line.error(f'"{line.text}"', "FIRST, LAST, STEP with STEP > 0")
        added += range(bounds[0], bounds[1] + 1, bounds[2] if len(bounds) == 3 else 1)


def add_surface(deck: Deck, card: Card) -> None:
    kind = card.parameters.get("TYPE", "ELEMENT")
    if kind not in ("ELEMENT", "NODE"):
        raise card.line.error(f"TYPE={kind}", "ELEMENT, NODE")
    entries = [(line, line.cells()) for line in card.data]
    deck.surfaces[card.name("NAME")] = Surface(card.line, kind == "NODE", entries)


def add_section(deck: Deck, card: Card) -> None:
    thickness = 1.0  # what ccx takes where none is given
    if card.data and card.data[0].cells():
        thickness = card.data[0].number_in(card.data[0].cells()[0])
    deck.sections.append((card.name("ELSET"), thickness))


def read_deck(path: Path) -> Deck:
    """Raises DeckError."""
    deck = Deck(path)
    deck.lines = list(read_lines(path))
    deck.cards = list(split_cards(deck.lines))
    for card in deck.cards:
        if card.keyword == "*NODE":
            add_nodes(deck, card)
        elif card.keyword == "*ELEMENT":
            add_elements(deck, card)
        elif card.keyword == "*NSET":
            add_set(card, card.name("NSET"), deck.node_sets, deck.nodes_of)
        elif card.keyword == "*ELSET":
            add_set(card, card.name("ELSET"), deck.element_sets, deck.elements_of)
        elif card.keyword == "*SURFACE":
            add_surface(deck, card)
        elif card.keyword == "*SOLIDSECTION":
            add_section(deck, card)
    if not deck.elements:
        raise DeckError(f"{path}: found no *ELEMENT, allowed: an input deck of CalculiX with nodes and elements")
    return deck
