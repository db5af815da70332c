# SPDX-License-Identifier: BSD-3-Clause
"""Locks on results folders, as the programs take them (common/run/folder_lock.hpp).

All that write in a folder share the file .gabion_lock there, which a run that moves the folder away must have alone.
"""

import contextlib
import fcntl
import json
import os
import sys
import time
from collections.abc import Iterator
from enum import Enum
from pathlib import Path

from plotting.results import ResultsError

MARKER = ".gabion_results"
LOCK = ".gabion_lock"  # of the run; a script adds its name
MOST_TRIES = 100  # while others move the folder away

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "protocol" / "python"))
from gabion_participant import process  # noqa: E402


class Owner(Enum):
    """Content of the lock file of a run."""

    NONE = "there is no lock file"
    ENDED = "the run has ended"
    ALIVE = "its process is alive"
    GONE = "its process is gone"
    UNKNOWN = "it runs on another machine"


def _read(path: Path) -> dict | None:
    with contextlib.suppress(OSError, ValueError):
        text = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(text, dict) and {"program", "host", "pid", "start_time", "since"} <= text.keys():
            return text
    return None


def _judge(signed: dict) -> Owner:
    identity = process.ProcessIdentity(signed["host"], signed["pid"], signed["start_time"])
    if process.is_gone(identity):
        return Owner.GONE
    return Owner.ALIVE if identity.host and identity.host == process.this_host() else Owner.UNKNOWN


def owner_of(folder: Path) -> Owner:
    """State of the run that owns this folder."""
    path = folder / LOCK
    if not path.exists():
        return Owner.NONE
    signed = _read(path)
    return Owner.ENDED if signed is None else _judge(signed)


def _words(path: Path) -> str:
    signed = _read(path)
    if signed is None:
        return f"another program ({path})"
    return (f"{signed['program']} (pid {signed['pid']} on {signed['host'].split('/')[0]}, since {signed['since']}; "
            f"{path})")


def _open_locked(path: Path, operation: int) -> int:
    """Descriptor of the file, locked at once. Raises ResultsError: somebody else has it."""
    for _ in range(MOST_TRIES):
        try:
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
        except OSError as problem:
            raise ResultsError(f"{path}: cannot be written: {problem.strerror}") from problem
        try:
            fcntl.flock(file, operation | fcntl.LOCK_NB)
        except BlockingIOError as problem:
            os.close(file)
            raise ResultsError(f"{path.parent}: in use by {_words(path)}; wait until it ends") from problem
        except OSError:
            return file  # a file system without such locks
        with contextlib.suppress(OSError):
            if os.path.samestat(os.fstat(file), os.stat(path)):
                return file
        os.close(file)  # the folder was moved, or the file removed, in between
    raise ResultsError(f"{path.parent}: is moved away again and again")


@contextlib.contextmanager
def writing(folder: Path, script: str, shared: bool = False) -> Iterator[None]:
    """Hold a lock: while it lasts no run moves the folder away, and no second script of this name writes there, but for
    others of its kind where all are `shared`. A run in progress continues: it writes other files. Raises ResultsError:
    a run is just beginning there, or the same script is at work."""
    if not folder.is_dir():
        raise ResultsError(f"{folder}: no such results folder")
    with contextlib.ExitStack() as stack:
        stack.callback(os.close, _open_locked(folder / LOCK, fcntl.LOCK_SH))
        own = folder / f"{LOCK}_{script}"
        file = _open_locked(own, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
        stack.callback(os.close, file)
        if shared:
            yield
            return
        stack.callback(own.unlink, missing_ok=True)
        since = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime())
        signed = {"program": f"scripts/{script}", **process.this_process().to_fields(), "since": since}
        os.ftruncate(file, 0)
        os.write(file, (json.dumps(signed) + "\n").encode())
        yield


def writing_below(folder: Path, out: Path, script: str) -> contextlib.AbstractContextManager[None]:
    """writing() where `out` is in the results folder of a run, which has a marker; elsewhere nothing is locked."""
    if (folder / MARKER).exists() and out.resolve().is_relative_to(folder.resolve()):
        return writing(folder, script)
    return contextlib.nullcontext()
