# SPDX-License-Identifier: BSD-3-Clause
"""The participant's end of the wire: one coupler (protocol/README.md, sections 1, 7, 8, 9)."""

import secrets
import time
from typing import Any, NoReturn

import zmq

from . import interrupt
from .errors import ProtocolError, printable, text_of
from .handshake import Introduction, ParticipantSettings, Welcome, hello, read_welcome
from .heartbeat import OWN_SLEEP, Heartbeat, is_ipv6
from .keys import HandshakeMonitor, read_keys
from .message import MAX_FRAME_BYTES, Message, decode, encode
from .process import PeerWatch

SLICE = 100  # [ms] of any wait
LAST_WORDS = 0.3  # [s] for what a coupler said before it went
LINGER = 500  # [ms] that closing waits for messages that are not sent yet


def describe(request: Message) -> str:
    """`solve_step 57 iteration 3`: a request in words, for phases and messages."""
    if request.type == "solve_step":
        return f"solve_step {request.integer('step')} iteration {request.integer('iteration')}"
    if request.type == "accept_step":
        return f"accept_step {request.integer('step')}"
    return request.type


class Connection:
    """Talks to one coupler. Any failure is final: every later call raises it again."""

    def __init__(self, settings: ParticipantSettings) -> None:
        self.settings = settings
        self.welcome: Welcome | None = None  # after the handshake
        keys = read_keys(settings.key_file, settings.coupler_key_file)
        self._session = secrets.token_hex(8)
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.DEALER)
        self._socket.setsockopt(zmq.ROUTING_ID, f"{settings.name}#{self._session}".encode())
        self._socket.setsockopt(zmq.LINGER, LINGER)
        self._socket.setsockopt(zmq.IPV6, is_ipv6(settings.endpoint))
        self._socket.setsockopt(zmq.SNDTIMEO, 1000)
        self._socket.setsockopt(zmq.MAXMSGSIZE, MAX_FRAME_BYTES)
        if keys:
            keys.apply(self._socket)
        self._monitor = HandshakeMonitor(self._socket, keys)
        try:
            self._socket.connect(settings.endpoint)
        except zmq.ZMQError as problem:
            self._context.destroy()
            raise ProtocolError(f'cannot connect to the coupler at "{settings.endpoint}": {problem} '
                                "(expected such as tcp://127.0.0.1:5555)") from problem
        self._heartbeat = Heartbeat(self._context, settings.endpoint, settings.name, self._session,
                                    settings.exit_when_coupler_is_lost, keys)
        self._coupler: PeerWatch | None = None
        self._last_sequence = 0
        self._last_look = time.monotonic()
        self._signal_came: float | None = None  # [s] when it was noticed
        self._failure = ""
        self._closed = False

    def __enter__(self) -> "Connection":
        return self

    def __exit__(self, kind: type | None, problem: BaseException | None, _trace: Any) -> None:
        if kind is not None:
            self.abort(text_of(problem))
        elif not self._closed:
            self.abort("the participant ended before the run was finished")
        self.close()

    def run_settings(self) -> dict[str, Any]:
        """Settings of the run as the coupler gave them: end time, dt, folders. Empty before the handshake."""
        return self.welcome.run if self.welcome else {}

    def handshake(self, introduction: Introduction) -> None:
        """Introduce this participant. Raises ProtocolError: refused (both values are named), or no answer in
        time."""
        self._require_usable()
        if self.welcome:
            raise ProtocolError("the handshake is done already")
        # If it cannot be sent, the coupler has closed the connection: the wait for an answer tells why.
        self._send(hello(self.settings, self._session, introduction))
        answer = self._await_answer()
        if answer.type == "refused":
            self._fail(f'the coupler at {self.settings.endpoint} refused participant "{self.settings.name}": '
                       f"{printable(answer.text('reason'))}")
        if answer.type == "abort":
            self._fail(f"the coupler ended the run: {printable(answer.text('reason'))}")
        if answer.type != "welcome":
            self._fail(f'expected "welcome", the coupler sent "{answer.type}"')
        welcome = read_welcome(answer)
        self._coupler = PeerWatch(f"the coupler (pid {welcome.process.pid})", welcome.process)
        self._coupler.sign_of_life("coupling")
        self._heartbeat.watch(self._coupler, welcome.heartbeat, welcome.silence_deadline)
        self.welcome = welcome

    def next_request(self) -> Message:
        """Wait for the coupler's next request. Messages that arrived count before a death: "finish" is returned also
        when the coupler is gone already. Raises ProtocolError: it ended the run, died, froze, or asks nothing."""
        self._require_welcomed()
        self._heartbeat.set_phase("waiting", False)
        begin = time.monotonic()
        while True:
            # Silence is judged before the queue is read: a message that has arrived counts.
            was_silent = bool(self._coupler.silence(self.welcome.silence_deadline))
            request = self._receive_request() or self._look_after_coupler(was_silent)
            if request:
                # After "finish" nothing is computed: the coupler may end.
                self._heartbeat.set_phase(describe(request), request.type != "finish")
                return request
            waited = time.monotonic() - begin
            if waited > self.welcome.idle_deadline:
                self._fail(f"{self._coupler.label} is alive but has asked nothing for {waited:.1f} s (limit "
                           f"{self.welcome.idle_deadline} s, option protocol/idle_deadline in coupler.json); "
                           f"{self._coupler.last_words()}")

    def reply(self, message: Message) -> None:
        """Answer the request that next_request() gave last."""
        self._require_welcomed()
        message.sequence = self._last_sequence
        self._post(message)

    def abort(self, reason: str) -> None:
        """Tell the coupler that this participant cannot go on. Does nothing after another failure."""
        if self._failure or self._closed:
            return
        self._failure = reason
        if self.welcome:
            self._post(Message("abort", self._last_sequence, {"reason": reason}))

    def close(self) -> None:
        """Wait until the last message is sent, and close."""
        if self._closed:
            return
        self._closed = True
        self._heartbeat.close()
        self._monitor.close()
        self._socket.close()
        self._context.term()

    def _require_usable(self) -> None:
        if self._failure:
            raise ProtocolError(f"the coupling has failed before: {self._failure}")
        if self._closed:
            raise ProtocolError("the connection is closed")

    def _require_welcomed(self) -> None:
        self._require_usable()
        if not self.welcome:
            raise ProtocolError("the handshake is not done yet")

    def _fail(self, reason: str) -> NoReturn:
        self._failure = reason
        raise ProtocolError(reason)

    def _post(self, message: Message) -> None:
        if not self._send(message):
            self._fail(
                f'cannot send "{message.type}" to the coupler at {self.settings.endpoint}: its queue is full')

    def _send(self, message: Message) -> bool:
        try:
            self._socket.send_multipart(encode(message))
        except zmq.Again:
            return False
        return True

    def _receive(self, milliseconds: int) -> list[bytes] | None:
        return self._socket.recv_multipart() if self._socket.poll(milliseconds) else None

    def _await_answer(self) -> Message:
        end = time.monotonic() + self.settings.connect_deadline
        while time.monotonic() <= end:
            # A launcher that saw another process fail sends the signal before the coupler can explain.
            interrupted = interrupt.requested()
            frames = self._receive(int(1000 * LAST_WORDS) if interrupted else SLICE)
            message = decode(frames) if frames else None
            if message and message.type != "alive":
                self._monitor.close()
                return message
            if interrupted:
                interrupt.check()
            try:
                self._monitor.check()
            except ProtocolError as refusal:
                self._fail(f'the coupler at {self.settings.endpoint} refused participant "{self.settings.name}": '
                           f"{refusal}")
        self._fail(f'participant "{self.settings.name}": no answer from a coupler at '
                   f"{self.settings.endpoint} within {self.settings.connect_deadline} s (connect_deadline); "
                   f"{self._monitor.hint}")

    def _read(self, frames: list[bytes]) -> Message:
        try:
            message = decode(frames)
            if message.type == "abort":
                self._fail(f"the coupler ended the run: {printable(message.text('reason'))}")
        except ProtocolError as problem:
            if self._failure:
                raise
            raise ProtocolError(
                f"{self._coupler.label} sent a message that is not understood: {problem}") from problem
        self._coupler.sign_of_life()
        if message.type != "alive":
            if message.sequence <= self._last_sequence:
                raise ProtocolError(f'{self._coupler.label} sent "{message.type}" with sequence number '
                                    f"{message.sequence} after {self._last_sequence}")
            self._last_sequence = message.sequence
        return message

    def _receive_request(self) -> Message | None:
        """Wait a slice; signs of life are noted and left out."""
        frames = self._receive(SLICE)
        message = self._read(frames) if frames else None
        return message if message and message.type != "alive" else None

    def _look_after_coupler(self, was_silent: bool) -> Message | None:
        """Check the coupler. Raises when it is lost, or a signal came, unless the run is finished: then returns that
        request."""
        now = time.monotonic()
        if now - self._last_look > OWN_SLEEP:
            self._coupler.forgive()
        self._last_look = now
        interrupted = interrupt.requested() and not self._waits_for_last_checkpoint(now)
        if interrupted or self._coupler.death():
            if finish := self._last_words():
                return finish
        if death := self._coupler.death():
            self._fail(death)
        if interrupted:
            interrupt.check()
        if was_silent and (silence := self._coupler.silence(self.welcome.silence_deadline)):
            self._fail(silence)
        return None

    def _last_words(self) -> Message | None:
        """Read the last message of a coupler that has ended or is about to: its reason (raised), or that the
        run is finished. Other requests are dropped, since nobody awaits their answer."""
        end = time.monotonic() + LAST_WORDS
        while time.monotonic() < end:
            request = self._receive_request()
            if request and request.type == "finish":
                return request
        return None

    def _waits_for_last_checkpoint(self, now: float) -> bool:
        """A launcher sends the signal to all programs; the coupler then ends the run after the current step, with a
        checkpoint."""
        if self._signal_came is None:
            self._signal_came = now
        keeps = bool(self.run_settings().get("checkpoints", False))
        return keeps and now - self._signal_came < interrupt.patience()
