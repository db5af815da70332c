# SPDX-License-Identifier: BSD-3-Clause
"""Run scenes for a study and write what came out."""

import csv
import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from measured import Page, text_of
from plotting.results import Results, ResultsError
from plotting.style import Figure, save
from studies.measures import Measured

ROOT = Path(__file__).resolve().parent.parent.parent
PATIENCE = 300  # [s] that an attempt may take


@dataclass
class Attempt:
    """A run that may have ended anyhow."""

    code: int | None  #: exit code; None: no end within PATIENCE
    results: Results | None  #: None without a summary


class Runner:
    """Runs scenes through scripts/run into folders of one study, prints what it finds and keeps it for a page.

    reuse: take the results of a run with the same label that came to its end instead of running.
    settings: for all runs, such as ["coupler.json:/time/end=0.3"].
    """

    def __init__(self, folder: Path, reuse: bool, settings: list[str]):
        self.folder = folder
        self.reuse = reuse
        self.settings = settings
        self.page = Page()

    def run(self, label: str, scene: str, settings: list[str]) -> Measured:
        """Run one scene.

        @raises ResultsError  the run failed
        """
        code, output = self._launch(label, scene, settings)
        if code != 0:
            raise ResultsError(f"{label}: the run failed with exit code {code}")
        return Measured(Results(output))

    def run_all(self, runs: list[tuple[str, str, list[str]]]) -> list[Measured]:
        """Runs (label, scene, settings), as many at a time as there are cores.

        @raises ResultsError  a run failed
        """
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
            return list(pool.map(lambda run: self.run(*run), runs))

    def attempts(self, runs: list[tuple[str, str, list[str]]]) -> list[Attempt]:
        """Runs (label, scene, settings) that may end early, as many at a time as there are cores.

        What they print goes to LABEL.log.
        """
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
            return list(pool.map(lambda run: self._attempt(*run), runs))

    def report(self, head: list[str], rows: list[list], name: str = "") -> None:
        """Print a table, write it as NAME.csv (table.csv without a name) and put it on the page."""
        print(f"\n{name}" if name else "")
        print_table(head, rows)
        write_table(self.folder / f"{name or 'table'}.csv", head, rows)
        self.page.add_table(head, rows, name)

    def remark(self, text: str) -> None:
        print(text)
        self.page.blocks.append(text[0].upper() + text[1:] + ".")

    def save(self, figure: Figure, name: str) -> None:
        """Write a figure into the folder of the study and put it on the page."""
        path = save(figure, self.folder / name)
        print(path)
        self.page.add_figure(path)

    def _launch(self, label: str, scene: str, settings: list[str]) -> tuple[int, Path]:
        """Exit code, 0 for results that are taken again, and the folder of the results."""
        output = self.folder / label
        if self.reuse and _completed(output):
            return 0, output
        print(f"{label}: running", flush=True)
        return subprocess.run(self._command(output, scene, settings), check=False).returncode, output

    def _attempt(self, label: str, scene: str, settings: list[str]) -> Attempt:
        output = self.folder / label
        if self.reuse and _ended(output):
            return Attempt(0 if _completed(output) else 3, Results(output))
        shutil.rmtree(output, ignore_errors=True)  # else a run that fails would stand beside it
        self.folder.mkdir(parents=True, exist_ok=True)
        print(f"{label}: running", flush=True)
        with (self.folder / f"{label}.log").open("w", encoding="utf-8") as log:
            try:
                code = subprocess.run(self._command(output, scene, settings), check=False, stdout=log,
                                      stderr=subprocess.STDOUT, timeout=PATIENCE).returncode
            except subprocess.TimeoutExpired:
                code = None
        return Attempt(code, Results(output) if (output / "summary.json").exists() else None)

    def _command(self, output: Path, scene: str, settings: list[str]) -> list[str]:
        command = [str(ROOT / "scripts/run"), str(ROOT / "configs" / scene), "--output", str(output),
                   "--no-plots", "--log-level", "warn"]
        for setting in [*self._settings_for(scene), *settings]:
            command += ["--set", setting]
        return command

    def _settings_for(self, scene: str) -> list[str]:
        """The common settings; those of files that the scene lacks do not concern it."""
        return [s for s in self.settings if (ROOT / "configs" / scene / s.partition(":")[0]).exists()]


def folder_of(name: str) -> str:
    """Name of the folder of a run from what its row is called."""
    return name.replace(",", "").replace(" ", "_")


def _completed(folder: Path) -> bool:
    if not (folder / "summary.json").exists():
        return False
    return bool(Results(folder).summary.get("completed", True))


def _ended(folder: Path) -> bool:
    """Completed, or with a reason."""
    return _completed(folder) or (folder / "summary.json").exists() and "reason" in Results(folder).summary


def print_table(head: list[str], rows: list[list]) -> None:
    """Right-aligned columns; numbers with four digits."""
    cells = [head, *[[text_of(value) for value in row] for row in rows]]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    for row in cells:
        print("  ".join(text.rjust(width) for text, width in zip(row, widths)))


def write_table(path: Path, head: list[str], rows: list[list]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *rows])
