# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a scene that is made from a plan."""

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from .raster import TerrainError


@contextlib.contextmanager
def scene_folder(folder: Path, replace: bool, names: tuple[str, ...]) -> Iterator[None]:
    """Make the folder, which no other process writes a scene into meanwhile; nothing is left of one that was refused.

    names: of files that show that a scene is there, which only `replace` writes over. @raises TerrainError
    """
    is_new = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    handle = os.open(folder, os.O_RDONLY)
    try:
        lock(handle, folder)
        for name in names:
            if (folder / name).exists() and not replace:
                raise TerrainError(f"{folder}: has a scene already, with {name}, allowed: another folder, or --replace")
        yield
    except TerrainError:
        if is_new:
            with contextlib.suppress(OSError):  # not empty: somebody else has written there
                folder.rmdir()
        raise
    finally:
        os.close(handle)


def lock(handle: int, folder: Path) -> None:
    """@raises TerrainError  another process has it"""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise TerrainError(f"{folder}: another process writes a scene there now, allowed: another folder") from error
    except OSError:
        pass  # a file system without locks
