# SPDX-License-Identifier: BSD-3-Clause
"""A scene: read, change by path, run."""

import copy
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .errors import SettingError
from .job import Job
from .results import Results
from .schema import FILES, Node, nearest, node_at, split


class Scene:
    """The settings files of a folder, and changes of them that hold for runs from here; the files stay as they are.

        scene = gabion.Scene("configs/column_collapse")
        scene["mpm.json:/time/end"]                  # the value in the file, SI units
        scene["mpm.json:/time/end"] = 0.05           # for this scene here

    A path is FILE:/key/key, an entry of a list has its number, from 0. What a key means and what it allows is what the
    programs say of it (docs/keys).
    """

    def __init__(self, folder: str | Path):
        """@raises SettingError  no such folder, no settings file in it, or one that is no JSON"""
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise SettingError(f"{folder}: no such scene folder")
        self._files: dict[str, Any] = {}
        self._changes: dict[str, Any] = {}
        for name in FILES:
            path = self.folder / name
            if path.exists():
                try:
                    self._files[name] = json.loads(path.read_text(encoding="utf-8"))
                except ValueError as error:
                    raise SettingError(f"{path}: not JSON: {error}") from error
        if not self._files:
            raise SettingError(f"{folder}: holds none of {', '.join(FILES)}")

    def __repr__(self) -> str:
        return f"Scene({str(self.folder)!r}: {', '.join([*self._files, *self.options])})"

    def __getitem__(self, path: str) -> Any:
        """A copy of the value. @raises SettingError  an unknown key, or one that is not set"""
        node, value = node_at(path), self._file_of(path)
        for key in split(path)[1]:
            value = _entry(value, key, path)
            if value is _MISSING:
                raise SettingError(f"{path}: not set in {self.folder}. {node.description}".strip())
        return copy.deepcopy(value)

    def __setitem__(self, path: str, value: Any) -> None:
        """Set a value: a number, word, list or object, also one of numpy. Missing objects along the path are made.

        @raises SettingError  an unknown key, an entry behind the end of a list, a value that the key does not allow
        """
        file, keys = split(path)
        if not keys:
            raise SettingError(f"{path}: found no key, allowed: FILE:/key")
        value = _plain(value, path)
        node_at(path).check(value, path)
        place = changed = copy.deepcopy(self._file_of(path))
        for key, following in zip(keys, keys[1:]):
            below = _entry(place, key, path)
            if below is _MISSING or below is None:
                if following.isdigit():
                    raise SettingError(f"{path}: {key} is not set, allowed: to set the whole list")
                below = place[key] = {}
            place = below
        _entry(place, keys[-1], path)
        place[int(keys[-1]) if isinstance(place, list) else keys[-1]] = value
        self._files[file] = changed
        self._changes.pop(path, None)  # a later change counts after what was set in between
        self._changes[path] = value

    def update(self, settings: dict[str, Any]) -> None:
        """Set several values, in their order."""
        for path, value in settings.items():
            self[path] = value

    @property
    def options(self) -> list[str]:
        """The changes as values of --set of scripts/run, such as "mpm.json:/time/end=0.05"."""
        return [f"{path}={json.dumps(value)}" for path, value in self._changes.items()]

    @property
    def settings(self) -> dict[str, Any]:
        """Name of each file -> a copy of its content with the changes."""
        return copy.deepcopy(self._files)

    def keys(self, path: str) -> list[str]:
        """Known keys of the object at a path, such as mpm.json:/bodies/0/material, those that are not set too."""
        return node_at(path).keys

    def describe(self, path: str) -> str:
        """Meaning of a key, with its unit and default."""
        return node_at(path).description

    def paths(self) -> list[str]:
        """Paths of all values that are set, in the order of the files."""
        return [f"{file}:{pointer}" for file, content in self._files.items() for pointer in _leaves(content, "")]

    def _ipython_key_completions_(self) -> list[str]:
        """Completions of a notebook behind scene[": paths that are set, and that may be set beside them."""
        found = self.paths()
        above = dict.fromkeys(path.rpartition("/")[0] for path in found)
        return sorted({*found, *(f"{place}/{key}" for place in above for key in _node(place).keys)})

    def save(self, folder: str | Path) -> "Scene":
        """A copy of the folder with the changes in its settings files. @raises SettingError  it is there already"""
        target = Path(folder)
        if target.exists():
            raise SettingError(f"{folder}: is there already, allowed: a new folder")
        shutil.copytree(self.folder, target)
        for name, content in self._files.items():
            (target / name).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        return Scene(target)

    def start(self, output: str | Path, ranks: dict[str, int] | None = None, options: tuple[str, ...] = ()) -> Job:
        """Start a run through scripts/run, which builds what is missing first, and do not wait.

        output: folder of the results; ranks: MPI ranks of solvers, such as {"mpm": 2}, None: those that pay; options:
        more of scripts/run.
        """
        words = [word for each in self.options for word in ("--set", each)]
        if ranks:
            words += ["--ranks", ",".join(f"{kind}={count}" for kind, count in ranks.items())]
        return Job(self.folder, Path(output), ["--no-plots", *words, *options])

    def run(self, output: str | Path, progress: bool = False, ranks: dict[str, int] | None = None,
            options: tuple[str, ...] = ()) -> Results:
        """Run to the end and read what came out. progress: print how far it is; the rest as of `start`.

        @raises RunError  the run failed
        """
        return self.start(output, ranks, options).wait(progress)

    def check(self) -> str:
        """Set the run up as far as its first step and write nothing; what the programs say of it.

        @raises RunError  they refuse it
        """
        words = [word for each in self.options for word in ("--set", each)]
        return Job(self.folder, None, ["--check", *words]).finish()

    def _file_of(self, path: str) -> Any:
        file = split(path)[0]
        if file not in self._files:
            raise SettingError(f'{path}: {self.folder} has no file "{file}", allowed: {", ".join(self._files)}'
                               f"{nearest(file, list(self._files))}")
        return self._files[file]


_MISSING = object()


def _entry(place: Any, key: str, path: str) -> Any:
    """Value below a key; _MISSING where an object lacks it. @raises SettingError  a list has no such entry"""
    if isinstance(place, list):
        if not key.isdigit() or int(key) >= len(place):
            raise SettingError(f"{path}: found entry {key}, allowed: 0 to {len(place) - 1}")
        return place[int(key)]
    if not isinstance(place, dict):
        raise SettingError(f"{path}: found {json.dumps(place)[:80]} above {key}, allowed: an object with that key")
    return place.get(key, _MISSING)


def _plain(value: Any, path: str) -> Any:
    """The value as JSON has it. @raises SettingError  JSON has none, such as not a number"""
    try:
        return json.loads(json.dumps(value, allow_nan=False, default=lambda each: each.tolist()))
    except (ValueError, TypeError, AttributeError) as error:
        allowed = "finite numbers, words, lists and objects of them"
        raise SettingError(f"{path}: found {value!r}, allowed: {allowed}") from error


def _leaves(value: Any, pointer: str) -> Iterator[str]:
    below = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    if not below:
        yield pointer or "/"
    for key, inner in below:
        yield from _leaves(inner, f"{pointer}/{key}")


def _node(place: str) -> Node:
    return node_at(place if ":/" in place else f"{place}/")
