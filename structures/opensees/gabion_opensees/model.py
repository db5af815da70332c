# SPDX-License-Identifier: BSD-3-Clause
"""The connection's end of model_process.py: trial, accept, reject, replay.

The connection to the coupler lives in this process, which never runs OpenSees and never forks: the first process of the
model is its child by spawn; those that take over come back to it, as their subreaper, when their parent has ended.
"""

import ctypes
import os
import signal
import socket
import subprocess
from multiprocessing.connection import Connection
from pathlib import Path

from .errors import OpenSeesError, SettingsError
from .settings import Settings

PR_SET_CHILD_SUBREAPER = 36
INSTALL = "-m pip install openseespy"


class Model:
    """A running model. Raises SettingsError where it does not come up, else OpenSeesError."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
        self.has_trial = False
        self.ends: list[int] = []  # wait statuses of processes that ended
        self.start()

    def start(self) -> None:
        """A fresh one, in the state that the model file leaves behind."""
        own, other = socket.socketpair()
        program = Path(__file__).with_name("model_process.py")
        command = [self.settings.python, str(program), str(other.fileno()), str(os.getpid()),
                   str(self.settings.model.resolve())]
        try:
            started = subprocess.Popen(command, pass_fds=[other.fileno()], stdin=subprocess.DEVNULL)
            started.returncode = 0  # it is awaited by reap(), as those that take over
        except OSError as problem:
            raise SettingsError(f'at /python: found "{self.settings.python}": {problem}') from problem
        other.close()
        self.socket = Connection(own.detach())
        self.has_trial = False
        answer = self.ask(self.settings.analysis())
        if "missing" in answer:
            raise SettingsError(f"openseespy: found none: {answer['missing']}; allowed: install it with "
                                f'{self.settings.python} {INSTALL}, or name another python in "python"')
        self.variables = answer["variables"]

    def close(self) -> None:
        """The processes end by themselves when nobody speaks to them, those of a trial too."""
        self.socket.close()

    def restart(self) -> None:
        self.close()
        self.start()

    def ask(self, order: dict) -> dict:
        try:
            self.socket.send(order)
            answer = self.socket.recv()
        except (EOFError, OSError) as problem:
            raise self.lost() from problem
        if "error" in answer:
            raise OpenSeesError(f"{self.settings.model.name}: {answer['error']}")
        return answer

    def trial(self, dt: float, loads: list, jumps: list) -> dict:
        """u, v, iterations; or failed. It awaits its verdict."""
        self.reject()
        answer = self.ask({"order": "trial", "dt": dt, "loads": loads, "jumps": jumps})
        self.has_trial = True
        return answer

    def mass(self) -> dict:
        self.reject()
        answer = self.ask({"order": "mass"})
        self.has_trial = True
        self.reject()
        return answer

    def reject(self) -> None:
        if self.has_trial:
            self.has_trial = False
            try:
                self.socket.send({"order": "reject"})
            except OSError as problem:
                raise self.lost() from problem

    def accept(self) -> list[list[float]]:
        """The probes."""
        self.has_trial = False
        answer = self.ask({"order": "accept"})
        self.reap()
        return answer["probes"]

    def ask_accepted(self, order: str, **values: object) -> dict:
        self.reject()
        return self.ask({"order": order} | values)

    def reap(self) -> None:
        """Predecessors of the accepted state, which have ended."""
        try:
            while True:
                pid, status = os.waitpid(-1, os.WNOHANG)
                if not pid:
                    return
                self.ends.append(status)
                del self.ends[:-8]
        except ChildProcessError:
            return

    def lost(self) -> OpenSeesError:
        """Error of a model that has ended, with its last words if there are some."""
        try:
            while "error" not in (answer := self.socket.recv()):
                pass
            return OpenSeesError(f"{self.settings.model.name}: {answer['error']}")
        except (EOFError, OSError):
            pass
        return OpenSeesError(f"{self.settings.model.name}: the process of the model {self.how_it_ended()}")

    def how_it_ended(self) -> str:
        try:
            _, status = os.waitpid(-1, 0)
            self.ends.append(status)
            self.reap()
        except ChildProcessError:
            pass
        for status in self.ends:
            code = os.waitstatus_to_exitcode(status)
            if code:
                return f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        return "ended"
