#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python decoder on spoilt frames: the same verdicts as the C++ decoder, and no other exception.

    decoders_agree.py FUZZ_DECODER VECTORS [--count N] [--seed S]
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent.parent.parent / "protocol" / "python")]
from gabion_participant.errors import ProtocolError  # noqa: E402
from gabion_participant.handshake import read_state, read_step_request, read_welcome  # noqa: E402
from gabion_participant.message import Message, decode, encode  # noqa: E402


def read_content(message: Message) -> None:
    """Every reader of a message's content may refuse it, and do nothing else."""
    for read in (read_welcome, read_step_request, read_state):
        try:
            read(message)
        except ProtocolError:
            pass


def verdict(frames: list[bytes]) -> bool:
    """Whether the decoder takes the frames."""
    try:
        message = decode(frames)
    except ProtocolError:
        return False
    read_content(message)
    again = decode(encode(message))
    same = (again.type, again.sequence, again.fields) == (message.type, message.sequence, message.fields)
    if not same or {k: v.tobytes() for k, v in again.arrays.items()} != {
            k: v.tobytes() for k, v in message.arrays.items()}:
        raise AssertionError("a second round changed the message")
    return True


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("fuzz_decoder")
    arguments.add_argument("vectors")
    arguments.add_argument("--count", type=int, default=20000)
    arguments.add_argument("--seed", type=int, default=2)
    options = arguments.parse_args()
    taken = total = wrong = 0
    begin = time.monotonic()
    with tempfile.NamedTemporaryFile("r", suffix=".jsonl") as cases:
        subprocess.run([options.fuzz_decoder, "--vectors", options.vectors, "--seed", str(options.seed), "--count",
                        str(options.count), "--write", cases.name], check=True, stdout=subprocess.DEVNULL)
        for number, line in enumerate(cases):
            case = json.loads(line)
            frames = [bytes.fromhex(frame) for frame in case["frames"]]
            try:
                accepted = verdict(frames)
                problem = "" if accepted == case["accepted"] else f"accepted here: {accepted}, in C++: {not accepted}"
            except Exception as other:  # noqa: BLE001 - any other exception is the finding
                accepted, problem = False, f"{type(other).__name__}: {other}"
            if problem and wrong < 20:
                print(f"input {number} of seed {options.seed}: {problem}\n  {frames[0][:300] if frames else frames}")
            total, taken, wrong = total + 1, taken + accepted, wrong + bool(problem)
    print(f"{total} inputs in {time.monotonic() - begin:.1f} s: {taken} accepted, {wrong} differ")
    return 1 if wrong or not 0 < taken < total else 0


if __name__ == "__main__":
    sys.exit(main())
