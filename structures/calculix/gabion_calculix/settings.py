# SPDX-License-Identifier: BSD-3-Clause
"""structure.json: which deck, which surfaces, how to step."""

import json
from dataclasses import dataclass
from pathlib import Path

from gabion_participant.settings_file import read_settings_file

from .deck import DeckError


@dataclass(frozen=True)
class Coupled:
    """An interface of coupler.json and where it is in the deck: a *SURFACE or an element set, the other one empty."""

    name: str
    surface: str
    element_set: str


@dataclass(frozen=True)
class Probe:
    name: str
    node: int


@dataclass(frozen=True)
class Settings:
    deck: Path
    interfaces: tuple[Coupled, ...]
    procedure: str = "dynamic"  # or static
    nlgeom: bool = True  # large displacements
    alpha: float = 0.0  # of *DYNAMIC, -1/3 to 0
    newton_tolerance: float = 1e-6  # of the residual by the mean force, and of the correction by the increment
    max_increments: int = 16  # of ccx in a coupled step: 1, and 4, 16, ... where that has no solution
    threads: int = 1  # of matrices and stresses
    solver_threads: int = 1  # of the linear solver; with more a repeated step has not the same bits
    deadline: float = 3600.0  # [s] for one run of ccx
    program: str = "ccx"
    reactions: tuple[str, ...] = ()  # node sets whose forces of supports are a table beside the frames
    section_forces: bool = False  # of beams, a table beside the frames
    probes: tuple[Probe, ...] = ()


# Key -> type, the test of its value, what is allowed.
KEYS = {
    "deck": (str, bool, "the path of an input deck, from structure.json"),
    "interfaces": (list, bool, 'a list of {"name": "wall", "surface": "WET"}, or "element_set" in place of "surface"'),
    "procedure": (str, lambda value: value in ("dynamic", "static"), "dynamic, static"),
    "nlgeom": (bool, lambda value: True, "true, false"),
    "alpha": (float, lambda value: -1 / 3 <= value <= 0, "-1/3 to 0"),
    "newton_tolerance": (float, lambda value: 0 < value < 1, "a number between 0 and 1"),
    "max_increments": (int, lambda value: value >= 1, "an integer >= 1"),
    "threads": (int, lambda value: value >= 1, "an integer >= 1"),
    "solver_threads": (int, lambda value: value >= 1, "an integer >= 1"),
    "deadline": (float, lambda value: value > 0, "[s] > 0"),
    "program": (str, bool, "name or path of ccx"),
    "reactions": (list, lambda value: all(isinstance(name, str) for name in value), 'a list of node sets, ["FEET"]'),
    "section_forces": (bool, lambda value: True, "true, false"),
    "probes": (list, lambda value: True, 'a list of {"name": "A", "node": 7}'),
}
REQUIRED = ("deck", "interfaces")


def read_settings(path: Path) -> Settings:
    """Raises DeckError that names file, key, found and allowed."""
    values = read_settings_file(path, KEYS, REQUIRED, DeckError)
    interfaces = tuple(read_interface(path, k, entry) for k, entry in enumerate(values["interfaces"]))
    probes = tuple(read_probe(path, k, entry) for k, entry in enumerate(values.get("probes", [])))
    deck = path.parent / values["deck"]
    reactions = tuple(name.upper() for name in values.get("reactions", []))
    return Settings(**values | {"deck": deck, "interfaces": interfaces, "probes": probes, "reactions": reactions})


def read_interface(path: Path, index: int, entry: object) -> Coupled:
    fits = isinstance(entry, dict) and all(isinstance(value, str) for value in entry.values())
    if not fits or set(entry) not in ({"name", "surface"}, {"name", "element_set"}):
        raise DeckError(f"{path}: at /interfaces/{index}: found {json.dumps(entry)}, allowed: {KEYS['interfaces'][2]}")
    return Coupled(entry["name"], entry.get("surface", "").upper(), entry.get("element_set", "").upper())


def read_probe(path: Path, index: int, entry: object) -> Probe:
    fits = isinstance(entry, dict) and set(entry) == {"name", "node"}
    if not fits or not isinstance(entry["name"], str) or not isinstance(entry["node"], int):
        raise DeckError(f"{path}: at /probes/{index}: found {json.dumps(entry)}, allowed: {KEYS['probes'][2]}")
    return Probe(entry["name"], entry["node"])
