# SPDX-License-Identifier: BSD-3-Clause
"""Signs of life while the solver computes (protocol/README.md, section 8)."""

import os
import sys
import threading
import time

import zmq

from .errors import ProtocolError
from .keys import Keys
from .message import Message, decode, encode
from .process import PeerWatch

SLICE = 0.1  # [s] between two looks
OWN_SLEEP = 1.0  # [s] for a slice: this process did not run
GRACE = 1.0  # [s] for a computation to end by itself
OUTPUT_GRACE = 30.0  # [s] for files to be completed
EXIT_CODE = 4  # of a process that ends because the coupler is lost


def is_ipv6(endpoint: str) -> bool:
    """Whether it is an address of IPv6, such as tcp://[::1]:5555; such addresses stand in brackets."""
    return "[" in endpoint


class Heartbeat:
    """A thread with a socket of its own: tells the coupler what the participant does, and listens to its
    signs of life.

    It needs the interpreter now and then: a solver that holds Python's global lock for longer than the
    coupler's silence deadline is taken for dead.
    """

    def __init__(self, context: zmq.Context, endpoint: str, participant: str, session: str,
                 ends_process: bool, keys: Keys | None = None) -> None:
        self._socket = context.socket(zmq.DEALER)
        self._socket.setsockopt(zmq.ROUTING_ID, f"{participant}#{session}#alive".encode())
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.IPV6, is_ipv6(endpoint))
        if keys:
            keys.apply(self._socket)
        self._socket.connect(endpoint)
        self._identity = {"participant": participant, "session": session}
        self._ends_process = ends_process
        self._lock = threading.Lock()  # guards the following members
        self._phase, self._busy, self._phase_begin = "handshake", False, time.monotonic()
        self._coupler: PeerWatch | None = None
        self._interval, self._silence_deadline = 0.5, 10.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="heartbeat", daemon=True)
        self._thread.start()

    def set_phase(self, phase: str, busy: bool) -> None:
        """busy: the solver computes, so no other thread checks whether the coupler lives."""
        with self._lock:
            self._phase, self._busy, self._phase_begin = phase, busy, time.monotonic()

    def watch(self, coupler: PeerWatch, interval: float, silence_deadline: float) -> None:
        """Watch this coupler, after the handshake; `interval` [s] between two signs of life, to and from it."""
        with self._lock:
            self._coupler, self._interval, self._silence_deadline = coupler, interval, silence_deadline

    def close(self) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        count, last_beat, last_look, lost_since = 0, -1e9, time.monotonic(), None
        while not self._stop.wait(min(SLICE, self._interval) if count else 0):
            now = time.monotonic()
            if now - last_beat >= self._interval:
                count, last_beat = count + 1, now
                self._send(count)
            self._receive()
            lost_since = self._check_coupler(now - last_look, lost_since)
            last_look = now
        self._socket.close()

    def _send(self, count: int) -> None:
        with self._lock:
            said = {"phase": self._phase, "seconds": time.monotonic() - self._phase_begin}
        try:
            self._socket.send_multipart(encode(Message("alive", count, self._identity | said)), zmq.NOBLOCK)
        except zmq.Again:
            pass  # the coupler notices the silence; the main socket says what is wrong

    def _receive(self) -> None:
        while self._socket.poll(0):
            try:
                message = decode(self._socket.recv_multipart(zmq.NOBLOCK))
                if message.type == "alive" and self._coupler:
                    self._coupler.sign_of_life(message.text("phase"))
            except ProtocolError:
                pass  # not understood, so no sign of life

    def _check_coupler(self, slept: float, lost_since: float | None) -> float | None:
        """End the process when the coupler is lost while the solver computes: no orphan shall compute for
        hours."""
        with self._lock:
            coupler, phase, busy = self._coupler, self._phase, self._busy
        if coupler is None or not self._ends_process:
            return None
        if slept > OWN_SLEEP:
            coupler.forgive()
        loss = coupler.death() or coupler.silence(self._silence_deadline)
        if not loss or not busy:
            return None
        lost_since = lost_since or time.monotonic()
        writes = phase.startswith(("write_output", "accept_step"))
        if time.monotonic() - lost_since < (OUTPUT_GRACE if writes else GRACE):
            return lost_since
        print(f'[{self._identity["participant"]}] error: {loss}; this process ends in phase "{phase}"',
              file=sys.stderr, flush=True)
        os._exit(EXIT_CODE)
