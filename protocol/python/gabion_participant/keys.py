# SPDX-License-Identifier: BSD-3-Clause
"""Keys of CURVE, and why a coupler does not let a participant in (protocol/README.md, section 13)."""

import os
import stat
from dataclasses import dataclass
from pathlib import Path

import zmq
from zmq.utils import z85
from zmq.utils.monitor import recv_monitor_message

from .errors import ProtocolError, UsageError

LENGTH = 40  # characters of a key in Z85
SECRET, PUBLIC = "gabion-secret-key ", "gabion-public-key "
MECHANISM_MISMATCH = 0x11000002  # ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH


@dataclass
class Keys:
    """Keys with which a participant recognises its coupler and is recognised."""

    secret: bytes
    own_public: bytes
    coupler_public: bytes

    def apply(self, socket: zmq.Socket) -> None:
        socket.curve_serverkey = self.coupler_public
        socket.curve_publickey = self.own_public
        socket.curve_secretkey = self.secret


def read_key(file: str, tag: str) -> bytes:
    """The one key of a file. Raises UsageError; the wrong text is not quoted, because it may be a secret."""
    try:
        lines = Path(file).read_text(encoding="ascii").splitlines()
    except (OSError, ValueError) as problem:
        raise UsageError(f"{file}: cannot be read: {type(problem).__name__}") from None
    found = [line.strip() for line in lines if line.strip() and not line.startswith(";")]
    if len(found) != 1 or not found[0].startswith(tag) or len(found[0]) != len(tag) + LENGTH:
        raise UsageError(f'{file}: holds not just one line "{tag}KEY" with {LENGTH} characters of Z85')
    key = found[0][len(tag):].encode()
    try:
        z85.decode(key)
    except Exception:  # noqa: BLE001 - what it raises differs between versions of pyzmq
        raise UsageError(f'{file}: the key is not Z85') from None
    return key


def read_keys(key_file: str, coupler_key_file: str) -> Keys | None:
    """None when neither file is named, here or in the environment."""
    key_file = key_file or os.environ.get("GABION_KEY_FILE", "")
    coupler_key_file = coupler_key_file or os.environ.get("GABION_COUPLER_KEY_FILE", "")
    if not key_file and not coupler_key_file:
        return None
    if not key_file or not coupler_key_file:
        raise UsageError("keys: found only one of key_file and coupler_key_file, allowed: both, or neither")
    secret = read_key(key_file, SECRET)
    mode = stat.S_IMODE(os.stat(key_file).st_mode)
    if mode & 0o077:
        raise UsageError(
            f"{key_file}: found mode {mode:o}, allowed: 600 (chmod 600), because it holds a secret key")
    return Keys(secret, zmq.curve_public(secret), read_key(coupler_key_file, PUBLIC))


class HandshakeMonitor:
    """Why the coupler does not let a participant in."""

    def __init__(self, socket: zmq.Socket, keys: Keys | None) -> None:
        self._watched, self._has_keys = socket, keys is not None
        self._socket = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
                                                 | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
                                                 | zmq.EVENT_HANDSHAKE_FAILED_AUTH)
        self.hint = "is it running there?"

    def check(self) -> None:
        """Raises ProtocolError when trying again will not help; `hint` says more otherwise."""
        while not self._socket.closed and self._socket.poll(0):
            event = recv_monitor_message(self._socket)
            if event["event"] == zmq.EVENT_HANDSHAKE_FAILED_AUTH:
                raise ProtocolError("it does not know this participant's key: its public key must be in the coupler's "
                                    "protocol/security/clients_file")
            if event["event"] == zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL and event["value"] == MECHANISM_MISMATCH:
                raise ProtocolError("it uses no keys, this participant does (key_file, coupler_key_file)"
                                    if self._has_keys else
                                    "it takes participants with keys only (key_file, coupler_key_file)")
            self.hint = ("it closes the connection when keys are exchanged: perhaps coupler_key_file is not its "
                         "public key, or it uses no keys" if self._has_keys else
                         "it closes the connection at once: perhaps it takes participants with keys only "
                         "(key_file, coupler_key_file)")

    def close(self) -> None:
        if not self._socket.closed:
            self._watched.disable_monitor()
            self._socket.close(0)
