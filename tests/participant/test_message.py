#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The vectors of protocol/test_vectors, which the C++ side reads too, and the limits."""

import json
import re
import unittest

import numpy as np
from fake_coupler import ROOT
from gabion_participant import ProtocolError
from gabion_participant.handshake import read_state, saved
from gabion_participant.message import MAX_FRAME_BYTES, Message, decode, encode


def vectors(name: str) -> list[dict]:
    return json.loads((ROOT / "protocol" / "test_vectors" / name).read_text(encoding="utf-8"))


def frames_of(vector: dict) -> list[bytes]:
    header = bytes.fromhex(vector["header_hex"]) if "header_hex" in vector else vector["header"].encode()
    return [header, *map(bytes.fromhex, vector["payloads"])]


def message_of(vector: dict) -> Message:
    described = vector["message"]
    arrays = {}
    for array in described["arrays"]:
        values = map(float, array["values"]) if array["dtype"] == "<f8" else array["values"]
        arrays[array["name"]] = np.array(list(values), dtype=array["dtype"]).reshape(array["shape"])
    return Message(described["type"], described["sequence"], described["fields"], arrays)


class Vectors(unittest.TestCase):
    def test_encode_to_these_bytes(self) -> None:
        for vector in vectors("accepted.json"):
            with self.subTest(vector["name"]):
                self.assertEqual(encode(message_of(vector)), frames_of(vector))

    def test_decode_to_this_content(self) -> None:
        for vector in vectors("accepted.json"):
            with self.subTest(vector["name"]):
                found, expected = decode(frames_of(vector)), message_of(vector)
                self.assertEqual((found.type, found.sequence, found.fields),
                                 (expected.type, expected.sequence, expected.fields))
                self.assertEqual(list(found.arrays), list(expected.arrays))
                for name, array in expected.arrays.items():
                    self.assertEqual(found.arrays[name].dtype, array.dtype)
                    self.assertEqual(found.arrays[name].shape, array.shape)
                    self.assertEqual(found.arrays[name].tobytes(), array.tobytes())

    def test_malformed_frames_are_refused(self) -> None:
        refused = vectors("refused.json")
        self.assertGreater(len(refused), 40)
        for vector in refused:
            with self.subTest(vector["name"]), self.assertRaisesRegex(ProtocolError, re.escape(vector["says"])):
                decode(frames_of(vector))

    def test_bytes_of_a_state(self) -> None:
        packed = [vector for vector in vectors("accepted.json") if "bytes" in vector]
        self.assertEqual(len(packed), 3)
        for vector in packed:
            with self.subTest(vector["name"]):
                expected = message_of(vector)
                found = saved(bytes.fromhex(vector["bytes"]))
                self.assertEqual(found.fields["state"], expected.fields["state"])
                self.assertEqual(found.arrays["integer:bytes"].tolist(), expected.arrays["integer:bytes"].tolist())
                self.assertEqual(read_state(expected).hex(), vector["bytes"])

    def test_bytes_that_are_not_as_many_as_said(self) -> None:
        for count, values in ((9, 1), (8, 2), (1, 0), (0, 1), (1 << 62, 1)):
            with self.subTest(count), self.assertRaisesRegex(ProtocolError, f"{count} bytes, found {values} values"):
                read_state(Message("load", 1, {"state": {"bytes": count}},
                                   {"integer:bytes": np.zeros(values, dtype="<i8")}))


class Limits(unittest.TestCase):
    def test_no_frames(self) -> None:
        self.assertRaisesRegex(ProtocolError, "without frames", decode, [])

    def test_long_header(self) -> None:
        with self.assertRaisesRegex(ProtocolError, "header frame of 1048577 bytes exceeds the limit"):
            decode([b" " * ((1 << 20) + 1)])
        with self.assertRaisesRegex(ProtocolError, "header of .* bytes exceeds the limit"):
            encode(Message("x", fields={"text": "a" * (1 << 20)}))

    def test_many_arrays(self) -> None:
        entry = ",".join(f'{{"name":"a{i}","dtype":"<f8","shape":[0]}}' for i in range(257))
        header = f'{{"type":"x","sequence":1,"arrays":[{entry}]}}'.encode()
        with self.assertRaisesRegex(ProtocolError, "257 arrays exceed the limit of 256"):
            decode([header] + [b""] * 257)
        with self.assertRaisesRegex(ProtocolError, "257 arrays exceed the limit of 256"):
            encode(Message("x", arrays={str(i): np.zeros(1) for i in range(257)}))

    def test_long_array(self) -> None:
        view = np.broadcast_to(np.zeros(1), (MAX_FRAME_BYTES // 8 + 1,))  # needs no memory
        with self.assertRaisesRegex(ProtocolError, "exceeds the limit"):
            encode(Message("x", arrays={"u": view}))

    def test_what_json_lacks_is_not_sent(self) -> None:
        for value in (float("nan"), float("inf"), object()):
            with self.subTest(value), self.assertRaisesRegex(ProtocolError, "cannot be written as JSON"):
                encode(Message("x", fields={"dt": value}))

    def test_another_dtype_is_not_sent(self) -> None:
        with self.assertRaisesRegex(ProtocolError, '"u": expected "<f8" or "<i8"'):
            encode(Message("x", arrays={"u": np.zeros(3, dtype="<f4")}))


class TypedAccess(unittest.TestCase):
    def test_wrong_types_are_named(self) -> None:
        message = Message("solve_step", fields={"dt": True, "step": 1.0, "solved": 1, "reason": None, "run": []},
                          arrays={"u": np.zeros((2, 2)), "n": np.zeros(2, dtype="<i8"), "bad": np.array([[0, np.nan]])})
        for read, key, words in ((message.number, "dt", "a number, found true"),
                                 (message.integer, "step", "integer, found 1.0"),
                                 (message.boolean, "solved", "true or false, found 1"),
                                 (message.text, "reason", "a text, found null"),
                                 (message.object, "run", "an object, found"),
                                 (message.number, "time", "a number, found nothing")):
            with self.subTest(key), self.assertRaisesRegex(ProtocolError, f'"solve_step", field "{key}".*{words}'):
                read(key)
        for name, words in (("u", r"shape \[3, 2\].*shape \[2, 2\]"), ("n", '"<i8"'), ("none", "found none")):
            with self.subTest(name), self.assertRaisesRegex(ProtocolError, words):
                message.reals(name, (3, 2))
        with self.assertRaisesRegex(ProtocolError, '"bad" is nan at vertex 0, component 1'):
            message.reals("bad", (1, 2))


if __name__ == "__main__":
    unittest.main()
