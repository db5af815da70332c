# SPDX-License-Identifier: BSD-3-Clause
"""Values of a plan, read strictly: errors name the place in the file."""

import json
import math
from pathlib import Path
from typing import Any

from terrain_scene.reader import Reader, TerrainError

PlanError = TerrainError  # the text says what was found in the plan, where, and what is allowed
KIND = "letters, digits, _ and -"


class PlanReader(Reader):
    """An object of a plan; keys beside `keys` are refused."""

    def inner(self, key: str, keys: tuple[str, ...] | None) -> "PlanReader":
        return PlanReader(self.values.get(key), f"{self.where}/{key}", keys)

    def named(self, key: str, keys: tuple[str, ...] | None) -> "dict[str, PlanReader]":
        """Objects by name; none where the key is missing."""
        if key not in self.values:
            return {}
        whole = self.inner(key, None)
        for name in whole.values:
            if not name or not all(letter.isalnum() or letter in "_-" for letter in name):
                raise PlanError(f"{whole.where}: found the name {name!r}, allowed: {KIND}")
        return {name: whole.inner(name, keys) for name in whole.values}

    def whole(self, key: str, least: int) -> int:
        value = self.values.get(key)
        if not isinstance(value, int) or isinstance(value, bool) or value < least:
            raise self.fail(key, f"a whole number >= {least}")
        return value

    def real(self, key: str) -> float:
        """Any finite number."""
        if not is_number(self.values.get(key)):
            raise self.fail(key, "a number")
        return float(self.values[key])

    def words(self, key: str) -> tuple[str, ...]:
        """A text, or a list of at least one."""
        value = self.values.get(key)
        found = [value] if isinstance(value, str) else value
        if not isinstance(found, list) or not found or not all(isinstance(each, str) and each for each in found):
            raise self.fail(key, "a text or a list of texts")
        return tuple(found)

    def word(self, key: str, allowed: tuple[str, ...]) -> str:
        if self.values.get(key) not in allowed:
            raise self.fail(key, f"one of {', '.join(allowed)}")
        return self.values[key]

    def one_of(self, keys: tuple[str, ...]) -> str:
        """The one of these keys that is there."""
        found = [key for key in keys if key in self.values]
        if len(found) != 1:
            raise PlanError(f"{self.where}: found {' and '.join(found) or 'none'} of {', '.join(keys)}, allowed: one")
        return found[0]


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_object(path: Path) -> dict:
    """@raises PlanError  no file, no JSON, no object in it, or a key that is there twice"""
    def once(pairs: list[tuple[str, Any]]) -> dict:
        found = dict(pairs)
        for key in found:
            if sum(key == other for other, _ in pairs) > 1:
                raise PlanError(f"{path}: found the key {key!r} twice in one object, allowed: once")
        return found

    if not path.is_file():
        raise PlanError(f"{path}: no such plan")
    try:
        return json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=once)
    except ValueError as error:
        raise PlanError(f"{path}: not JSON: {error}") from error
