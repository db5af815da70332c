# SPDX-License-Identifier: BSD-3-Clause
"""How mpirun of Open MPI 4 and 5 is called: words, environment, several programs in one launch. scripts/run says the
same in its own language."""

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

BY_RANK = Path(__file__).resolve().parent / "by_rank"
WORDS = ["--oversubscribe", "--bind-to", "none"]
FOUR = {"OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_orte_allowed_exit_without_sync": "1"}
FIVE = {"OMPI_MCA_smsc": "^cma", "PRTE_MCA_prte_allowed_exit_without_sync": "1"}


class LauncherError(Exception):
    """There is no mpirun, or it is not that of Open MPI."""


@dataclass(frozen=True)
class Launcher:
    """mpirun of Open MPI. major: first number of its version."""

    major: int

    @property
    def words(self) -> list[str]:
        """mpirun with its options: more processes than cores, which are free to change cores."""
        as_root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
        return ["mpirun", *(["-q"] if self.major < 5 else []), *WORDS, *as_root]

    @property
    def environment(self) -> dict[str, str]:
        """Settings that a launch needs in a container, and on a machine that is so busy that mpirun may be late to note
        the end of a program."""
        return dict(FOUR if self.major < 5 else FIVE)

    def command(self, programs: list[tuple[int, list[str]]]) -> list[str]:
        """One launch of programs, each with its number of ranks and its words."""
        parts = [["-n", str(ranks), *words] for ranks, words in programs]
        if len(parts) == 1:
            return [*self.words, *parts[0]]
        if self.major < 5:
            return [*self.words, *_joined(parts, ":")]
        total = sum(ranks for ranks, _ in programs)
        return [*self.words, "-n", str(total), str(BY_RANK), *_joined(parts, "::")]


def launcher_of(version: str) -> Launcher:
    """The launcher that answers so when it is asked for its version. @raises LauncherError  another one"""
    found = re.search(r"\(Open MPI\) (\d+)\.\d", version)
    if not found:
        first = version.strip().partition("\n")[0]
        raise LauncherError(f"mpirun --version: found {first!r}, allowed: that of Open MPI")
    return Launcher(int(found[1]))


def find_launcher() -> Launcher:
    """@raises LauncherError  there is none in PATH, or another one"""
    try:
        asked = subprocess.run(["mpirun", "--version"], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                               check=False)
    except OSError as error:
        raise LauncherError(f"mpirun: {error.strerror}, allowed: that of Open MPI in PATH") from error
    return launcher_of(asked.stdout)


def _joined(parts: list[list[str]], separator: str) -> list[str]:
    words = list(parts[0])
    for part in parts[1:]:
        words += [separator, *part]
    return words
