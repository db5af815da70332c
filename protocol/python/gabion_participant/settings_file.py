# SPDX-License-Identifier: BSD-3-Clause
"""The settings of a structure of one's own, a JSON object whose keys are those of a table."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

#: key -> type, the test of its value, what is allowed
KeyTable = dict[str, tuple[type, Callable[[Any], Any], str]]


def read_settings_file(path: Path, keys: KeyTable, required: tuple[str, ...], error: type[Exception]) -> dict[str, Any]:
    """Values by key; whole numbers are numbers.

    @raises error  names file, key, found and allowed: no object, an unknown or missing key, another type or value
    """
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        raise error(f"{path}: {problem}") from problem
    if not isinstance(values, dict):
        raise error(f"{path}: found {type(values).__name__}, allowed: an object with {', '.join(keys)}")
    for key in (*values, *required):
        if key not in keys or key not in values:
            raise error(f"{path}: at /{key}: found {'nothing' if key in keys else 'this key'}, allowed: "
                        f"{keys[key][2] if key in keys else ', '.join(keys)}")
    for key, value in values.items():
        kind, fits, allowed = keys[key]
        values[key] = value = as_kind(kind, value)
        if not is_kind(kind, value) or not fits(value):
            raise error(f"{path}: at /{key}: found {json.dumps(value)}, allowed: {allowed}")
    return values


def as_kind(kind: object, value: object) -> object:
    """Whole numbers are numbers."""
    return float(value) if kind is float and isinstance(value, int) and not isinstance(value, bool) else value


def is_kind(kind: Any, value: object) -> bool:
    return isinstance(value, kind) and (kind is bool or not isinstance(value, bool))
