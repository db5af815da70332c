# SPDX-License-Identifier: BSD-3-Clause
"""The state of a run under way, from the tables it is writing."""

import contextlib
import csv
import json
import math
import time
from pathlib import Path

from plotting.results import ResultsError

WIDTH = 40  # characters of a bar
STEPS_SHOWN = 60
ITERATIONS_SHOWN = 12
LEVELS = " ▁▂▃▄▅▆▇█"


class Tail:
    """Rows of a CSV file that is being written; each call of `rows` gives those that are new."""

    def __init__(self, path: Path):
        self.path = path
        self._offset = 0
        self._names: list[str] = []

    def rows(self) -> list[dict[str, str]]:
        if not self.path.exists():
            return []
        with self.path.open("rb") as file:
            file.seek(self._offset)
            text = file.read()
        complete = text[: text.rfind(b"\n") + 1]  # the last line may be half written
        self._offset += len(complete)
        cells = list(csv.reader(complete.decode("utf-8").splitlines()))
        if cells and not self._names:
            self._names = cells.pop(0)
        return [dict(zip(self._names, row)) for row in cells]


class Run:
    """What a results folder tells so far.

    end: simulated time [s] at which the run is done, NaN if not known; steps: the last rows of steps.csv; iterations: the
    rows of iterations.csv of the last step tried; summary: summary.json once the run has ended.
    """

    def __init__(self, folder: Path):
        if not folder.is_dir():
            raise ResultsError(f"{folder}: no such results folder")
        self.folder = folder
        self.end = math.nan
        self.steps: list[dict[str, str]] = []
        self.iterations: list[dict[str, str]] = []
        self.num_steps = 0
        self.cuts = 0
        self.summary: dict | None = None
        self._step_tail = Tail(folder / "steps.csv")
        self._iteration_tail = Tail(folder / "iterations.csv")

    def read_on(self) -> None:
        config = self.folder / "resolved_config.json"
        if math.isnan(self.end) and config.exists():
            with contextlib.suppress(ValueError):  # half written: looked at again
                files = json.loads(config.read_text(encoding="utf-8")).values()
                self.end = next((file["time"]["end"] for file in files if "time" in file), math.nan)
        new = self._step_tail.rows()
        self.num_steps += len(new)
        self.cuts += sum(int(row.get("cuts") or 0) for row in new)
        self.steps = (self.steps + new)[-STEPS_SHOWN:]
        for row in self._iteration_tail.rows():
            if row["iteration"] == "0":
                self.iterations = []
            self.iterations.append(row)
        summary = self.folder / "summary.json"
        if summary.exists():
            with contextlib.suppress(ValueError):
                self.summary = json.loads(summary.read_text(encoding="utf-8"))

    def seconds_since_last_row(self) -> float:
        tables = [self._step_tail.path, self._iteration_tail.path]
        return time.time() - max((t.stat().st_mtime for t in tables if t.exists()), default=time.time())


def view(run: Run) -> list[str]:
    """Lines for a terminal of 100 columns."""
    lines = [f"{run.folder}   {_state(run)}", ""]
    if run.steps:
        lines += _progress(run.steps, run)
    if run.iterations:
        lines += ["", *_residuals(run.iterations)]
    if run.steps and "iterations" in run.steps[-1]:
        counts = [int(row["iterations"]) for row in run.steps]
        lines += ["", f"iterations of the last {len(counts)} steps, at most {max(counts)}:  {_sparkline(counts)}"]
    if run.steps:
        lines += _shares(run.steps)
    return lines


def _state(run: Run) -> str:
    if run.summary is None:
        quiet = run.seconds_since_last_row()
        return "running" if quiet < 10 else f"no new row for {quiet:.0f} s"
    if run.summary["completed"]:
        return "completed"
    return f"failed: {run.summary.get('reason', 'no reason given')}"


def _progress(steps: list[dict[str, str]], run: Run) -> list[str]:
    last = steps[-1]
    now, dt = float(last["time"]), float(last["dt"])
    line = f"step {last['step']}   {now:.6g} s   dt {dt:.3g} s   cuts {run.cuts}"
    if math.isnan(run.end):
        return [line]
    wall = sum(float(row["wall_seconds"]) for row in steps)
    simulated = sum(float(row["dt"]) for row in steps)
    share = min(1.0, now / run.end)
    rest = "" if run.summary else f"   about {_duration((run.end - now) * wall / simulated)} left"
    full = round(WIDTH * share)
    return [line, f"[{'█' * full}{'·' * (WIDTH - full)}] {100 * share:.0f} % of {run.end:g} s{rest}"]


def _duration(seconds: float) -> str:
    """As the progress line of the programs has it."""
    if seconds < 119.5:
        return f"{seconds:.0f} s"
    if seconds >= 3599.5:
        return f"{seconds / 3600:.1f} h"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60} s"


def _residuals(iterations: list[dict[str, str]]) -> list[str]:
    """A bar from the limit (empty) to 1e6 times the limit (full), for each iteration of the step."""
    first = iterations[0]
    lines = [f"step {first['step']}, residual by limit (converged below 1):",
             f"{'':4}{'displacement':>14} {'force':>11} {'omega':>8} {'columns':>8}   status"]
    for row in iterations[-ITERATIONS_SHOWN:]:
        ratio = _ratio(row, "displacement")
        bar = ""
        if ratio is not None and ratio > 1:
            bar = "▪" * min(20, math.ceil(20 * math.log10(ratio) / 6))
        lines.append(f"{row['iteration']:>3} {_number(ratio):>14} {_number(_ratio(row, 'force')):>11} "
                     f"{float(row['omega']):>8.3g} {row['columns']:>8}   {row['status']:<10} {bar}".rstrip())
    return lines


def _ratio(row: dict[str, str], field: str) -> float | None:
    residual, limit = row[f"{field}_residual"], row[f"{field}_limit"]
    if not residual or not limit or not float(limit):
        return None
    return float(residual) / float(limit)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _sparkline(counts: list[int]) -> str:
    highest = max(counts)
    return "".join(LEVELS[math.ceil((len(LEVELS) - 1) * count / highest)] for count in counts)


def _shares(steps: list[dict[str, str]]) -> list[str]:
    """Where the wall time of the steps went, of each participant."""
    wall = sum(float(row["wall_seconds"]) for row in steps)
    lines = []
    for column in steps[-1]:
        if not column.endswith(".busy_seconds"):
            continue
        name = column.removesuffix(".busy_seconds")
        parts = [f"{100 * sum(float(row[f'{name}.{kind}_seconds']) for row in steps) / wall:4.0f} % {word}"
                 for kind, word in (("busy", "computing"), ("message", "messages"), ("waiting", "waiting"))
                 if f"{name}.{kind}_seconds" in steps[-1]]
        lines.append(f"{name:>12}: {','.join(parts)}")
    return ["", f"wall time of the last {len(steps)} steps, {1e3 * wall / len(steps):.3g} ms a step", *lines]
