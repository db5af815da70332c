# SPDX-License-Identifier: BSD-3-Clause
"""A process beside rank 0 that ends it when another rank has died.

Rank 0 itself may be inside a collective call then, which waits for the dead one and holds Python's lock; mpirun takes
2 s. The coupler notices the end of rank 0 at once.
"""

import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence

from .process import ProcessIdentity, is_gone

INTERVAL = 0.1  # [s]
PROGRAM = "from gabion_participant.rank_watch import main; main()"  # of NAME, PID, IDENTITIES


class RankWatch:
    """others: of the ranks 1, 2, ..."""

    def __init__(self, name: str, others: Sequence[ProcessIdentity]) -> None:
        described = json.dumps([process.to_fields() for process in others])
        environment = {key: value for key, value in os.environ.items()
                       if not key.startswith(("OMPI_", "PMIX_", "PMI_"))}
        self._process = subprocess.Popen(  # no rank itself
            [sys.executable, "-c", PROGRAM, name, str(os.getpid()), described],
            stdin=subprocess.PIPE, start_new_session=True,
            env=environment | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)})

    def __enter__(self) -> "RankWatch":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.stdin.close()
        self._process.wait()


def watch(name: str, leader: int, others: Sequence[ProcessIdentity]) -> None:
    """Watch until standard input is closed, or a rank has died."""
    while not select.select([sys.stdin], [], [], INTERVAL)[0]:
        for rank, process in enumerate(others, 1):
            if is_gone(process):
                print(f"[{name}] error: rank {rank} (pid {process.pid}) has died: no process", file=sys.stderr,
                      flush=True)
                os.kill(leader, signal.SIGKILL)
                return


def main() -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # rank 0 may have to save its state first
    watch(sys.argv[1], int(sys.argv[2]), [ProcessIdentity(**fields) for fields in json.loads(sys.argv[3])])
