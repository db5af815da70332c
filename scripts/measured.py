# SPDX-License-Identifier: BSD-3-Clause
"""Pages of docs/measured: results of a command, with version, machine and date."""

import datetime
import os
import platform
import re
import shutil
import textwrap
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "measured"
WIDTH = 120  # of lines of prose
# Written by hand, and kept when a command writes the page again: its opening, and what follows KEPT.
OPENING = re.compile(r"^\*\*Question:\*\* .*?(?=\n\n|\Z)", re.MULTILINE | re.DOTALL)
KEPT = "\n## What it shows\n"


def text_of(value: object) -> str:
    """A cell: numbers with four digits."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def markdown_table(head: list[str], rows: list[list]) -> str:
    lines = [head, ["---"] * len(head), *[[text_of(value) for value in row] for row in rows]]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


@dataclass
class Page:
    """Tables, remarks and figures in the order in which a command shows them."""

    blocks: list[str] = field(default_factory=list)
    figures: list[Path] = field(default_factory=list)

    def add_table(self, head: list[str], rows: list[list], title: str = "") -> None:
        self.blocks += [f"**{title}**"] * bool(title) + [markdown_table(head, rows)]

    def add_figure(self, path: Path) -> None:
        """Copied beside the page when that is written."""
        self.figures.append(path)
        self.blocks.append(f"![{path.stem.replace('_', ' ')}]({path.name})")


def version() -> str:
    """Version of the project, from CMakeLists.txt."""
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"^project\(\w+ VERSION (\S+)", text, re.MULTILINE)[1]


def machine() -> str:
    """Cores, model of the processor and memory; no names."""
    def line(file: str, key: str) -> str:
        try:
            text = Path(file).read_text(encoding="utf-8")
        except OSError:
            return ""
        found = re.search(rf"^{key}\s*:\s*(.+)$", text, re.MULTILINE)
        return found[1].strip() if found else ""

    model = line("/proc/cpuinfo", "model name") or platform.machine()
    memory = line("/proc/meminfo", "MemTotal").removesuffix(" kB")
    size = f", {int(memory) / 2**20:.1f} GiB" if memory else ""
    return f"{len(os.sched_getaffinity(0))} cores of {model}{size}"


def wrapped(block: str) -> str:
    """Prose of a block in lines of WIDTH; tables and figures as they are."""
    def fill(line: str) -> str:
        if len(line) <= WIDTH or line.startswith(("|", "#", "![")):
            return line
        return textwrap.fill(line, WIDTH, subsequent_indent="  " * line.startswith("- "), break_long_words=False,
                             break_on_hyphens=False)

    return "\n".join(map(fill, block.splitlines()))


def write_page(path: Path, title: str, command: str, page: Page) -> None:
    """Write a page and its figures; the opening and the part "What it shows" of an earlier one stay."""
    path.parent.mkdir(parents=True, exist_ok=True)
    before = path.read_text(encoding="utf-8") if path.exists() else ""
    today = datetime.date.today().isoformat()
    opening = [match[0] for match in OPENING.finditer(before.partition(KEPT)[0])][:1]
    source = f"`{command}`: version {version()}, {machine()}, {today}"
    text = "\n\n".join(wrapped(block) for block in [f"# {title}", *opening, source, *page.blocks]) + "\n"
    path.write_text(text + "".join(before.partition(KEPT)[1:]), encoding="utf-8")
    for figure in page.figures:
        shutil.copyfile(figure, path.parent / figure.name)
