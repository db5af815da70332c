#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The documents of the tree: links lead somewhere, lengths are kept, theory names what is in the code."""

import re
import unittest
from collections.abc import Iterator
from pathlib import Path

from script_case import ROOT, ScriptCase

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
CODE = re.compile(r"`[^`]*`")
NAMED = re.compile(r"`([a-z_0-9/]+\.(?:hpp|cpp|h|py)):\s([A-Za-z_0-9]+)`")
OPENING = re.compile(r"\*\*Question:\*\*\s.+\*\*Answer:\*\*\s.+\*\*How\s+sure:\*\*\s.+", re.DOTALL)
NOT_OURS = {"build", "results", ".git"}
MAX_WIDTH, MAX_README, MAX_FOLDER_README, MAX_CONTRIBUTING = 120, 110, 60, 110
LONG = {"README.md": MAX_README, "protocol/README.md": 400}  # the contract is one page


def documents(root: Path) -> list[Path]:
    return [path for path in sorted(root.rglob("*.md"))
            if not any(part in NOT_OURS or part.startswith("build-") for part in path.relative_to(root).parts)]


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, without code blocks: fenced, or indented after an empty line."""
    fenced = indented = False
    before = ""
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            fenced = not fenced
            continue
        if line.startswith("    "):
            indented = indented or not before.strip()
        elif line.strip():
            indented = False
        before = line
        if not fenced and not (indented and line.startswith("    ")):
            yield number, line


def anchors(text: str) -> set[str]:
    """Names of the headings, as GitHub makes them."""
    names = set()
    for _, line in prose(text):
        if line.startswith("#"):
            title = re.sub(r"[^\w\- ]", "", line.lstrip("#").strip().lower())
            names.add(title.replace(" ", "-"))
    return names


def broken_links(root: Path) -> Iterator[str]:
    for path in documents(root):
        for number, line in prose(path.read_text(encoding="utf-8")):
            for link in LINK.findall(CODE.sub("", line)):
                if "://" in link:
                    continue
                file, _, anchor = link.partition("#")
                target = path.parent / file if file else path
                place = f"{path.relative_to(root)}:{number}: {link}"
                if not target.exists():
                    yield f"{place}: not there"
                elif anchor and anchor not in anchors(target.read_text(encoding="utf-8")):
                    yield f"{place}: no such heading"


def long_lines(root: Path) -> Iterator[str]:
    """Tables, links and code may be wider; the changelog has a line a change."""
    for path in documents(root):
        if path.name == "CHANGELOG.md":
            continue
        for number, line in prose(path.read_text(encoding="utf-8")):
            if len(line) > MAX_WIDTH and not line.startswith("|") and not LINK.search(line):
                yield f"{path.relative_to(root)}:{number}: {len(line)} characters, allowed: {MAX_WIDTH}"


def long_readmes(root: Path) -> Iterator[str]:
    for path in documents(root):
        name = path.relative_to(root).as_posix()
        allowed = {"CONTRIBUTING.md": MAX_CONTRIBUTING, "README.md": LONG.get(name, MAX_FOLDER_README)}.get(path.name)
        lines = path.read_text(encoding="utf-8").count("\n")
        if allowed and lines > allowed:
            yield f"{name}: {lines} lines, allowed: {allowed}"


def missing_functions(root: Path) -> Iterator[str]:
    """Functions that docs/theory places in a file, and that are not there."""
    for path in sorted((root / "docs" / "theory").glob("*.md")):
        for file, name in NAMED.findall(path.read_text(encoding="utf-8")):
            if not (root / file).exists():
                yield f"{path.name}: {file} is not there"
            elif not re.search(rf"\b{name}\b", (root / file).read_text(encoding="utf-8")):
                yield f"{path.name}: no {name} in {file}"


def without_opening(root: Path) -> Iterator[str]:
    """Pages of docs/measured whose first paragraph is not question, answer and how sure that is."""
    for path in sorted((root / "docs" / "measured").glob("*.md")):
        paragraphs = path.read_text(encoding="utf-8").split("\n\n")
        opening = paragraphs[1] if len(paragraphs) > 1 else ""
        if path.name != "README.md" and not OPENING.match(opening):
            yield f"{path.name}: begins with {opening[:40]!r}"


def repeated_numbers(root: Path) -> Iterator[str]:
    """Each equation of docs/theory has a number of its own, in the order of the page."""
    for path in sorted((root / "docs" / "theory").glob("*.md")):
        numbers = re.findall(r"^    .*  \(([A-Z])(\d+)\)$", path.read_text(encoding="utf-8"), re.MULTILINE)
        found = [int(number) for _, number in numbers]
        if found != list(range(1, len(found) + 1)) or len({letter for letter, _ in numbers}) > 1:
            yield f"{path.name}: equations {' '.join(''.join(pair) for pair in numbers)}"


class Tree(unittest.TestCase):
    def test_links(self) -> None:
        self.assertEqual(list(broken_links(ROOT)), [])

    def test_widths_and_lengths(self) -> None:
        self.assertEqual([*long_lines(ROOT), *long_readmes(ROOT)], [])

    def test_openings(self) -> None:
        self.assertEqual(list(without_opening(ROOT)), [])

    def test_theory(self) -> None:
        self.assertEqual([*missing_functions(ROOT), *repeated_numbers(ROOT)], [])
        named = [found for path in (ROOT / "docs" / "theory").glob("*.md") for found in NAMED.findall(path.read_text())]
        self.assertGreater(len(named), 100)


class Findings(ScriptCase):
    """Each rule finds its breach, and nothing where there is none."""

    def test_links(self) -> None:
        self.write("other.md", "# Two words: (C1)\n")
        self.write("a.md", "[x](other.md#two-words-c1) `[y](none.md)` [z](https://a.b)\n\n    [code](none.md)\n")
        self.assertEqual(list(broken_links(self.folder)), [])
        self.write("b.md", "[x](none.md)\n[y](other.md#three)\n")
        self.assertEqual(list(broken_links(self.folder)),
                         ["b.md:1: none.md: not there", "b.md:2: other.md#three: no such heading"])

    def test_widths(self) -> None:
        wide = "x" * (MAX_WIDTH + 1)
        self.write("a.md", f"| {wide} |\n\n    {wide}\n\n```\n{wide}\n```\n{'x' * MAX_WIDTH}\n")
        self.assertEqual(list(long_lines(self.folder)), [])
        self.write("b.md", f"text\n    {wide}\n- {wide}\n")
        self.assertEqual([line.partition(": ")[0] for line in long_lines(self.folder)], ["b.md:2", "b.md:3"])

    def test_lengths(self) -> None:
        self.write("README.md", "x\n" * MAX_README)
        self.write("soil/README.md", "x\n" * MAX_FOLDER_README)
        self.assertEqual(list(long_readmes(self.folder)), [])
        self.write("soil/README.md", "x\n" * (MAX_FOLDER_README + 1))
        self.assertEqual(list(long_readmes(self.folder)), ["soil/README.md: 61 lines, allowed: 60"])

    def test_openings(self) -> None:
        self.write("docs/measured/a.md", "# A\n\n**Question:** which?\n**Answer:** this. **How sure:** very.\n\n| |\n")
        self.write("docs/measured/README.md", "# Measured\n\nTables.\n")
        self.assertEqual(list(without_opening(self.folder)), [])
        self.write("docs/measured/b.md", "# B\n\n`scripts/bench b`\n\n**Question:** which?\n")
        self.assertEqual(list(without_opening(self.folder)), ["b.md: begins with '`scripts/bench b`'"])

    def test_theory(self) -> None:
        self.write("soil/grid.cpp", "void map_points() {}\n")
        self.write("docs/theory/soil.md", "    a = b     (S1)\n\n`soil/grid.cpp: map_points`\n\n    c = d     (S2)\n")
        self.assertEqual([*missing_functions(self.folder), *repeated_numbers(self.folder)], [])
        self.write("docs/theory/soil.md",
                   "    a = b     (S1)\n\n`soil/grid.cpp: map`, `soil/no.cpp: x`\n\n    c     (S1)\n")
        self.assertEqual([*missing_functions(self.folder), *repeated_numbers(self.folder)],
                         ["soil.md: no map in soil/grid.cpp", "soil.md: soil/no.cpp is not there",
                          "soil.md: equations S1 S1"])


if __name__ == "__main__":
    unittest.main()
