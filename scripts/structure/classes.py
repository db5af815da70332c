# SPDX-License-Identifier: BSD-3-Clause
"""The classes of a folder of C++ sources, each with the lines of all its files: enough for code in the style of
clang-format."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from .functions import functions, without_texts

_CLASS = re.compile(r"^(?:class|struct) (\w+)((?:::\w+)*)(?: final)?(?: : [^{;]*)? \{", re.MULTILINE)
_OWNER = re.compile(r"(\w+)(?:<[^<>]*>)?::")


@dataclass
class Class:
    """A class at the level of a namespace; types within it count as part of it."""

    line: int = 0  # where its body begins; 0: not found
    home: Path = Path()  # the file that has its body
    lines: int = 0  # of its body, and of its functions wherever they are defined
    virtuals: int = 0  # functions that it declares virtual
    overrides: int = 0
    files: set[Path] = field(default_factory=set)


def _body(code: str, start: int) -> str:
    """The code from the head of a class to the brace that closes it."""
    level = 0
    for brace in re.finditer(r"[{}]", code[start:]):
        level += 1 if brace.group() == "{" else -1
        if level == 0:
            return code[start:start + brace.end()]
    return code[start:]


def classes(paths: Iterable[Path]) -> dict[str, Class]:
    """Classes of some files that belong together, by name."""
    found: dict[str, Class] = {}
    for path in paths:
        source = path.read_text(encoding="utf-8")
        code = without_texts(source)
        for match in _CLASS.finditer(code):
            body = _body(code, match.start())
            each = found.setdefault(match.group(1), Class())
            if not match.group(2):  # else it is a type within
                each.line, each.home = code.count("\n", 0, match.start()) + 1, path
            each.lines += body.count("\n") + 1
            each.virtuals += len(re.findall(r"\bvirtual\b(?! ~)", body))
            each.overrides += len(re.findall(r"\boverride\b", body))
            each.files.add(path)
        for function in functions(source):
            owner = _OWNER.match(function.name)
            if owner:
                each = found.setdefault(owner.group(1), Class())
                each.lines += function.lines
                each.files.add(path)
    return {name: each for name, each in found.items() if each.line}
