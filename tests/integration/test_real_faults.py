#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The real programs in trouble: killed, stopped for good or for a while, at a named phase, or without room on the
disk. Every run ends in time, says who and when, and leaves no process; from its last checkpoint it goes on to the
rows of a run without trouble.

    test_real_faults.py BIN_FOLDER [words of cells to play]
"""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from launch import ONE_THREAD, endless, free_endpoint, read_table
from restart_rows import rows_of_steps
from wire_tap import WireTap

WORKERS = 4  # cells at once
CONNECT, SILENCE, HEARTBEAT = 6.0, 2.5, 0.2  # [s] deadlines of the scene
PAUSE = 1.0  # [s] of a program that is late, shorter than the silence deadline
LIMIT = 40  # [s] for any process
STEPS, STRUCK = 8, 4  # steps of the run; the one in which it happens
TABLES = ("steps", "probes", "iterations")
PROGRAM = {"soil": "mpm_solver", "structure": "fem_solver", "coupler": "coupler"}
PHASES = {"handshake": "handshake", "solve": f"solve_step {STRUCK} iteration 0", "output": "write_output"}


@dataclass(frozen=True)
class Cell:
    """kind: killed, stopped, late, disk; phase: of PHASES, or what cannot be written."""

    kind: str
    who: str
    phase: str
    room: int = 0  # [bytes] that a file of this program may have, 0: any


def cells() -> list[Cell]:
    strikes = [Cell(kind, who, phase) for who in PROGRAM for phase in PHASES for kind in ("killed", "stopped", "late")]
    full = [Cell("disk", "soil", "frame", 6000), Cell("disk", "structure", "frame", 6000),
            Cell("disk", "soil", "checkpoint", 30000), Cell("disk", "structure", "checkpoint", 12000),
            Cell("disk", "coupler", "checkpoint", 20000), Cell("disk", "coupler", "table", 1500)]
    return strikes + full


def scene() -> dict[str, dict]:
    """A scene in contact from the first step."""
    files = endless(in_contact=True)
    files["coupler"] |= {
        "time": {"end": STEPS * 5e-4, "dt": 5e-4, "dt_min": 1e-6}, "output": {"interval": 1e-3},
        "checkpoint": {"steps": 1},
        "protocol": {"connect_deadline": CONNECT, "silence_deadline": SILENCE, "heartbeat": HEARTBEAT,
                     "answer_deadline": 20, "idle_deadline": 20}}
    return files


class Wrong(Exception):
    """The run did not end as it must."""


def require(condition: object, what: str) -> None:
    if not condition:
        raise Wrong(what)


class Run:
    """The three programs in a folder of their own, with a tap on the wire."""

    def __init__(self, binaries: Path, cell: Cell | None) -> None:
        self.binaries, self.cell = binaries, cell
        self.folder = Path(tempfile.mkdtemp(prefix="gabion_real_"))
        self.out = self.folder / "out"
        self.processes: dict[str, subprocess.Popen] = {}
        self.struck = 0.0  # monotonic time of the misdeed [s]
        self.continue_at = 0.0  # of the program that is late
        (self.folder / "scene").mkdir()
        for name, content in scene().items():
            (self.folder / "scene" / f"{name}.json").write_text(json.dumps(content), encoding="utf-8")
        self.endpoint = free_endpoint()
        self.tap = WireTap(self.endpoint, self.before, self.after)

    def start(self, who: str, *options: object) -> None:
        command = [self.binaries / PROGRAM[who], self.folder / "scene", "--output", self.out, *options]
        command += ["--coupler", self.endpoint if who == "coupler" else self.tap.endpoint]
        if who != "coupler":
            command += ["--connect-deadline", CONNECT]
        if self.cell and self.cell.room and who == self.cell.who:
            command = ["env", "--ignore-signal=XFSZ", *command]  # so that writing fails with EFBIG, as on a full disk
        with (self.folder / f"{who}.txt").open("w", encoding="utf-8") as out:
            self.processes[who] = subprocess.Popen(
                [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                env=os.environ | ONE_THREAD, start_new_session=True)

    def start_all(self) -> None:
        """The culprit of a handshake first, and alone unless it comes back; but a coupler with a participant."""
        cell = self.cell
        self.start("coupler")
        first = {"soil": "soil", "structure": "structure", "coupler": "soil"}[cell.who] if cell else "soil"
        self.start(first)
        if cell and cell.phase == "handshake":
            self.wait_until(lambda: self.struck, "the hello")
            if cell.who == first and cell.kind != "late":
                return
        self.start("structure" if first == "soil" else "soil")

    # The tap calls these when the moment has come. The program that is struck must not have answered yet.

    def before(self, _way: str, who: str, header: dict) -> None:
        if not self.cell or self.struck or who != ("soil" if self.cell.who == "coupler" else self.cell.who):
            return
        phase, kind = self.cell.phase, header["type"]
        hello = phase == "handshake" and self.cell.who == "coupler" and kind == "hello"
        first = kind == "solve_step" and (header["step"], header["iteration"]) == (STRUCK, 0)
        solve = phase not in ("handshake", "output") and first  # for a full disk too
        output = phase == "output" and kind == "write_output" and header["time"] > 0
        if hello or solve or output:
            self.strike()

    def after(self, _way: str, who: str, header: dict) -> None:
        """A participant is struck when its hello is on the way to the coupler."""
        if self.cell and not self.struck and (who, self.cell.phase, header["type"]) == (
                self.cell.who, "handshake", "hello"):
            self.strike()

    def strike(self) -> None:
        process = self.processes[self.cell.who]
        if self.cell.room:
            resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (self.cell.room, self.cell.room))
        else:
            os.kill(process.pid, signal.SIGKILL if self.cell.kind == "killed" else signal.SIGSTOP)
        self.struck = time.monotonic()

    # The player calls these.

    def text(self, who: str) -> str:
        return (self.folder / f"{who}.txt").read_text(encoding="utf-8", errors="replace")

    def texts(self) -> str:
        return "\n".join(f"--- {who} ({process.poll()})\n{self.text(who)}" for who, process in self.processes.items())

    def wait_until(self, condition, what: str) -> None:
        end = time.monotonic() + LIMIT
        while not condition():
            require(time.monotonic() < end, f"not within {LIMIT} s: {what}")
            time.sleep(0.02)

    def wait_end(self, *but: str) -> None:
        for who, process in self.processes.items():
            if who not in but:
                self.wait_until(lambda p=process: p.poll() is not None, f"the end of {who}")

    def code(self, who: str) -> int:
        return self.processes[who].returncode

    def clear(self) -> None:
        for process in self.processes.values():
            if process.poll() is None:
                process.kill()
            process.wait()
        self.tap.close()
        shutil.rmtree(self.folder)


def require_line(text: str, *words: str) -> None:
    found = any(all(word in line for word in words) for line in text.splitlines() if "error: " in line)
    require(found, f"no line with {words}")


def play_strike(run: Run) -> float:
    cell = run.cell
    run.start_all()
    run.wait_until(lambda: run.struck, "the moment to strike")
    pid = run.processes[cell.who].pid
    if cell.kind == "late":
        time.sleep(PAUSE)
        os.kill(pid, signal.SIGCONT)
    run.wait_end(*[cell.who] * (cell.kind == "stopped"))
    seconds = time.monotonic() - run.struck
    if cell.kind == "late":
        require(all(run.code(who) == 0 for who in PROGRAM), "a program that was only late spoilt the run")
        return seconds
    check_what_is_said(run)
    if cell.kind == "stopped":
        os.kill(pid, signal.SIGCONT)
        run.wait_end()
        require(run.code(cell.who) not in (0, None), f"{cell.who} goes on alone, and ends with exit code 0")
    return seconds


def check_what_is_said(run: Run) -> None:
    """Who is left names who is lost, and the phase."""
    cell = run.cell
    stopped = ("is silent for", f"limit {SILENCE:g} s", "its process is stopped")
    how = ("has died",) if cell.kind == "killed" else stopped
    for who in run.processes.keys() - {cell.who}:
        require(run.code(who) == 4, f"exit code of {who}: {run.code(who)}, expected 4")
        if who == "coupler":
            require_line(run.text(who), f'participant "{cell.who}"', *how, f'in phase "{PHASES[cell.phase]}"')
        elif cell.who != "coupler":
            require_line(run.text(who), "the coupler ended the run: ")
        elif cell.phase == "handshake":
            require_line(run.text(who), "no answer from a coupler", f"within {CONNECT:g} s")
        else:
            require_line(run.text(who), "the coupler (pid", *how, "last sign of life")


def play_disk(run: Run) -> float:
    cell = run.cell
    run.start_all()
    run.wait_end()
    for who in PROGRAM:
        require(run.code(who) not in (0, None), f"{who} ended with exit code {run.code(who)}")
    require_line(run.text(cell.who), "File too large" if cell.phase != "table" else "could not be written (disk full?)",
                 {"frame": ".h5", "checkpoint": "checkpoints/step_", "table": ".csv"}[cell.phase])
    if cell.who != "coupler":
        require_line(run.text("coupler"), f'participant "{cell.who}"', "File too large")
    return time.monotonic() - run.struck


def go_on(run: Run, straight: Path) -> None:
    """Go on from the last checkpoint to the end; the rows are those of the run without trouble."""
    checkpoints = list((run.out / "checkpoints").glob("step_*/manifest.json"))
    if run.cell.kind != "late" and run.cell.phase != "handshake":
        require(checkpoints, "there is no checkpoint")
    if run.cell.kind == "late" or not checkpoints:
        return
    done = max(int(path.parent.name.removeprefix("step_")) for path in checkpoints)
    first, run.out, run.cell = run.out, run.folder / "second", None
    require(len(read_table(first / "steps.csv")) in (done, done + 1), "the last checkpoint is not of the last step")
    run.endpoint = free_endpoint()
    run.tap.close()
    run.tap = WireTap(run.endpoint, run.before, run.after)
    run.start("coupler", "--restart", first)
    run.start("soil")
    run.start("structure")
    run.wait_end()
    require(all(run.code(who) == 0 for who in PROGRAM), "the run from the last checkpoint failed")
    compare(run.out, straight, done + 1, whole=True)


def compare(results: Path, straight: Path, first: int, whole: bool) -> None:
    for table in TABLES:
        require(rows_of_steps(results, table, first, STEPS, whole) == rows_of_steps(straight, table, first, STEPS),
                f"{table}.csv differs from the run without trouble")


def play(binaries: Path, cell: Cell, straight: Path) -> tuple[float, str]:
    """Seconds from the misdeed to the end, and what is wrong with the end."""
    run = Run(binaries, cell)
    try:
        seconds = (play_disk if cell.kind == "disk" else play_strike)(run)
        if cell.kind == "late":
            compare(run.out, straight, 1, whole=False)
        go_on(run, straight)
        return seconds, ""
    except Exception as problem:  # noqa: BLE001 - the other cells go on
        return 0.0, f"{type(problem).__name__}: {problem}\n{run.texts()}"
    finally:
        run.clear()


def main() -> int:
    binaries, words = Path(sys.argv[1]).resolve(), sys.argv[2:]
    chosen = [cell for cell in cells() if all(word in (cell.kind, cell.who, cell.phase) for word in words)]
    begin = time.monotonic()
    model = Run(binaries, None)
    try:
        model.start_all()
        model.wait_end()
        require(all(model.code(who) == 0 for who in PROGRAM), f"the run without trouble failed\n{model.texts()}")
        with ThreadPoolExecutor(WORKERS) as pool:
            results = dict(zip(chosen, pool.map(lambda cell: play(binaries, cell, model.out), chosen)))
    finally:
        model.clear()
    wrong = {cell: problem for cell, (_, problem) in results.items() if problem}
    for cell, problem in wrong.items():
        print(f"=== {cell.kind}, {cell.who}, {cell.phase}: {problem}\n")
    for cell, (seconds, problem) in results.items():
        print(f"{f'{cell.kind}, {cell.who}, {cell.phase}':<32}{'WRONG' if problem else format(seconds, '.2f'):>8}")
    print(f"{len(results)} cells in {time.monotonic() - begin:.0f} s, {len(wrong)} wrong")
    return 1 if wrong or not results else 0


if __name__ == "__main__":
    sys.exit(main())
