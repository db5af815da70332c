# SPDX-License-Identifier: BSD-3-Clause
"""Paths of the programs, scripts and descriptions of keys, and the scripts' readers of results."""

import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
NOTE = HERE / "checkout.txt"  # written by pip install: the folder that the package comes from


def find_root() -> Path:
    """Folder with scripts/run: $GABION_ROOT, else the one that holds this package or that it was installed from.

    @raises ImportError  it has no scripts/run
    """
    given = os.environ.get("GABION_ROOT")
    if given:
        root, source = Path(given), "GABION_ROOT"
    elif NOTE.exists():
        root, source = Path(NOTE.read_text(encoding="utf-8").strip()), str(NOTE)
    else:
        root, source = HERE.parent, str(HERE)
    if not (root / "scripts" / "run").is_file():
        raise ImportError(f"gabion: {source} leads to {root}, which has no scripts/run; set GABION_ROOT to the folder "
                          "of Gabion that has it")
    return root.resolve()


ROOT = find_root()
SCRIPTS = str(ROOT / "scripts")
if SCRIPTS not in sys.path:
    sys.path.append(SCRIPTS)  # behind all else: modules of the user with these names stay the user's

import plotting.results  # noqa: E402

if not Path(plotting.results.__file__).resolve().is_relative_to(ROOT):
    raise ImportError(f"gabion: found a module plotting at {plotting.results.__file__} that hides the one of "
                      f"{SCRIPTS}; rename it, or put {SCRIPTS} first in sys.path")
