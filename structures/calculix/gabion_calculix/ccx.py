# SPDX-License-Identifier: BSD-3-Clause
"""The program ccx: run to its end, within a deadline, and never left behind."""

import os
import shutil
import signal
import subprocess
from pathlib import Path

from .settings import Settings

LAST_LINES = 8
# Message of ccx when Newton's iteration finds no solution; a smaller step may have one.
NO_SOLUTION = ("solution seems to diverge", "too many iterations", "too many cutbacks",
               "increment size smaller than minimum", "max. # of increments reached", "nonpositive jacobian")


class CcxError(Exception):
    """ccx is missing, was killed, took too long or refused its input."""


class NoSolution(Exception):
    """ccx ran, and found no solution."""


class Ccx:
    def __init__(self, settings: Settings, folder: Path) -> None:
        found = shutil.which(settings.program)
        if found is None:
            raise CcxError(f'found no program "{settings.program}" in PATH, allowed: ccx of CalculiX 2.20 (package '
                           "calculix-ccx)")
        # ccx dies with this process, whatever ends it.
        self.command = ["setpriv", "--pdeathsig", "KILL", found, "-i"]
        self.folder, self.deadline = folder, settings.deadline
        threads, solver = str(settings.threads), str(settings.solver_threads)
        most = str(max(settings.threads, settings.solver_threads))
        self.environment = os.environ | {"OMP_NUM_THREADS": most, "OMP_THREAD_LIMIT": most, "OPENBLAS_NUM_THREADS": "1",
                                         "CCX_NPROC_STIFFNESS": threads, "CCX_NPROC_RESULTS": threads,
                                         "CCX_NPROC_EQUATION_SOLVER": solver}
        self.runs = 0

    def run(self, job: str, text: str) -> int:
        """Solve `job`.inp with this text; returns the iterations of Newton. Raises CcxError, NoSolution."""
        (self.folder / f"{job}.inp").write_text(text, encoding="utf-8")
        for suffix in (".rout", ".frd", ".sta"):
            (self.folder / (job + suffix)).unlink(missing_ok=True)
        self.runs += 1
        said, code = self._wait(job)
        if code == 0 and "Job finished" in said and (self.folder / f"{job}.rout").exists():
            return iterations_of(self.folder / f"{job}.sta")
        for reason in NO_SOLUTION:
            if code > 0 and reason in said:
                raise NoSolution(f"ccx: {reason}")
        how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        raise CcxError(f"ccx {how} on {job}.inp; its last lines:\n{last_lines(said)}")

    def _wait(self, job: str) -> tuple[str, int]:
        with subprocess.Popen([*self.command, job], cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                              start_new_session=True) as process:
            try:
                said, _ = process.communicate(timeout=self.deadline)
            except BaseException as problem:
                process.kill()
                said, _ = process.communicate()
                if isinstance(problem, subprocess.TimeoutExpired):
                    raise CcxError(f"ccx did not end within {self.deadline:g} s (deadline of structure.json); its last "
                                   f"lines:\n{last_lines(said)}") from problem
                raise
            return said, process.returncode


def last_lines(text: str) -> str:
    return "\n".join([f"    {line.strip()}" for line in text.splitlines() if line.strip()][-LAST_LINES:])


def iterations_of(path: Path) -> int:
    """Sum over the increments in the table: step, increment, attempt, iterations, ..."""
    rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines()[2:]]
    return sum(int(row[3]) for row in rows if len(row) > 3 and row[3].isdigit())
