# SPDX-License-Identifier: BSD-3-Clause
"""Messages and their frames (protocol/README.md, sections 2 and 10)."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NoReturn

import numpy as np

from .errors import ProtocolError

MAX_HEADER_BYTES = 1 << 20
MAX_DEPTH = 32  # nesting of the header
MAX_ARRAYS = 256
MAX_FRAME_BYTES = 1 << 30  # of one array
MAX_PAYLOAD_BYTES = 1 << 31  # of all arrays of a message
VALUE_BYTES = 8
DTYPES = ("<f8", "<i8")
RESERVED = ("type", "sequence", "arrays")


def shortened(value: Any) -> str:
    """A value for an error message, cut to 80 characters."""
    text = json.dumps(value, default=str)
    return text if len(text) <= 80 else text[:77] + "..."


def is_integer(value: Any) -> bool:
    """Whether JSON's value is an integer; Python takes true for 1, JSON does not."""
    return isinstance(value, int) and not isinstance(value, bool)


@dataclass
class Message:
    """A type, the number of the request that it is or answers, small fields, and arrays by name.

    Arrays have 1 to 4 dimensions and dtype "<f8" or "<i8".
    """

    type: str
    sequence: int = 0
    fields: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)

    def wrong(self, key: str, expected: str) -> NoReturn:
        found = shortened(self.fields[key]) if key in self.fields else "nothing"
        raise ProtocolError(f'message "{self.type}", field "{key}": expected {expected}, found {found}')

    def number(self, key: str) -> float:
        value = self.fields.get(key)
        if not (is_integer(value) or isinstance(value, float)):
            self.wrong(key, "a number")
        return float(value)

    def positive_number(self, key: str) -> float:
        value = self.number(key)
        if not value > 0:
            self.wrong(key, "a number > 0")
        return value

    def integer(self, key: str) -> int:
        value = self.fields.get(key)
        if not is_integer(value) or not -(1 << 63) <= value < 1 << 63:
            self.wrong(key, "a signed 64-bit integer")
        return value

    def count(self, key: str) -> int:
        value = self.integer(key)
        if value < 0:
            self.wrong(key, "a count")
        return value

    def boolean(self, key: str) -> bool:
        value = self.fields.get(key)
        if not isinstance(value, bool):
            self.wrong(key, "true or false")
        return value

    def text(self, key: str) -> str:
        value = self.fields.get(key)
        if not isinstance(value, str):
            self.wrong(key, "a text")
        return value

    def object(self, key: str) -> "Message":
        """A nested object, to be read with the same typed access."""
        value = self.fields.get(key)
        if not isinstance(value, dict):
            self.wrong(key, "an object")
        return Message(f"{self.type}.{key}", fields=value)

    def reals(self, name: str, shape: tuple[int, ...]) -> np.ndarray:
        """An array of finite values; an extent of -1 in `shape` accepts any."""
        array = self._array(name, "<f8", shape)
        require_finite(array, name)
        return array

    def integers(self, name: str, shape: tuple[int, ...]) -> np.ndarray:
        """An array of integers; an extent of -1 in `shape` accepts any."""
        return self._array(name, "<i8", shape)

    def _array(self, name: str, dtype: str, shape: tuple[int, ...]) -> np.ndarray:
        array = self.arrays.get(name)
        where = f'message "{self.type}", array "{name}"'
        if array is None:
            raise ProtocolError(f"{where}: expected shape {list(shape)}, found none")
        fits = array.ndim == len(shape) and all(a in (-1, b) for a, b in zip(shape, array.shape))
        if array.dtype != np.dtype(dtype) or not fits:
            raise ProtocolError(f'{where}: expected "{dtype}" of shape {list(shape)}, found '
                                f'"{array.dtype.str}" of shape {list(array.shape)}')
        return array


def require_finite(values: np.ndarray, name: str) -> None:
    """Raise ProtocolError that names vertex and component of the first value that is not finite."""
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        where = bad[0]
        component = f", component {where[1]}" if len(where) > 1 else ""
        raise ProtocolError(f'"{name}" is {values[tuple(where)]} at vertex {where[0]}{component}: '
                            "values must be finite")


