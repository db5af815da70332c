# SPDX-License-Identifier: BSD-3-Clause
"""Run scenes for a study and write their results."""

import csv
import json
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from measured import Page, text_of
from plotting.lock import Owner, owner_of
from plotting.results import SUMMARY, Results, ResultsError, object_of
from plotting.style import Figure, save
from studies.identity import identity_of
from studies.measures import Measured

ROOT = Path(__file__).resolve().parent.parent.parent
CORES = len(os.sched_getaffinity(0))
PATIENCE = 300  # [s] that an attempt may take
FAILED_STEP = 3  # exit code: a step cannot be solved, which the same settings do again
BUSY = 2  # exit code of a run whose folder is in use, as of the programs


@dataclass
class Attempt:
    """A run that may have ended anyhow."""

    code: int | None  #: exit code; None: no end in time
    results: Results | None  #: None without a summary
    reason: str = ""  #: why it was not started


@dataclass(frozen=True)
class Start:
    """How runs are started. at_once: number of them at a time; patience: that an attempt may take [s], None: any;
    words: further options of scripts/run."""

    at_once: int = CORES
    patience: float | None = PATIENCE
    words: tuple[str, ...] = ()


class Runner:
    """Runs scenes through scripts/run into folders of one study, prints what it finds and keeps it for a page.

    reuse: take the results of a run with the same label that came to its end instead of running, where LABEL.run.json
    says that it was of the same scene, settings and version.
    settings: for all runs, such as ["coupler.json:/time/end=0.3"].
    """

    def __init__(self, folder: Path, reuse: bool, settings: list[str], start: Start = Start()):
        self.folder = folder
        self.reuse = reuse
        self.settings = settings
        self.start = start
        self.page = Page()
        self._processes: set[subprocess.Popen] = set()
        self._lock = threading.Lock()
        self._stopping = False

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
        with ThreadPoolExecutor(self.start.at_once) as pool:
            return list(pool.map(lambda run: self.run(*run), runs))

    def attempts(self, runs: list[tuple[str, str, list[str]]],
                 ended: Callable[[str, Attempt], None] = lambda label, attempt: None) -> list[Attempt]:
        """Runs (label, scene, settings) that may end early, as many at a time as there are cores.

        What they print goes to LABEL.log. ended: is told of each; when it raises, or a signal does, the current runs
        are ended in order and no other one begins.
        """
        with ThreadPoolExecutor(self.start.at_once) as pool:
            futures = {pool.submit(self._attempt, *run): run[0] for run in runs}
            try:
                for future in as_completed(futures):
                    ended(futures[future], future.result())
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                self._stop()
                raise
        return [future.result() for future in futures]

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
        identity = self.identity(scene, settings)
        if self.reuse and self._has_run(label, identity) and Results(output).completed:
            return 0, output
        print(f"{label}: running", flush=True)
        self.forget(label)
        code = subprocess.run(self._command(output, scene, settings), check=False).returncode
        if code == 0:
            self._record(label, identity, scene, settings)
        return code, output

    def _attempt(self, label: str, scene: str, settings: list[str]) -> Attempt:
        output = self.folder / label
        identity = self.identity(scene, settings)
        if self.reuse and self._has_run(label, identity):
            results = Results(output)
            return Attempt(0 if results.completed else FAILED_STEP, results)
        if owner_of(output) in (Owner.ALIVE, Owner.UNKNOWN):
            return Attempt(BUSY, None, f"{output}: in use by another program")
        self.forget(label)
        shutil.rmtree(output, ignore_errors=True)  # else a run that fails would stand beside it
        self.folder.mkdir(parents=True, exist_ok=True)
        print(f"{label}: running", flush=True)
        with (self.folder / f"{label}.log").open("w", encoding="utf-8") as log:
            code = self._execute(self._command(output, scene, settings), log)
        results = Results(output) if (output / SUMMARY).exists() else None
        if code == 0 or code == FAILED_STEP and results is not None:
            self._record(label, identity, scene, settings)
        return Attempt(code, results)

    def _execute(self, command: list[str], log: TextIO) -> int | None:
        """Exit code, None: no end in time. The command ends with this process, and gets no signal of its terminal."""
        with self._lock:
            if self._stopping:
                return 128 + signal.SIGTERM
            process = subprocess.Popen(["setpriv", "--pdeathsig", "TERM", *command], stdout=log, start_new_session=True,
                                       stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT)
            self._processes.add(process)
        try:
            return process.wait(self.start.patience)
        except subprocess.TimeoutExpired:
            process.terminate()
            process.wait()
            return None
        finally:
            self._processes.discard(process)

    def _stop(self) -> None:
        """End the current runs in order."""
        with self._lock:
            self._stopping = True
            for process in list(self._processes):
                process.terminate()

    def identity(self, scene: str, settings: list[str]) -> str:
        """Identity of this run."""
        return identity_of(ROOT / "configs" / scene, list(self.start.words), [*self._settings_for(scene), *settings])

    def _note(self, label: str) -> Path:
        """File beside the results that says what they are of."""
        return self.folder / f"{label}.run.json"

    def _has_run(self, label: str, identity: str) -> bool:
        """Whether there are results of this run to its end, or to a step that cannot be solved."""
        note = object_of(self._note(label))
        return note is not None and note.get("identity") == identity and (self.folder / label / SUMMARY).exists()

    def _record(self, label: str, identity: str, scene: str, settings: list[str]) -> None:
        note = {"identity": identity, "scene": scene, "settings": [*self._settings_for(scene), *settings],
                "words": list(self.start.words)}
        self._note(label).write_text(json.dumps(note, indent=1) + "\n", encoding="utf-8")

    def forget(self, label: str) -> None:
        """Let results of this label not be taken again."""
        self._note(label).unlink(missing_ok=True)

    def _command(self, output: Path, scene: str, settings: list[str]) -> list[str]:
        # One rank each unless a study says otherwise: what is measured does not depend on the cores of the machine.
        command = [str(ROOT / "scripts/run"), str(ROOT / "configs" / scene), "--output", str(output),
                   "--no-plots", "--log-level", "warn", "--ranks", "mpm=1", *self.start.words]
        for setting in [*self._settings_for(scene), *settings]:
            command += ["--set", setting]
        return command

    def _settings_for(self, scene: str) -> list[str]:
        """The common settings; those of files that the scene lacks do not concern it."""
        return [s for s in self.settings if (ROOT / "configs" / scene / s.partition(":")[0]).exists()]


def folder_of(name: str) -> str:
    """Name of the folder of a run from what its row is called."""
    return name.replace(",", "").replace(" ", "_")


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
