# SPDX-License-Identifier: BSD-3-Clause
"""Who lives: processes of this machine, and how long a peer has been silent (protocol/README.md, section
8)."""

import os
import socket
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from .errors import printable


@dataclass(frozen=True)
class ProcessIdentity:
    """A process id alone may be given away again; with the start time it is unique as long as the machine
    runs."""

    host: str = ""  # host name/boot id/pid namespace; "" = unknown
    pid: int = 0
    start_time: int = 0  # clock ticks after boot

    def to_fields(self) -> dict[str, str | int]:
        return asdict(self)


def read_stat(pid: int) -> tuple[str, int] | None:
    """State and start time: fields 3 and 22 of /proc/PID/stat. None: no such process."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    rest = text[text.rindex(")") + 1:].split()  # field 2, the name, may hold anything
    return rest[0], int(rest[19])


def this_host() -> str:
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return "/".join((socket.gethostname(), boot, os.readlink("/proc/self/ns/pid")))
    except OSError:
        return ""


def this_process() -> ProcessIdentity:
    stat = read_stat(os.getpid())
    return ProcessIdentity(this_host(), os.getpid(), stat[1]) if stat else ProcessIdentity(pid=os.getpid())


def is_gone(process: ProcessIdentity) -> bool:
    """Whether it is a process of this machine that has ended."""
    if process.pid <= 0 or not process.host or process.host != this_host():
        return False
    stat = read_stat(process.pid)
    return stat is None or stat[1] != process.start_time or stat[0] in "ZX"


class PeerWatch:
    """Signs of life of the coupler. Safe to use from several threads."""

    def __init__(self, label: str, process: ProcessIdentity) -> None:
        self.label = label
        self._process = process
        self._lock = threading.Lock()
        self._last_sign = self._silent_from = time.monotonic()
        self._phase = "handshake"

    def sign_of_life(self, phase: str | None = None) -> None:
        with self._lock:
            self._last_sign = self._silent_from = time.monotonic()
            if phase is not None:
                self._phase = printable(phase)

    def forgive(self) -> None:
        """Count the peer's silence from now on, because this process itself slept."""
        with self._lock:
            self._silent_from = time.monotonic()

    def last_words(self) -> str:
        with self._lock:
            seconds = time.monotonic() - self._last_sign
            return f'last sign of life {seconds:.1f} s ago in phase "{self._phase}"'

    def death(self) -> str | None:
        """A sentence when the peer's process on this machine has ended."""
        return f"{self.label} has died: no process; {self.last_words()}" if is_gone(self._process) else None

    def silence(self, deadline: float) -> str | None:
        """A sentence when nothing came for `deadline` seconds."""
        with self._lock:
            silent = time.monotonic() - self._silent_from
        if silent <= deadline:
            return None
        return (f"{self.label} is silent for {silent:.1f} s (limit {deadline} s, option "
                f"protocol/silence_deadline in coupler.json); {self.last_words()}")
