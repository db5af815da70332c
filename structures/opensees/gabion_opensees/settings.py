# SPDX-License-Identifier: BSD-3-Clause
"""structure.json: which model, which wet surfaces, how to step."""

import json
import os
from dataclasses import dataclass, field
from pathlib import Path

from gabion_participant.settings_file import as_kind, is_kind, read_settings_file

from .errors import SettingsError


@dataclass(frozen=True)
class Settings:
    model: Path  # .py with openseespy, or .tcl
    interfaces: tuple[dict, ...]
    procedure: str = "dynamic"  # or static
    integrator: list = field(default_factory=lambda: ["Newmark", 0.5, 0.25])
    system: list = field(default_factory=lambda: ["BandGeneral"])
    test: list = field(default_factory=lambda: ["NormDispIncr", 1e-10, 30])
    algorithm: list = field(default_factory=lambda: ["Newton"])
    arm_tolerance: float = 1e-4  # [rad] of the rotations that the arms of the forces are taken at
    max_unknowns: int = 3000  # of a dynamic model: its mass matrix is read in full
    python: str = field(default_factory=lambda: os.environ.get("GABION_OPENSEES_PYTHON", "/usr/bin/python3"))
    probes: tuple[dict, ...] = ()

    def analysis(self) -> dict:
        """Settings that the process of the model needs."""
        return {name: getattr(self, name) for name in ("procedure", "integrator", "system", "test", "algorithm",
                                                       "max_unknowns")}


# Key -> type, the test of its value, what is allowed.
KEYS = {
    "model": (str, lambda value: value.endswith((".py", ".tcl")), "the path of a .py or .tcl, from structure.json"),
    "interfaces": (list, bool, 'a list of {"name": "wall", "line": {...}}, or "shell", "tube"'),
    "procedure": (str, lambda value: value in ("dynamic", "static"), "dynamic, static"),
    "integrator": (list, bool, 'the arguments of the command, such as ["Newmark", 0.5, 0.25]'),
    "system": (list, bool, 'the arguments of the command, such as ["BandGeneral"]'),
    "test": (list, bool, 'the arguments of the command, such as ["NormDispIncr", 1e-10, 30]'),
    "algorithm": (list, bool, 'the arguments of the command, such as ["Newton"]'),
    "arm_tolerance": (float, lambda value: 0 < value < 1, "[rad], between 0 and 1"),
    "max_unknowns": (int, lambda value: value >= 1, "an integer >= 1"),
    "python": (str, bool, "name or path of a python that has openseespy"),
    "probes": (list, lambda value: True, 'a list of {"name": "A", "node": 7}, {"name": "A", "interface": "wall", '
               '"point": [0.25, 0.05]}, {"name": "rope", "element": 3, "response": ["axialForce"]}'),
}
REQUIRED = ("model", "interfaces")
SHAPES = {  # of an interface -> its keys: type, whether it must be there
    "line": {"nodes": (list, str), "left": float, "right": float, "ends": list},
    "shell": {"facets": (list, str), "elements": (list, str), "above": float, "below": float, "rim": bool},
    "tube": {"nodes": (list, str), "rectangle": list, "circle": list, "upwards": list, "ends": bool},
}
PROBES = ({"name", "node"}, {"name", "interface", "point"}, {"name", "element", "response"})


def read_settings(path: Path) -> Settings:
    """Raises SettingsError that names file, key, found and allowed."""
    values = read_settings_file(path, KEYS, REQUIRED, SettingsError)
    for index, entry in enumerate(values["interfaces"]):
        check_interface(f"{path}: at /interfaces/{index}", entry)
    for index, entry in enumerate(values.get("probes", [])):
        if not isinstance(entry, dict) or set(entry) not in PROBES:
            raise SettingsError(f"{path}: at /probes/{index}: found {json.dumps(entry)}, allowed: {KEYS['probes'][2]}")
    return Settings(**values | {"model": path.parent / values["model"], "interfaces": tuple(values["interfaces"]),
                                "probes": tuple(values.get("probes", []))})


def check_interface(place: str, entry: object) -> None:
    """{"name": ..., SHAPE: {...}}"""
    shapes = [key for key in entry if key in SHAPES] if isinstance(entry, dict) else []
    if len(shapes) != 1 or set(entry) != {"name", shapes[0]} or not isinstance(entry["name"], str):
        raise SettingsError(f"{place}: found {json.dumps(entry)}, allowed: {KEYS['interfaces'][2]}")
    shape, keys = entry[shapes[0]], SHAPES[shapes[0]]
    if not isinstance(shape, dict):
        raise SettingsError(f"{place}/{shapes[0]}: found {json.dumps(shape)}, allowed: an object with "
                            f"{', '.join(keys)}")
    for key, value in shape.items():
        shape[key] = value = as_kind(keys.get(key), value)
        if key not in keys or not is_kind(keys[key], value):
            raise SettingsError(f"{place}/{shapes[0]}/{key}: found {json.dumps(value)}, allowed: {', '.join(keys)}, "
                                "lengths as numbers, nodes, facets and elements as lists or the name of a variable of "
                                "the model")
    choices = [{"nodes"}] if shapes[0] != "shell" else [{"facets"}, {"elements"}]
    choices = [{"nodes", "upwards", "rectangle"}, {"nodes", "upwards", "circle"}] if shapes[0] == "tube" else choices
    needed = set().union(*choices) - {"left", "right"}
    if shape.keys() & needed not in choices:
        raise SettingsError(f"{place}/{shapes[0]}: found {', '.join(shape) or 'nothing'}, allowed: one of "
                            f"{' or '.join(', '.join(sorted(choice)) for choice in choices)}")
