# SPDX-License-Identifier: BSD-3-Clause
"""Identity of a run: scene, settings, version."""

import hashlib
import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from measured import version
from plotting.lock import MARKER
from plotting.results import object_of

WORDS_AND_PICTURES = {".md", ".png"}  # of a scene's folder that no run reads
PLANS = ({"scene", "parameters", "design"}, {"scene", "fit"})  # keys by which a plan is known
STUDY = "study.json"  # in the folder of a study
MARKS = (MARKER, STUDY)  # of folders of results


def texts_of(value: Any) -> Iterator[str]:
    """Texts in a JSON value, at any depth."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list)):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from texts_of(inner)


def is_plan(path: Path) -> bool:
    """Whether it is a plan of a study, which says what to run and is read by none of its runs."""
    found = object_of(path) if path.suffix == ".json" else None
    return isinstance(found, dict) and any(keys <= found.keys() for keys in PLANS)


def own_files(folder: Path) -> Iterator[Path]:
    """Files of a scene's folder and those below that a run may read; results that were written there are none."""
    for path in sorted(folder.iterdir()):
        if path.name.startswith((".", "__")):
            continue
        if path.is_dir() and not path.is_symlink() and not any((path / mark).exists() for mark in MARKS):
            yield from own_files(path)
        elif path.is_file() and path.suffix not in WORDS_AND_PICTURES and not is_plan(path):
            yield path


def files_of(scene: Path, settings: list[str]) -> list[Path]:
    """Files that a run may read: those of the scene's folder, and those elsewhere that its settings name."""
    own = list(own_files(scene))
    named = [text for path in own if path.suffix == ".json" for text in texts_of(object_of(path))]
    named += [text for setting in settings for text in texts_of(value_of(setting))]
    return sorted({*own, *(scene / text for text in named if _is_file(scene / text))})


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a text that is no name
        return False


def value_of(setting: str) -> Any:
    """Value of FILE:/pointer=VALUE as the programs read it: JSON, else a text."""
    text = setting.partition("=")[2]
    try:
        return json.loads(text)
    except ValueError:
        return text


def identity_of(scene: Path, words: list[str], settings: list[str]) -> str:
    """Changes with what the run reads: contents of its files, settings in their order, further words, version."""
    digest = hashlib.sha256(json.dumps([version(), words, settings]).encode())
    for path in files_of(scene, settings):
        name = str(path.relative_to(scene)) if path.is_relative_to(scene) else str(path)
        state = path.stat()
        digest.update(f"\n{name} {_hash_of(path, state.st_mtime_ns, state.st_size)}".encode())
    return digest.hexdigest()


@lru_cache(maxsize=None)
def _hash_of(path: Path, changed: int, size: int) -> str:
    """Hash of the content, which is read once as long as the file stays as it is."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
