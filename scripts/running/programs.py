# SPDX-License-Identifier: BSD-3-Clause
"""Where the programs are."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# An installed tree has no sources and its programs in bin/.
PROGRAMS = ROOT / "build" / "release" / "bin" if (ROOT / "CMakeLists.txt").exists() else ROOT / "bin"
