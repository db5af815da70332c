# SPDX-License-Identifier: BSD-3-Clause
"""The functions of a C++ source, found by its braces: enough for code in the style of clang-format."""

import re
from typing import NamedTuple


class Function(NamedTuple):
    """A function with a body."""

    name: str
    line: int  # where it begins
    lines: int
    parameters: int


# Raw texts, comments, texts, characters.
_OPAQUE = re.compile(
    r'R"(\w*)\((?:.|\n)*?\)\1"|//[^\n]*|/\*(?:.|\n)*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'')
_DIRECTIVE = re.compile(r"^\s*#(?:.*\\\n)*.*$", re.MULTILINE)
_CONTROL = re.compile(r"^\s*(if|for|while|switch|catch|do|else|try|return)\b")
_TYPE = re.compile(r"\b(class|struct|union|enum)\b[^()=]*$")
_AFTER_PARAMETERS = re.compile(r"(\b(const|noexcept|override|final)|->[^;]*)\s*$")
_NAME = re.compile(r"([\w:~<>]+|operator\S+)\s*$")


def without_texts(source: str) -> str:
    """The code alone: comments, texts and directives are gone, every line stays where it is."""
    def opaque(match: re.Match[str]) -> str:
        filler = {'"': '""', "R": '""', "'": "0"}.get(match.group()[0], "")
        return filler + "\n" * match.group().count("\n")
    return _DIRECTIVE.sub(lambda match: "\n" * match.group().count("\n"), _OPAQUE.sub(opaque, source))


def _kind(head: str, outer: str) -> str:
    """A block that a brace opens: the code since the last statement, and the block around it."""
    if re.search(r"\bnamespace\b", head) or re.search(r'extern\s+""\s*$', head):
        return "namespace"
    if outer not in ("namespace", "type"):
        return "block"
    if _TYPE.search(head):
        return "type"
    if "(" not in head or _CONTROL.match(head) or re.search(r"=\s*$", head):
        return "block"
    # A member that is initialised by braces, before the body of a constructor.
    member = re.search(r"[\w>]\s*$", head) and not _AFTER_PARAMETERS.search(head)
    return "initialiser" if member else "function"


def _count_parameters(text: str) -> int:
    """Number of parameters in a text that begins with the opening parenthesis."""
    level, commas, empty = 0, 0, True
    for character in text:
        if character in "(<[{":
            level += 1
        elif character in ")>]}":
            level -= 1
            if level == 0:
                break
        elif not character.isspace():
            empty = False
            commas += character == "," and level == 1
    return 0 if empty else commas + 1


def _function(code: str, head: tuple[int, int], end: int) -> Function:
    text = code[slice(*head)]
    parenthesis = text.index("(")
    name = _NAME.search(text[:parenthesis])
    first = code.count("\n", 0, head[0] + len(text) - len(text.lstrip())) + 1
    lines = code.count("\n", 0, end) + 2 - first
    return Function(name.group(1) if name else "?", first, lines, _count_parameters(text[parenthesis:]))


def functions(source: str) -> list[Function]:
    """Functions with bodies, in the order of their ends; a lambda counts as part of the function around it."""
    code = without_texts(source)
    found: list[Function] = []
    open_braces: list[tuple[str, tuple[int, int], int]] = []  # kind, head, depth of parentheses before
    start = depth = 0
    for match in re.finditer(r"[{};()]", code):
        mark = match.group()
        if mark in "()":
            depth += 1 if mark == "(" else -1
        elif mark == "{":
            outer = open_braces[-1][0] if open_braces else "namespace"
            kind = "argument" if depth else _kind(code[start:match.start()], outer)
            open_braces.append((kind, (start, match.start()), depth))
            depth = 0
            start = start if kind == "initialiser" else match.end()
        elif mark == "}" and open_braces:
            kind, head, depth = open_braces.pop()
            if kind == "function":
                found.append(_function(code, head, match.start()))
            start = start if kind in ("initialiser", "argument") else match.end()
        elif mark == ";" and not depth:
            start = match.end()
    return found
