# SPDX-License-Identifier: BSD-3-Clause
"""Notes of a release from CHANGELOG.md, and whether all files that name the version agree."""

import re
from pathlib import Path

KINDS = ("Added", "Changed", "Deprecated", "Removed", "Fixed", "Security")  # of Keep a Changelog, in this order
UNRELEASED = "unreleased"
DATE = re.compile(r"\d{4}-\d{2}-\d{2}$")


class ReleaseNotesError(Exception):
    """Each disagreement, with its place and what is allowed."""


def version_of(checkout: Path) -> str:
    """Version in CMakeLists.txt, the one place where it is set."""
    return _found(checkout / "CMakeLists.txt", r"^project\(\w+ VERSION ([\d.]+)", "project(NAME VERSION …")


def _found(path: Path, expression: str, words: str) -> str:
    """Text that the group of an expression finds in a line of a file."""
    found = re.search(expression, path.read_text(encoding="utf-8"), re.MULTILINE)
    if not found:
        raise ReleaseNotesError(f"{path}: found no line {words}")
    return found[1]


def newest_section(path: Path) -> tuple[str, str, list[str]]:
    """Version, date or "unreleased", and lines of the first section of a CHANGELOG.md."""
    text = path.read_text(encoding="utf-8")
    heads = list(re.finditer(r"^## \[(\S+)\] - (\S+)$", text, re.MULTILINE))
    if not heads:
        raise ReleaseNotesError(f"{path}: found no heading such as ## [0.1.0] - 2026-01-31")
    end = heads[1].start() if len(heads) > 1 else len(text)
    return heads[0][1], heads[0][2], text[heads[0].end():end].splitlines()


def entries(lines: list[str], path: Path) -> dict[str, dict[str, list[str]]]:
    """Kind -> topic, "" without one -> entries, each without its dash and in one line."""
    found: dict[str, dict[str, list[str]]] = {kind: {} for kind in KINDS}
    current: list[str] | None = None
    for line in lines:
        if line.startswith("### "):
            kind, _, topic = line[4:].partition(": ")
            if kind not in KINDS:
                raise ReleaseNotesError(f"{path}: found the heading {line}, allowed: ### {', '.join(KINDS)}, each with "
                                        "\": TOPIC\" or without")
            current = found[kind].setdefault(topic, [])
        elif line.startswith("- ") and current is not None:
            current.append(line[2:].strip())
        elif line.strip() and current:
            current[-1] += f" {line.strip()}"
        elif line.strip():
            raise ReleaseNotesError(f"{path}: found \"{line.strip()}\" before any entry")
    return {kind: topics for kind, topics in found.items() if any(topics.values())}


def notes(checkout: Path, final: bool = False) -> str:
    """The notes in Markdown. final: with a date in CHANGELOG.md and the same one in CITATION.cff.

    @raises ReleaseNotesError  versions or dates differ, or the section is no such one
    """
    changelog, citation = checkout / "CHANGELOG.md", checkout / "CITATION.cff"
    version = version_of(checkout)
    cited = _found(citation, r"^version: (\S+)$", "version: …")
    listed, date, lines = newest_section(changelog)
    for path, other in ((citation, cited), (changelog, listed)):
        if other != version:
            raise ReleaseNotesError(f"{path}: found version {other}, allowed: {version}, that of CMakeLists.txt")
    if date != UNRELEASED and not DATE.match(date):
        raise ReleaseNotesError(f"{changelog}: found the date {date}, allowed: {UNRELEASED} or such as 2026-01-31")
    if final and date == UNRELEASED:
        raise ReleaseNotesError(f"{changelog}: found {UNRELEASED}, allowed: the date of the release")
    cited = _found(citation, r"^date-released: [\"']?([\d-]+)[\"']?$", f"date-released: {date}") if final else date
    if cited != date:
        raise ReleaseNotesError(f"{citation}: found date-released {cited}, allowed: {date}, that of CHANGELOG.md")
    text = [f"# Gabion {version}, {date}", ""]
    for kind, topics in entries(lines, changelog).items():
        text += [f"## {kind}", ""]
        for topic, items in topics.items():
            head = [f"### {topic[0].upper()}{topic[1:]}", ""] if topic else []
            text += [*head, *(f"- {item}" for item in items), ""]
    return "\n".join(text).rstrip("\n") + "\n"
