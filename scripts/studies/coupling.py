# SPDX-License-Identifier: BSD-3-Clause
"""Tables of coupling methods, made by the program coupling_benchmark."""

import csv
import os
import subprocess

from plotting.results import ResultsError
from studies.runner import ROOT, Runner

SETUP = ROOT / "scripts" / "setup"
BINARY = ROOT / "build" / "release" / "bin" / "coupling_benchmark"
METHODS = ("constant", "mvqn", "iqn_ils")
NODES = (100, 1000, 10000)
HEAD = ["method", "nodes", "all [us]", "messages [us]", "acceleration [us]", "rest [us]", "memory [MB]"]
# preCICE 3.4.1, serial implicit, another 2-core machine: without columns, and IQN-ILS with 100 of them [us].
PEER = {100: (195, 520), 1000: (296, 2900), 10000: (2269, 29000)}


def coupling(runner: Runner) -> None:
    """Iterations of the methods on two known problems, and what an iteration costs."""
    if subprocess.run([SETUP, BINARY.name], check=False).returncode != 0:
        raise ResultsError(f"{BINARY.name} could not be built, see above")
    steps = os.environ.get("GABION_BENCH_GRID_STEPS", "0")  # 0: one second of the tube
    _table(runner, "affine", ["affine"])
    _table(runner, "tube", ["tube"])
    grid = _table(runner, "grid", ["grid", steps])
    failed = [row for row in grid if row[-2] == "failed"]
    runner.remark(f"{len(failed)} of {len(grid)} settings of MVQN failed")
    rows = [[*_run(["overhead", method, str(nodes)])[0], PEER[nodes][method != "constant"]]
            for nodes in NODES for method in METHODS]
    runner.report([*HEAD, "preCICE [us]"], rows, "overhead")


def _run(words: list[str]) -> list[list[str]]:
    done = subprocess.run([str(BINARY), *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ResultsError(f"coupling_benchmark {' '.join(words)}: exit code {done.returncode}: {done.stderr.strip()}")
    return list(csv.reader(done.stdout.splitlines()))


def _table(runner: Runner, name: str, words: list[str]) -> list[list[str]]:
    head, *rows = _run(words)
    runner.report(head, rows, name)
    return rows


STUDIES = {coupling.__name__: coupling}