def encode(message: Message) -> list[bytes]:
    """The frames of a message, header first. Raises ProtocolError when a limit is exceeded."""
    header = dict(message.fields)
    clash = [key for key in RESERVED if key in header]
    if clash:
        raise ProtocolError(f'message "{message.type}": field "{clash[0]}" is a reserved key')
    header |= {"type": message.type, "sequence": message.sequence}
    if len(message.arrays) > MAX_ARRAYS:
        raise ProtocolError(
            f'message "{message.type}": {len(message.arrays)} arrays exceed the limit of {MAX_ARRAYS}')
    payloads, described = [], []
    for name, array in message.arrays.items():
        if array.dtype.str not in DTYPES or not 1 <= array.ndim <= 4:
            raise ProtocolError(f'message "{message.type}", array "{name}": expected "<f8" or "<i8" with '
                                f'1 to 4 extents, found "{array.dtype.str}" with {array.ndim}')
        if array.nbytes > MAX_FRAME_BYTES:
            raise ProtocolError(
                f'array "{name}" of {array.nbytes} bytes exceeds the limit of {MAX_FRAME_BYTES}')
        payloads.append(np.ascontiguousarray(array).tobytes())
        described.append({"name": name, "dtype": array.dtype.str, "shape": list(array.shape)})
    if sum(map(len, payloads)) > MAX_PAYLOAD_BYTES:
        raise ProtocolError(f'message "{message.type}" exceeds the limit of {MAX_PAYLOAD_BYTES} bytes')
    if described:
        header["arrays"] = described
    try:
        text = json.dumps(header, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
        frame = text.encode()
    except (ValueError, TypeError) as problem:
        raise ProtocolError(f'message "{message.type}" cannot be written as JSON: {problem}') from problem
    if len(frame) > MAX_HEADER_BYTES:
        raise ProtocolError(f'message "{message.type}": header of {len(frame)} bytes exceeds the limit of '
                            f"{MAX_HEADER_BYTES}")
    return [frame, *payloads]


def check_depth(header: str) -> None:
    """Nesting is bounded before parsing, so that nothing recursive can exhaust the stack."""
    if header.count("{") + header.count("[") <= MAX_DEPTH:
        return
    depth, in_text, escaped = 0, False, False
    for character in header:
        if in_text:
            if escaped:
                escaped = False
            elif character == "\\":
                escaped = True
            elif character == '"':
                in_text = False
        elif character == '"':
            in_text = True
        elif character in "{[":
            depth += 1
            if depth > MAX_DEPTH:
                raise ProtocolError(f"header frame: nested deeper than {MAX_DEPTH}")
        elif character in "}]":
            depth -= 1


def finite_number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is no finite number")
    return value


def parse_header(frame: bytes) -> dict[str, Any]:
    if len(frame) > MAX_HEADER_BYTES:
        raise ProtocolError(f"header frame of {len(frame)} bytes exceeds the limit of {MAX_HEADER_BYTES}")
    try:
        text = frame.decode()
        check_depth(text)
        header = json.loads(text, parse_float=finite_number, parse_constant=finite_number)
        if "\\u" in text:
            json.dumps(header, ensure_ascii=False).encode()  # raises for half of a surrogate pair
    except ValueError as problem:
        raise ProtocolError(f"header frame is not JSON: {problem}") from problem
    if not isinstance(header, dict):
        raise ProtocolError(f"header frame: expected a JSON object, found {shortened(header)}")
    return header


def read_description(entry: Any) -> tuple[str, str, tuple[int, ...]]:
    """Name, dtype and shape of one entry of "arrays"."""
    if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
        raise ProtocolError(f'header frame: an array lacks the text "name": {shortened(entry)}')
    name, dtype, shape = entry["name"], entry.get("dtype"), entry.get("shape")
    if dtype not in DTYPES:
        raise ProtocolError(f'array "{name}": expected dtype "<f8" or "<i8", found {shortened(dtype)}')
    if not isinstance(shape, list) or not 1 <= len(shape) <= 4 or not all(is_integer(n) for n in shape):
        raise ProtocolError(
            f'array "{name}": expected a "shape" of 1 to 4 integers, found {shortened(shape)}')
    if min(shape) < 0:
        raise ProtocolError(f'array "{name}": negative extent {min(shape)}')
    return name, dtype, tuple(shape)


def read_arrays(descriptions: Any, frames: Sequence[bytes], kind: str) -> dict[str, np.ndarray]:
    if not isinstance(descriptions, list):
        raise ProtocolError('header frame: "arrays" is no list')
    if len(descriptions) > MAX_ARRAYS:
        raise ProtocolError(f"header frame: {len(descriptions)} arrays exceed the limit of {MAX_ARRAYS}")
    if len(descriptions) != len(frames):
        raise ProtocolError(f'message "{kind}": header describes {len(descriptions)} arrays, '
                            f"found {len(frames)} frames")
    if sum(map(len, frames)) > MAX_PAYLOAD_BYTES:
        raise ProtocolError(f'message "{kind}" exceeds the limit of {MAX_PAYLOAD_BYTES} bytes')
    arrays: dict[str, np.ndarray] = {}
    for entry, frame in zip(descriptions, frames):
        name, dtype, shape = read_description(entry)
        if name in arrays:
            raise ProtocolError(f'array "{name}" is there twice')
        if VALUE_BYTES * math.prod(extent for extent in shape if extent) > MAX_FRAME_BYTES:
            raise ProtocolError(
                f'array "{name}" of shape {list(shape)} exceeds the limit of {MAX_FRAME_BYTES} bytes')
        expected = VALUE_BYTES * math.prod(shape)
        if len(frame) != expected:
            raise ProtocolError(f'array "{name}" of shape {list(shape)}: expected a frame of {expected} '
                                f"bytes, found {len(frame)}")
        arrays[name] = np.frombuffer(frame, dtype=dtype).reshape(shape).copy()
    return arrays


def decode(frames: Sequence[bytes]) -> Message:
    """Frames back to a message: either it is whole, or this raises ProtocolError and says which frame is
    wrong."""
    if not frames:
        raise ProtocolError("message without frames")
    header = parse_header(frames[0])
    kind = header.pop("type", None)
    if not isinstance(kind, str):
        raise ProtocolError('header frame: expected a text "type"')
    sequence = header.pop("sequence", None)
    if not is_integer(sequence) or not 0 <= sequence < 1 << 64:
        raise ProtocolError('header frame: expected an integer "sequence" >= 0')
    arrays = read_arrays(header.pop("arrays", []), frames[1:], kind)
    return Message(kind, sequence, header, arrays)
