# SPDX-License-Identifier: BSD-3-Clause
"""Changes of a plan on the command line."""

import json

from .raster import TerrainError


def read_changes(texts: list[str]) -> dict:
    """Changes from texts such as barrier/height=8: keys joined by /, a JSON value; what is no JSON is a text.

    @raises TerrainError  the text has no such form
    """
    values: dict = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not all(key.split("/")):
            raise TerrainError(f"--set {text}: allowed: KEY=VALUE, such as cell_size=2 or barrier/height=8")
        try:
            value = json.loads(value)
        except ValueError:
            pass
        *above, last = key.split("/")
        inner = values
        for name in above:
            inner = inner.setdefault(name, {})
            if not isinstance(inner, dict):
                raise TerrainError(f"--set {text}: {name} has a value already, allowed: an object")
        inner[last] = value
    return values


def changed(values: object, changes: dict) -> object:
    """Objects key by key; all else is replaced."""
    if not isinstance(values, dict):
        return changes
    merged = dict(values)
    for key, value in changes.items():
        merged[key] = changed(values.get(key), value) if isinstance(value, dict) else value
    return merged
