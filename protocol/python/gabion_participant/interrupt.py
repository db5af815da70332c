# SPDX-License-Identifier: BSD-3-Clause
"""SIGINT and SIGTERM, which a launcher sends to all programs of a run (protocol/README.md, section 9)."""

import os
import signal

from .errors import ParticipantError

LAST_WORDS = 0.2  # [s] that a program needs to end
_came = 0


class Interrupted(ParticipantError):
    """A signal came, and nothing that happened to the coupler explains it."""

    def __init__(self, number: int) -> None:
        super().__init__(f"interrupted by signal {number} ({signal.strsignal(number)})")
        self.signal = number


def install() -> None:
    """Catch signals in the main thread of a program: the first one is noted and ends the next wait for the coupler; a
    second one ends the process at once. Where checkpoints are kept the participant serves on for patience()
    seconds, so that the coupler can finish the step and ask for its state."""

    def note(number: int, _frame: object) -> None:
        global _came
        _came = _came or number  # a launcher sends SIGTERM after whatever made it end
        signal.signal(number, signal.SIG_DFL)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, note)


def requested() -> int:
    """The signal that came; 0: none."""
    return _came


def check() -> None:
    """Raise Interrupted when a signal came."""
    if _came:
        raise Interrupted(_came)


def patience() -> float:
    """[s] until mpirun kills what does not end after its signal, less what ending takes."""
    return float(os.environ.get("OMPI_MCA_odls_base_sigkill_timeout", "1")) - LAST_WORDS
