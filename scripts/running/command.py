# SPDX-License-Identifier: BSD-3-Clause
"""The command of a participant: run it, pass on what it prints, tell the coupler when it fails.

    command.py NAME ENDPOINT PROGRAM [WORD]...     for scripts/run; exit code: that of the command

A command that ends before its program has met the coupler would keep the run waiting; the coupler gets exit code and
last lines in its place. A coupler that knows the participant already sees the end by itself.
"""

import os
import selectors
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

LAST_LINES = 8
LAST_BYTES = 8192
LAST_WAIT = 1.0  # [s] for what the command's own children still print after its end
PATIENCE = 30  # [s] until the coupler listens
LINGER = 500  # [ms] until it has the message then
NOT_FOUND = 127


class Relay:
    """Passes on output as it comes and keeps the end of it."""

    def __init__(self, process: subprocess.Popen) -> None:
        self._selector = selectors.DefaultSelector()
        self._tail = b""
        for stream, target in ((process.stdout, 1), (process.stderr, 2)):
            if stream is not None:
                self._selector.register(stream.fileno(), selectors.EVENT_READ, target)

    @property
    def is_open(self) -> bool:
        return bool(self._selector.get_map())

    def turn(self, seconds: float) -> None:
        """Pass on what comes within this time."""
        for key, _ in self._selector.select(seconds):
            text = os.read(key.fd, 65536)
            if not text:
                self._selector.unregister(key.fd)
                continue
            self._tail = (self._tail + text)[-LAST_BYTES:]
            write_all(key.data, text)

    def last_lines(self) -> list[str]:
        lines = [line.strip() for line in self._tail.decode(errors="replace").splitlines()]
        return [line for line in lines if line][-LAST_LINES:]


def write_all(target: int, text: bytes) -> None:
    """Let the command continue when nobody reads its output any more."""
    try:
        while text:
            text = text[os.write(target, text):]
    except OSError:
        pass


def tell_coupler(message: tuple[str, str, str, str], runner: int) -> None:
    """Wait until it listens, as long as `runner`, the process id of scripts/run, is there. Nobody hears it where the
    coupler knows the participant.

    message: name, endpoint, program, reason
    """
    name, endpoint, program, reason = message
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "protocol/python"))
    import zmq  # noqa: PLC0415 - not needed by commands that end well
    from gabion_participant.keys import read_keys  # noqa: PLC0415
    from gabion_participant.message import Message, encode  # noqa: PLC0415
    with zmq.Context() as context:
        socket = context.socket(zmq.DEALER)
        socket.setsockopt(zmq.LINGER, LINGER)
        socket.setsockopt(zmq.ROUTING_ID, f"{name}#command#{os.getpid()}".encode())
        if keys := read_keys("", ""):
            keys.apply(socket)
        monitor = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_SUCCEEDED)
        socket.connect(endpoint)
        socket.send_multipart(encode(Message("abort", 0, {"reason": reason, "participant": name, "program": program})))
        end = time.monotonic() + PATIENCE
        while not monitor.poll(50) and time.monotonic() < end and os.path.exists(f"/proc/{runner}"):
            pass
        socket.disable_monitor()
        socket.close()


def tell_coupler_aside(*message: str) -> None:
    """Tell the coupler from a separate process, so that this one ends at once."""
    runner = os.getppid()
    if os.fork():
        return
    nothing = os.open(os.devnull, os.O_RDWR)
    for number in range(3):  # who reads the output waits for its end
        os.dup2(nothing, number)
    try:
        tell_coupler(message, runner)
    finally:
        os._exit(0)


class Command:
    """Make the command end with the signal that ends this process, and be killed where this process is."""

    def __init__(self, words: list[str]) -> None:
        self.stopped_by = 0
        self._process: subprocess.Popen | None = None
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._pass_on)
        # A terminal keeps its line by line output.
        stdout = None if os.isatty(1) else subprocess.PIPE
        self._process = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", *words], stdout=stdout,
                                         stderr=subprocess.PIPE)
        self.relay = Relay(self._process)
        if self.stopped_by:  # before there was a process
            self._pass_on(self.stopped_by, None)

    def _pass_on(self, number: int, _frame: object) -> None:
        self.stopped_by = number
        if self._process is not None and self._process.returncode is None:
            self._process.send_signal(number)
            self._process.send_signal(signal.SIGCONT)

    def wait(self) -> int:
        """Exit code, 128 + signal."""
        while self._process.poll() is None:
            if self.relay.is_open:
                self.relay.turn(0.5)  # its end closes the pipe
            else:
                time.sleep(0.05)
        end = time.monotonic() + LAST_WAIT
        while self.relay.is_open and time.monotonic() < end:
            self.relay.turn(end - time.monotonic())
        code = self._process.returncode
        return code if code >= 0 else 128 - code


def main() -> int:
    name, endpoint, *words = sys.argv[1:]
    if shutil.which(words[0]) is None:
        code, said, stopped = NOT_FOUND, [f"{words[0]}: no such program, or it may not be executed"], 0
        print(f"{name}: {said[0]}", file=sys.stderr, flush=True)
    else:
        command = Command(words)
        code, said, stopped = command.wait(), command.relay.last_lines(), command.stopped_by
    if code == 0:
        return 0
    print(f"{name} ended with exit code {code}", file=sys.stderr, flush=True)
    if not stopped:
        last = f"; its last lines: {' | '.join(said)}" if said else ""
        tell_coupler_aside(name, endpoint, words[0], f"its command ended with exit code {code}{last}")
    return code


if __name__ == "__main__":
    sys.exit(main())
