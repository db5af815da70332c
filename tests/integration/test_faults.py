#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plays fault_table.py: a real coupler between two participants without mechanics, of which one misbehaves at a
named phase. Every run must end, say who and when, leave no process, and complete tables.

    test_faults.py BIN_FOLDER [words of cells to play]
"""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import fault_table as table
from fault_table import Cell
from launch import COUPLER, ONE_THREAD, free_endpoint, read_table

WORKERS = 8  # cells at once: they mostly wait
PAUSE = 0.5  # [s] that the other participant takes where the culprit must strike in between
LIMIT = 40  # [s] for any process


class Wrong(Exception):
    """The run did not end as it must."""


class Run:
    """One coupler and its participants, in a folder of their own."""

    def __init__(self, binaries: Path, cell: Cell) -> None:
        self.binaries, self.cell = binaries, cell
        self.folder = Path(tempfile.mkdtemp(prefix="gabion_fault_"))
        self.processes: dict[str, subprocess.Popen] = {}
        self.begin = time.monotonic()
        self.endpoint = free_endpoint()
        scene = self.folder / "scene"
        scene.mkdir()
        settings = COUPLER | {
            "time": {"end": 0.05, "dt": 0.01, "dt_min": 1e-6},
            "output": {"interval": 0.04},
            "protocol": {"connect_deadline": cell.connect, "silence_deadline": cell.silence,
                         "answer_deadline": table.ANSWER, "heartbeat": table.HEARTBEAT, "idle_deadline": 10},
        }
        (scene / "coupler.json").write_text(json.dumps(settings), encoding="utf-8")

    def start(self, name: str, *command: object) -> subprocess.Popen:
        with (self.folder / f"{name}.txt").open("w", encoding="utf-8") as out:
            self.processes[name] = subprocess.Popen(
                [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                env=os.environ | ONE_THREAD, start_new_session=True)
        return self.processes[name]

    def start_coupler(self) -> None:
        self.start("coupler", self.binaries / "coupler", self.folder / "scene", "--output", self.folder / "out",
                   "--coupler", self.endpoint)

    def start_participant(self, who: str, *words: object, name: str = "") -> None:
        self.start(name or who, self.binaries / "fake_participant", who, self.endpoint, *words,
                   "--connect-deadline", self.cell.connect)

    def text(self, name: str) -> str:
        return (self.folder / f"{name}.txt").read_text(encoding="utf-8", errors="replace")

    def texts(self) -> str:
        return "\n".join(f"--- {name} ({process.poll()})\n{self.text(name)}"
                         for name, process in self.processes.items())

    def wait_until(self, condition: Callable[[], object], what: str) -> None:
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                raise Wrong(f"not within {LIMIT} s: {what}")
            time.sleep(0.01)

    def struck_at(self) -> float:
        """Monotonic time of the misdeed [s]; of the start when it is said at once."""
        strikes = [float(said) for name in self.processes
                   for said in re.findall(r"^strike (\S+)$", self.text(name), re.M)]
        return min(strikes, default=self.begin)

    def wait_all(self, *but: str) -> float:
        """Wait until all processes have ended. @returns [s] since the misdeed"""
        for name, process in self.processes.items():
            if name not in but:
                self.wait_until(lambda p=process: p.poll() is not None, f"the end of {name}")
        return time.monotonic() - self.struck_at()

    def clear(self) -> None:
        for process in self.processes.values():
            if process.poll() is None:
                process.kill()
            process.wait()
        shutil.rmtree(self.folder)


def require(condition: object, what: str) -> None:
    if not condition:
        raise Wrong(what)


def require_line(text: str, words: tuple[str, ...], what: str) -> None:
    found = any(all(word in line for word in words) for line in text.splitlines() if "error: " in line)
    require(found, f"{what}: no line with {words}")


def check_tables(run: Run) -> None:
    """Complete up to the last accepted step, whatever happened then."""
    steps = run.cell.steps
    folder = run.folder / "out"
    if run.cell.code == 0:
        require(json.loads((folder / "summary.json").read_text())["completed"] is True, "summary.json: completed")
    if steps is None:
        require(not (folder / "steps.csv").exists(), "there is a steps.csv")
        return
    found = [len(read_table(folder / f"{name}.csv")) for name in ("steps", "probes")]
    require(found == [steps, steps + 1], f"rows of steps.csv and probes.csv: {found}, expected {[steps, steps + 1]}")
    require(len(read_table(folder / "iterations.csv")) >= steps, "too few rows in iterations.csv")


def check_coupler(run: Run) -> None:
    cell = run.cell
    code = run.processes["coupler"].returncode
    require(code == cell.code, f"exit code of the coupler: {code}, expected {cell.code}")
    if cell.says:
        require_line(run.text("coupler"), cell.says, "the coupler")
        require_line((run.folder / "out" / "coupler.log").read_text(), cell.says, "coupler.log")
    check_tables(run)


def other(who: str) -> str:
    return "structure" if who == "soil" else "soil"


def play_participant(run: Run) -> float:
    """A participant is the culprit."""
    cell = run.cell
    kind = "slow" if cell.kind == "never_answers" else cell.kind
    seconds = table.NEVER if cell.kind == "never_answers" else table.SLOW
    run.start_coupler()
    if (cell.kind, cell.phase) != ("started_twice", "handshake"):
        run.start_participant(other(cell.who), "--pause", PAUSE)
    if cell.kind == "started_twice":
        start_twice(run)
    elif cell.kind == "wrong_version":
        run.start_participant(cell.who, "--version", "2.0")
    else:
        run.start_participant(cell.who, kind, cell.phase, "--seconds", seconds)
    if kind == "stopped":
        run.wait_all(cell.who)
        seconds = time.monotonic() - run.struck_at()
        os.kill(run.processes[cell.who].pid, signal.SIGCONT)
        run.wait_all()
    else:
        seconds = run.wait_all()
    check_coupler(run)
    if cell.code == 0:
        require(all(process.returncode == 0 for name, process in run.processes.items() if name != "second"),
                "a participant of a complete run ended with an error")
    else:
        for name, process in run.processes.items():
            require(process.returncode != 0, f"{name} ended with exit code 0")
        if other(cell.who) in run.processes:
            said = run.text(other(cell.who))
            # Who has not been heard when the coupler ends finds nobody.
            early = cell.phase == "handshake" and "no answer from a coupler" in said
            require_line(said, (f"within {cell.connect:g} s",) if early else ("the coupler ended the run: ",),
                         other(cell.who))
    return seconds


def start_twice(run: Run) -> None:
    """A second process of that name; in mid-run it alone is refused."""
    run.start_participant(run.cell.who, "--pause", PAUSE)
    if run.cell.phase == "handshake":
        run.start_participant(run.cell.who, name="second")
        return
    rows = run.folder / "out" / "steps.csv"
    run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") >= 2, "the first step")
    run.start_participant(run.cell.who, name="second")
    run.wait_until(lambda: run.processes["second"].poll() is not None, "the end of the second")
    require(run.processes["second"].returncode == 4, "the second was not refused")
    require_line(run.text("second"), ("refused", "state of the run"), "the second")


def play_coupler(run: Run) -> float:
    """The coupler is the culprit: it is struck when a participant says that the phase has come."""
    cell = run.cell
    announcer = {"handshake": "", "before_solve": "structure", "inside_solve": "soil", "after_solve": "structure",
                 "output": "soil"}[cell.phase]
    # The structure solves once the soil has solved.
    phase = "inside_solve" if cell.phase == "after_solve" else cell.phase
    present = table.PARTICIPANTS[:1] if cell.phase == "handshake" and cell.kind != "paused" else table.PARTICIPANTS
    run.start_coupler()
    for who in present:
        words = ("announced", phase) if who == announcer else ()
        run.start_participant(who, *words, "--pause", PAUSE)
    if announcer:
        run.wait_until(lambda: "strike" in run.text(announcer), "the phase")
    else:
        run.wait_until(lambda: "connected to the coupler" in run.text(present[0]), "the welcome")
    struck = time.monotonic()
    coupler = run.processes["coupler"].pid
    os.kill(coupler, signal.SIGKILL if cell.kind == "killed" else signal.SIGSTOP)
    if cell.kind == "paused":
        time.sleep(table.SILENCE / 2)
        os.kill(coupler, signal.SIGCONT)
        run.wait_all()
        check_coupler(run)
        require(all(process.returncode == 0 for process in run.processes.values()),
                "a complete run ended with an error")
        return time.monotonic() - struck
    run.wait_all("coupler")
    seconds = time.monotonic() - struck
    for who in present:
        require(run.processes[who].returncode == 4, f"exit code of {who}: {run.processes[who].returncode}")
        require_line(run.text(who), cell.says, who)
    if cell.kind == "stopped":
        os.kill(coupler, signal.SIGCONT)
        run.wait_until(lambda: run.processes["coupler"].poll() is not None, "the end of the coupler")
        require(run.processes["coupler"].returncode == 4, "the coupler that goes on does not notice that it is alone")
    return seconds


def play_port_taken(run: Run) -> float:
    """The coupler, or a participant, where something else listens."""
    who = run.cell.who
    with socket.create_server(("127.0.0.1", int(run.endpoint.rsplit(":", 1)[1]))):
        run.start_coupler() if who == "coupler" else run.start_participant(who)
        seconds = run.wait_all()
    if who == "coupler":
        check_coupler(run)
    else:
        require(run.processes[who].returncode == 4, f"exit code of {who}: {run.processes[who].returncode}")
        require_line(run.text(who), run.cell.says, who)
    return seconds


def play(binaries: Path, cell: Cell) -> tuple[float, str]:
    """Seconds from the misdeed to the end, and what is wrong with the end."""
    run = Run(binaries, cell)
    try:
        player = play_coupler if cell.who == "coupler" else play_participant
        seconds = (play_port_taken if cell.kind == "port_taken" else player)(run)
        return seconds, ""
    except Exception as problem:  # noqa: BLE001 - the other cells go on
        return 0.0, f"{type(problem).__name__}: {problem}\n{run.texts()}"
    finally:
        run.clear()


def print_matrix(results: dict[Cell, tuple[float, str]]) -> None:
    rows = sorted({(cell.kind, cell.who) for cell in results})
    print(f"{'seconds until all has ended':<28}" + "".join(f"{phase:>14}" for phase in table.PHASES))
    for kind, who in rows:
        line = f"{kind + ', ' + who:<28}"
        for phase in table.PHASES:
            found = [result for cell,
                     result in results.items() if (cell.kind, cell.who, cell.phase) == (kind, who, phase)]
            line += f"{'' if not found else 'WRONG' if found[0][1] else format(found[0][0], '.2f'):>14}"
        print(line)


def main() -> int:
    binaries = Path(sys.argv[1]).resolve()
    words = sys.argv[2:]
    chosen = [cell for cell in table.cells() if all(word in (cell.kind, cell.who, cell.phase) for word in words)]
    begin = time.monotonic()
    with ThreadPoolExecutor(WORKERS) as pool:
        results = dict(zip(chosen, pool.map(lambda cell: play(binaries, cell), chosen)))
    wrong = {cell: problem for cell, (_, problem) in results.items() if problem}
    for cell, problem in wrong.items():
        print(f"=== {cell.kind}, {cell.who}, {cell.phase}: {problem}\n")
    print_matrix(results)
    print(f"{len(results)} cells in {time.monotonic() - begin:.0f} s, {len(wrong)} wrong")
    return 1 if wrong or not results else 0


if __name__ == "__main__":
    sys.exit(main())
