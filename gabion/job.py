# SPDX-License-Identifier: BSD-3-Clause
"""A run in progress: started through scripts/run, followed by its output."""

import math
import os
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from ._root import ROOT
from .errors import RunError
from .results import Results

from plotting.live import Run, State
from plotting.lock import MARKER

LAST_LINES = 5
INTERVAL = 0.5  # [s] between looks


@dataclass(frozen=True)
class Progress:
    """Progress of a run: simulated time and its end [s] (NaN: not known yet), accepted steps, what has come of it."""

    time: float
    end: float
    steps: int
    state: State
    reason: str = ""  #: why it did not come to its end

    @property
    def share(self) -> float:
        """Part of the simulated time that is done, 0 to 1; NaN: not known yet."""
        return self.time / self.end

    def __str__(self) -> str:
        where = f"t = {self.time:.4g} s" + ("" if math.isnan(self.end) else f" of {self.end:.4g} s ({self.share:.0%})")
        return f"{where}, {self.steps} steps, {self.state.value}" + (f": {self.reason}" if self.reason else "")


def progress_of(run: Run) -> Progress:
    run.read_on()
    state = run.state()
    reason = run.reason if state in (State.FAILED, State.STOPPED) else ""
    return Progress(run.account.time, run.end, run.account.count, state, reason)


def follow(folder: str | Path, interval: float = INTERVAL) -> Iterator[Progress]:
    """Progress of the run with these results, every `interval` seconds until it ends; whoever started it.

    @raises plotting.results.ResultsError  no such folder
    """
    run = Run(Path(folder))
    while True:
        now = progress_of(run)
        yield now
        if now.state.is_end:
            return
        time.sleep(interval)


class Job:
    """A run that was started here. It goes on without being watched, and ends with `stop`."""

    def __init__(self, scene: Path, output: Path | None, words: list[str]):
        """words: options of scripts/run; output: None for a check, which has no results."""
        self.output = output
        self._before = self._mark()
        self._log = os.memfd_create("gabion_log")
        weakref.finalize(self, os.close, self._log)
        place = [] if output is None else ["--output", str(output)]
        self._process = subprocess.Popen([str(ROOT / "scripts" / "run"), str(scene), *place, *words], stdout=self._log,
                                         stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True)
        self._run: Run | None = None

    def _mark(self) -> tuple | None:
        """Changes when a run begins in the folder: until then it holds what an earlier run left."""
        try:
            found = (self.output / MARKER).stat()
        except (OSError, TypeError):
            return None
        return found.st_ino, found.st_mtime_ns

    @property
    def is_running(self) -> bool:
        return self._process.poll() is None

    @property
    def log(self) -> str:
        """Messages of scripts/run and the programs so far."""
        size = os.fstat(self._log).st_size  # read from the start: the position belongs to the programs, which write
        return os.pread(self._log, size, 0).decode(errors="replace")

    def progress(self) -> Progress:
        """Its progress now. Before its first step, also while programs are built, time 0."""
        has_ended = not self.is_running  # before the look: what it leaves is there when it ends
        if self._run is None and self._mark() not in (None, self._before):
            self._run = Run(self.output)
        now = progress_of(self._run) if self._run else Progress(0.0, math.nan, 0, State.RUNNING)
        if has_ended and not now.state.is_end:
            return replace(now, state=State.FAILED, reason=f"exit code {self._process.returncode}")
        return now

    def follow(self, interval: float = INTERVAL) -> Iterator[Progress]:
        """Its progress, every `interval` seconds until it ends."""
        while self.is_running:
            yield self.progress()
            try:
                self._process.wait(interval)
            except subprocess.TimeoutExpired:
                continue
        yield self.progress()

    def stop(self) -> None:
        """End the run in order, as Ctrl-C does; it leaves its last checkpoint. Waits for that."""
        if self.is_running:
            self._process.send_signal(signal.SIGTERM)
        self._process.wait()

    def finish(self) -> str:
        """Wait for the end; returns the messages. @raises RunError  the exit code is not 0"""
        try:
            code = self._process.wait()
        except BaseException:  # also the interruption of a notebook
            self.stop()
            raise
        if code != 0:
            lines = self.log.splitlines()
            errors = [line for line in lines if "error: " in line] or lines
            place = "check" if self.output is None else str(self.output)
            raise RunError(f"{place}: exit code {code}: " + "\n".join(errors[-LAST_LINES:]))
        return self.log

    def wait(self, progress: bool = False) -> Results:
        """Wait for the end and read the results. progress: print how far it is.

        @raises RunError  the run failed or was stopped
        """
        try:
            for now in self.follow() if progress else ():
                print(f"\r{now}\x1b[K", end="", file=sys.stderr, flush=True)
        except BaseException:
            self.stop()
            raise
        if progress:
            print(file=sys.stderr)
        self.finish()
        return Results(self.output)
