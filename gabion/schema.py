# SPDX-License-Identifier: BSD-3-Clause
"""Keys of the settings files, as the programs describe them in docs/keys."""

import json
import re
from collections.abc import Iterator
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

from ._root import ROOT
from .errors import SettingError

FILES = ("coupler.json", "mpm.json", "fem.json")


@lru_cache(maxsize=None)
def schema_of(file: str) -> dict:
    """JSON schema of a settings file such as mpm.json."""
    path = ROOT / "docs" / "keys" / file.replace(".json", ".schema.json")
    return json.loads(path.read_text(encoding="utf-8"))


def nearest(word: str, words: list[str]) -> str:
    """"; did you mean …?" with the known word that is most like this one, or nothing."""
    near = get_close_matches(word.lower(), words, 1, 0.5)
    return f'; did you mean "{near[0]}"?' if near else ""


def split(path: str) -> tuple[str, list[str]]:
    """File and keys of a path such as mpm.json:/time/end. @raises SettingError  it has another form"""
    file, colon, pointer = path.partition(":")
    if not colon or not pointer.startswith("/"):
        raise SettingError(f"{path}: allowed: FILE:/key/key, such as mpm.json:/time/end")
    keys = [] if pointer == "/" else pointer[1:].split("/")
    if "" in keys:
        raise SettingError(f"{path}: found an empty key, allowed: FILE:/key/key")
    return file, keys


class Node:
    """A place in the settings: all descriptions that may hold there.

    A description may refer to others, and hold for some values of other keys only: cohesion of one material is not
    that of another. What a key is then depends on the file; all of its descriptions count here.
    """

    def __init__(self, file: str, schemas: list[dict]):
        self.file = file
        self._own = schemas
        self._schemas = list(_expanded(schemas, schema_of(file)))

    @property
    def keys(self) -> list[str]:
        """Known keys of an object, in the order of the alphabet."""
        return sorted({key for each in self._schemas for key, value in each.get("properties", {}).items()
                       if isinstance(value, dict) and value})

    @property
    def _free(self) -> list[dict[str, Any]]:
        """Patterns of names that the user chooses, such as those of participants -> what has such a name."""
        return [{**each.get("patternProperties", {}), ".": each.get("additionalProperties")} for each in self._schemas]

    @property
    def is_list(self) -> bool:
        return any("items" in each for each in self._schemas)

    @property
    def description(self) -> str:
        """Meaning of the key, with unit and default."""
        texts = [each["description"] for each in self._schemas if "description" in each]
        defaults = [each["default"] for each in self._schemas if "default" in each]
        return (texts[0] if texts else "") + (f" Default: {json.dumps(defaults[0])}." if defaults else "")

    def child(self, key: str) -> "Node | None":
        """Place below; None: there is no such key."""
        if self.is_list and key.isdigit():
            found = [each["items"] for each in self._schemas if isinstance(each.get("items"), dict)]
        else:
            found = [each["properties"][key] for each in self._schemas if key in each.get("properties", {})]
            found = found or [each for free in self._free for pattern, each in free.items() if re.search(pattern, key)]
        found = [each for each in found if isinstance(each, dict)]
        return Node(self.file, found) if found else None

    def check(self, value: Any, path: str) -> None:
        """@raises SettingError  none of the descriptions allows the value"""
        try:
            import jsonschema
        except ImportError:
            return  # the programs check it when they run
        definitions = {"definitions": schema_of(self.file).get("definitions", {})}
        errors = []
        for each in self._own:
            error = jsonschema.exceptions.best_match(jsonschema.Draft7Validator(each | definitions).iter_errors(value))
            if error is None:
                return
            while error.validator in ("anyOf", "oneOf") and error.context:
                error = error.context[0]
            errors.append(error)
        at = "".join(f"/{key}" for key in errors[0].absolute_path)
        found, allowed = json.dumps(errors[0].instance)[:120], _allowed(errors[0])
        raise SettingError(f"{path}{at}: found {found}, allowed: {allowed}. {self.description}".strip())


def _allowed(error: Any) -> str:
    """Requirements of a description, in words. error: of jsonschema"""
    rule, value = error.validator, error.validator_value
    words = {"type": "{}", "enum": "one of {}", "minimum": ">= {}", "exclusiveMinimum": "> {}", "maximum": "<= {}",
             "exclusiveMaximum": "< {}", "minItems": "at least {} of them", "maxItems": "at most {} of them",
             "required": "an object with {}"}
    if rule == "additionalProperties":
        return f"no such key ({error.message[:200]})"
    text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return words[rule].format(text) if rule in words else error.message[:200]


def _expanded(schemas: list[dict], whole: dict) -> Iterator[dict]:
    """The descriptions with all that they refer to or choose between."""
    for each in schemas:
        yield each
        inner = [part for word in ("allOf", "anyOf", "oneOf") for part in each.get(word, [])]
        inner += [each[word] for word in ("then", "else") if isinstance(each.get(word), dict)]
        if "$ref" in each:
            inner.append(whole["definitions"][each["$ref"].rpartition("/")[2]])
        yield from _expanded([part for part in inner if isinstance(part, dict)], whole)


def node_at(path: str) -> Node:
    """The place that a path leads to. @raises SettingError  a key along the path is unknown"""
    file, keys = split(path)
    if file not in FILES:
        raise SettingError(f'{path}: found file "{file}", allowed: {", ".join(FILES)}{nearest(file, list(FILES))}')
    node = Node(file, [schema_of(file)])
    for depth, key in enumerate(keys):
        below = node.child(key)
        if below is None:
            where = f"{file}:/{'/'.join(keys[:depth])}"
            allowed = "the number of an entry" if node.is_list else ", ".join(node.keys) or "no key, it is a value"
            hint = "" if node.is_list else nearest(key, node.keys)
            raise SettingError(f'{path}: found "{key}" at {where}, allowed: {allowed}{hint}')
        node = below
    return node
