# SPDX-License-Identifier: BSD-3-Clause
"""Displacements and velocities from the restart file of ccx: the only file that has them in double precision
(.dat has 7 digits, .frd 6).

Fortran records, each between two counts of its bytes. What stands before the displacements depends on the model; their
record is found by its place in that order and must have the right length.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

VERSION, VERSION_RECORD = "Version 2.20", bytes(80)
# Records of one integer each, in the order of the file; a number in brackets: so many in one record.
HEADER = ("step", "nset", "nalset", "nload", "nbody", "nforc", "nboun", "nflow", "nk", "ne", "nef", "nkon", "mi[3]",
          "nmpc", "mpcend", "maxlenmpc", "memmpc", "nfc", "ndc", "nmat", "ntmat", "npmat", "ncmat", "nprop", "norien",
          "ntrans", "nam", "namtot", "nprint", "nlabel", "ntie", "ncs", "mcs", "ne1d", "ne2d", "infree[4]", "nmethod",
          "iperturb[2]", "nener", "iplas", "ithermal", "nstate", "nslavs", "iprestr", "mortar")


class RestartFileError(Exception):
    """The file is not one that this ccx is known to write."""


@dataclass(frozen=True)
class NodalState:
    displacement: np.ndarray  # [m], num_nodes x 3, row k of node k + 1
    velocity: np.ndarray  # [m/s]; zero in statics


def records(data: bytes) -> Iterator[bytes]:
    at = 0
    while at < len(data):
        count = struct.unpack_from("<i", data, at)[0]
        end = at + 4 + count
        if count < 0 or end + 4 > len(data) or struct.unpack_from("<i", data, end)[0] != count:
            raise RestartFileError(f"a broken record at byte {at}")
        yield data[at + 4:end]
        at = end + 4


def read_header(stream: Iterator[bytes]) -> dict[str, int]:
    version = next(stream).decode("ascii", "replace").strip()
    if version != VERSION:
        raise RestartFileError(f'found "{version}", allowed: {VERSION} (package calculix-ccx of Debian 12)')
    header = {}
    for name in HEADER:
        header[name] = struct.unpack_from("<i", record := next(stream))[0]
        if name == "mi[3]":
            header["mi2"] = struct.unpack("<3i", record)[1]
        elif name == "iperturb[2]":
            header["iperturb1"] = struct.unpack("<2i", record)[0]
    return header


def limit_reserve(path: Path, reserve: int | None) -> int:
    """Set the file's reserve of room for multi-point constraints to this one, where it is larger; None: leave it.
    Returns it. Each *RESTART, READ adds to it what a new model would need, so that ccx clears ever more memory."""
    with path.open("r+b") as file:
        head = records(file.read(20 + 4096))
        next(head)
        at = 8 + len(VERSION_RECORD)
        for name in HEADER:
            record = next(head)
            if name == "memmpc":
                break
            at += 8 + len(record)
        found = struct.unpack("<i", record)[0]
        if reserve is None or found <= reserve:
            return found
        file.seek(at + 4)
        file.write(struct.pack("<i", reserve))
    return reserve


def records_before_displacement(header: dict[str, int]) -> int:
    """Number of records between the header and the displacements."""
    amplitudes = header["nam"] > 0
    count = 2 * (header["mortar"] == 1) + 2  # rest of the header
    count += 3 + header["nalset"] + 1 + 4  # sets, title, mesh
    count += 9 + amplitudes + 7 + 3 * (header["nfc"] > 0)  # supports, multi-point constraints, coupling
    count += 6 + amplitudes + 8 + amplitudes  # concentrated and distributed loads
    count += header["iprestr"] > 0
    count += 3 + 2 + 2 + 2 + 2 + 3 + 1  # labels, materials, physical constants
    count += 4 * (header["npmat"] != 0) + 3 * (header["norien"] != 0) + 2 * (header["nprop"] != 0)
    count += 2 * (header["ntrans"] != 0) + 4 * amplitudes
    if header["ithermal"] > 0:
        count += 3 + 2 * (header["ne1d"] > 0 or header["ne2d"] > 0) + amplitudes
    return count + 2  # names and numbers of materials


def read_nodal_state(path: Path) -> NodalState:
    """Raises RestartFileError."""
    try:
        stream = records(path.read_bytes())
        header = read_header(stream)
        if header["nstate"] > 0 and header["mortar"] not in (0, 1):
            raise RestartFileError("found state variables that ccx has not written, allowed: materials without "
                                   "them, or contact in the deck")
        for _ in range(records_before_displacement(header)):
            next(stream)
        columns = header["mi2"] + 1
        displacement = as_table(next(stream), header["nk"], columns)
        moves = header["nmethod"] == 4 or (header["nmethod"] == 1 and header["iperturb1"] >= 2)
        velocity = as_table(next(stream), header["nk"], columns) if moves else np.zeros_like(displacement)
        return NodalState(displacement, velocity)
    except (RestartFileError, StopIteration, struct.error) as problem:
        raise RestartFileError(f"{path}: {str(problem) or 'it ends too early'}") from problem


def as_table(record: bytes, nodes: int, columns: int) -> np.ndarray:
    if len(record) != 8 * nodes * columns:
        raise RestartFileError(f"found a record of {len(record)} bytes, allowed: {8 * nodes * columns}, "
                               f"the displacements of {nodes} nodes")
    return np.frombuffer(record, "<f8").reshape(nodes, columns)[:, 1:4].copy()
