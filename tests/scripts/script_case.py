# SPDX-License-Identifier: BSD-3-Clause
"""Parts that the tests of scripts share."""

import contextlib
import importlib.machinery
import importlib.util
import io
import resource
import subprocess
import sys
import tempfile
import unittest
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests" / "scripts")]


class ScriptCase(unittest.TestCase):
    """Has a folder of its own, `self.folder`, and runs scripts."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def script(self, name: str, *arguments: object) -> subprocess.CompletedProcess:
        """Run a script as a program."""
        command = [str(ROOT / "scripts" / name), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)

    def python_script(self, name: str, *arguments: object) -> subprocess.CompletedProcess:
        """Run a script that is written in Python inside this process: no second start of matplotlib."""
        loader = importlib.machinery.SourceFileLoader(f"script_{name}", str(ROOT / "scripts" / name))
        module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
        loader.exec_module(module)
        argv = [name, *map(str, arguments)]
        out, errors = io.StringIO(), io.StringIO()
        with (contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors),
              mock.patch.object(sys, "argv", argv)):
            code = module.main()
        return subprocess.CompletedProcess(argv, code, out.getvalue(), errors.getvalue())

    @contextlib.contextmanager
    def full_disk(self, room: int) -> Iterator[None]:
        """Files of this process may have so many bytes: writing more fails as on a full disk."""
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)

    def write(self, path: str, text: str) -> Path:
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file
