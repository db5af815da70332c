# SPDX-License-Identifier: BSD-3-Clause
"""The accepted steps of a run, as bytes: the state of a model that OpenSees cannot write itself."""

import json
import zlib


class History:
    """Steps as model_process: step takes them, (dt, loads, jumps); kept compressed."""

    def __init__(self) -> None:
        self.chunks: list[bytes] = []
        self.new: list[tuple] = []

    def append(self, dt: float, loads: list, jumps: list) -> None:
        self.new.append((dt, loads, jumps))
        if len(self.new) == 100:
            self.compress()

    def compress(self) -> None:
        if self.new:
            self.chunks.append(zlib.compress(json.dumps(self.new).encode(), 1))
            self.new = []

    def to_bytes(self) -> bytes:
        """Lengths of the chunks as a line, and the chunks."""
        self.compress()
        return json.dumps([len(chunk) for chunk in self.chunks]).encode() + b"\n" + b"".join(self.chunks)

    @staticmethod
    def from_bytes(content: bytes) -> "History":
        head, _, rest = content.partition(b"\n")
        history, at = History(), 0
        for length in json.loads(head):
            history.chunks.append(rest[at:at + length])
            at += length
        return history

    def steps(self):
        """Lists of steps, one after the other."""
        for chunk in self.chunks:
            yield json.loads(zlib.decompress(chunk))
        if self.new:
            yield self.new
