# SPDX-License-Identifier: BSD-3-Clause
"""A temporary folder that goes away with this process, whatever ends it."""

import contextlib
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

# Reads to the end of its input, which comes when this process is gone. A ccx that is being killed may still write.
GUARD = 'read _; for n in 1 2 3 4 5 6 7 8 9; do rm -rf -- "$1" && exit 0; sleep 0.2; done; exit 1'


@contextlib.contextmanager
def scratch_folder(prefix: str) -> Iterator[Path]:
    """A process of its own session watches over the folder and removes it."""
    folder = tempfile.mkdtemp(prefix=prefix)
    with subprocess.Popen(["/bin/sh", "-c", GUARD, "sh", folder], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, cwd="/", start_new_session=True) as guard:
        try:
            yield Path(folder)
        finally:
            guard.stdin.close()  # and wait
