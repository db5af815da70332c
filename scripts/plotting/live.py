# SPDX-License-Identifier: BSD-3-Clause
"""A results folder that is read while a run writes it: tables, log, and the outcome of the run."""

import csv
import math
import re
import time
from enum import Enum
from pathlib import Path

from plotting.account import Cuts, Ledger, Steps
from plotting.lock import LOCK, MARKER, Owner, owner_of
from plotting.results import RESOLVED, SUMMARY, ResultsError, is_completed, object_of

STEPS_SHOWN = 60
QUIET = 10  # [s] without a new row from which on somebody asks why
LOST = 60  # [s] without a new row where no process can be asked
HERE = re.compile(r'participant "([^"]+)" \(([^ ,]+)(?: [^,]*)?, pid (\d+)\) is here')


class Tail:
    """A text file that is being written; each call of `lines`, or `rows` of a CSV file, gives the new ones."""

    def __init__(self, path: Path):
        self.path = path
        self._offset = 0
        self._names: list[str] = []

    def lines(self) -> list[str]:
        if not self.path.exists():
            return []
        with self.path.open("rb") as file:
            file.seek(self._offset)
            text = file.read()
        complete = text[: text.rfind(b"\n") + 1]  # the last line may be half written
        self._offset += len(complete)
        return complete.decode("utf-8", errors="replace").splitlines()

    def rows(self) -> list[dict[str, str]]:
        cells = list(csv.reader(self.lines()))
        if cells and not self._names:
            self._names = cells.pop(0)
        return [dict(zip(self._names, row)) for row in cells]


class State(Enum):
    """Outcome of a run."""

    COMPLETED = "completed"
    FAILED = "failed"
    STOPPED = "stopped"  # by a signal, in order
    RUNNING = "running"
    SILENT = "silent"  # without an end and without a new row for long; nobody can be asked
    KILLED = "killed"  # without an end, and its processes are gone

    @property
    def is_end(self) -> bool:
        return self not in (State.RUNNING, State.SILENT)


class Run:
    """Contents of a results folder so far.

    end: simulated time [s] at which the run is done, NaN if not known; steps: the last rows of steps.csv;
    iterations: the rows of iterations.csv of the last step tried; account, ledger, cuts: sums over all rows;
    summary: summary.json once the run has ended; owner: whether the process that writes here lives.
    """

    def __init__(self, folder: Path):
        if not folder.is_dir():
            raise ResultsError(f"{folder}: no such results folder")
        self.folder = folder
        self.end = math.nan
        self.steps: list[dict[str, str]] = []
        self.iterations: list[dict[str, str]] = []
        self.account, self.ledger, self.cuts = Steps(), Ledger(), Cuts()
        self.participants: dict[str, tuple[str, int]] = {}  # name -> program, process id, as the log has them
        self.summary: dict | None = None
        self.owner = Owner.NONE
        self._error = ""  # the last one in the log
        self._tails = {name: Tail(folder / name)
                       for name in ("steps.csv", "iterations.csv", "probes.csv", "coupler.log")}

    def read_on(self) -> None:
        self.owner = owner_of(self.folder)  # before the summary, which a run writes before it ends
        self._read_settings()
        new = self._tails["steps.csv"].rows()
        for row in new:
            self.account.add(row)
        self.steps = (self.steps + new)[-STEPS_SHOWN:]
        for row in self._tails["iterations.csv"].rows():
            self.cuts.add_iteration(row)
            if row["iteration"] == "0":
                self.iterations = []
            self.iterations.append(row)
        for row in self._tails["probes.csv"].rows():
            self.ledger.add(row)
        for line in self._tails["coupler.log"].lines():
            self.cuts.add_line(line)
            self._error = line.partition("error: ")[2] or self._error
            for name, program, pid in HERE.findall(line):
                self.participants[name] = (program, int(pid))
        summary = object_of(self.folder / SUMMARY)
        self.summary = self.summary if summary is None else summary

    def is_there(self) -> bool:
        """Whether a run has written here, even if only its signature."""
        return any((self.folder / name).exists() for name in (MARKER, LOCK, RESOLVED, SUMMARY, *self._tails))

    def _read_settings(self) -> None:
        if math.isnan(self.end):
            files = (object_of(self.folder / RESOLVED) or {}).values()  # half written: looked at again
            self.end = next((file["time"]["end"] for file in files if "time" in file), math.nan)

    @property
    def num_cuts(self) -> int:
        """Includes those of the current step, as far as the log has them."""
        return max(self.account.cut, self.cuts.reasons.total(), (self.summary or {}).get("cuts", 0))

    def seconds_since_last_row(self) -> float:
        written = [tail.path.stat().st_mtime for tail in self._tails.values() if tail.path.exists()]
        return time.time() - max(written, default=time.time())

    def state(self) -> State:
        if self.summary is not None:
            if is_completed(self.summary):
                return State.COMPLETED
            by_signal = self.summary.get("reason", "").startswith("interrupted by signal")
            return State.STOPPED if by_signal else State.FAILED
        if self.owner is Owner.ENDED and (self.folder / MARKER).exists():
            return State.FAILED
        if self.owner in (Owner.ALIVE, Owner.GONE):
            return State.RUNNING if self.owner is Owner.ALIVE else State.KILLED
        quiet = self.seconds_since_last_row()
        if self.participants:
            gone = not any(is_alive(program, pid) for program, pid in self.participants.values())
            return State.KILLED if gone and quiet > QUIET else State.RUNNING
        return State.SILENT if quiet > LOST else State.RUNNING

    @property
    def reason(self) -> str:
        """Reason why it was not completed."""
        return (self.summary or {}).get("reason") or self._error or "no reason given"

    def checkpoint(self) -> int | None:
        """Step of the last checkpoint."""
        steps = [int(path.parent.name.removeprefix("step_"))
                 for path in self.folder.glob("checkpoints/step_*/manifest.json")]
        return max(steps, default=None)


def is_alive(program: str, pid: int) -> bool:
    """Whether a process of this machine has this number and this program in its command line."""
    try:
        return program.encode() in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False
