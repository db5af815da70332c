# SPDX-License-Identifier: BSD-3-Clause
"""Lines on a running simulation for a terminal of 100 columns."""

import math
import textwrap

from plotting.live import Run
from plotting.verdict import headline, verdict
from plotting.words import duration

WIDTH = 40  # characters of a bar
ITERATIONS_SHOWN = 12
LEVELS = " ▁▂▃▄▅▆▇█"
MARKS = {"good": "✓", "note": "!", "bad": "✗"}


def view(run: Run) -> list[str]:
    """Lines for a terminal of 100 columns."""
    lines = [f"{run.folder}   {headline(run)}", ""]
    if run.steps:
        lines += _progress(run.steps, run)
    if run.iterations:
        lines += ["", *_residuals(run.iterations)]
    if run.steps and "iterations" in run.steps[-1]:
        counts = [int(row["iterations"]) for row in run.steps]
        lines += ["", f"iterations of the last {len(counts)} steps, at most {max(counts)}:  {_sparkline(counts)}"]
    if run.steps:
        lines += _shares(run.steps)
    return [*lines, "", *words(run)]


def words(run: Run) -> list[str]:
    """The verdict, a mark in front of each statement."""
    lines = []
    for statement in verdict(run):
        mark = f"{MARKS[statement.kind]} "
        lines += textwrap.wrap(mark + statement.text, 100, subsequent_indent="  ", break_on_hyphens=False)
    return lines


def _progress(steps: list[dict[str, str]], run: Run) -> list[str]:
    last = steps[-1]
    now, dt = float(last["time"]), float(last["dt"])
    line = f"step {last['step']}   {now:.6g} s   dt {dt:.3g} s   cuts {run.num_cuts}"
    if math.isnan(run.end):
        return [line]
    wall = sum(float(row["wall_seconds"]) for row in steps)
    simulated = sum(float(row["dt"]) for row in steps)
    share = min(1.0, now / run.end)
    rest = "" if run.summary else f"   about {duration((run.end - now) * wall / simulated)} left"
    full = round(WIDTH * share)
    return [line, f"[{'█' * full}{'·' * (WIDTH - full)}] {100 * share:.0f} % of {run.end:g} s{rest}"]


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
    """Wall time of the steps by what it was spent on, of each participant."""
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
