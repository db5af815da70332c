# SPDX-License-Identifier: BSD-3-Clause
"""Hello and welcome (protocol/README.md, sections 4 and 7), step requests and values."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .errors import ProtocolError, UsageError
from .message import VALUE_BYTES, Message, require_finite
from .process import ProcessIdentity, this_process
from .solver import (END_OF_STEP, STEP_MEAN, AcceptReport, InterfaceMesh, InterfaceValues, StepReport,
                     StepRequest)

PROTOCOL_VERSION = "1.4"
SIGN_CONVENTION = "displacement: total from reference; force: by soil on structure"
UNITS = {"displacement": "m", "force": "N"}
NAME = re.compile(r"[A-Za-z0-9_.-]{1,64}")


@dataclass
class ParticipantSettings:
    """Who takes part, and where the coupler listens."""

    name: str  # of the participant in coupler.json
    endpoint: str  # such as "tcp://127.0.0.1:5555"
    dimension: int  # 2 or 3
    receives: str = "force"  # a structure receives force and sends displacement, a soil the reverse
    program: str = "python"  # for messages
    program_version: str = "0"
    scene_hash: str = ""  # "" = this code does not read the scene
    connect_deadline: float = 30.0  # [s] until the coupler has answered
    # Own secret key and the coupler's public key, where it asks for keys (keys.py). "": GABION_KEY_FILE and
    # GABION_COUPLER_KEY_FILE of the environment, else no keys.
    key_file: str = ""
    coupler_key_file: str = ""
    # End this process when the coupler is lost while the solver computes. A library inside another program
    # says false and notices the loss when its solver returns.
    exit_when_coupler_is_lost: bool = True

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.name):
            raise UsageError(f'name: found "{self.name}", allowed: 1 to 64 letters, digits, "_", "-" or "."')
        if self.dimension not in (2, 3):
            raise UsageError(f"dimension: found {self.dimension}, allowed: 2 or 3")
        if self.receives not in UNITS:
            raise UsageError(f'receives: found "{self.receives}", allowed: {", ".join(UNITS)}')
        if not self.connect_deadline > 0:
            raise UsageError(f"connect_deadline: found {self.connect_deadline}, allowed: > 0 s")

    @property
    def sends(self) -> str:
        return "displacement" if self.receives == "force" else "force"


@dataclass
class Welcome:
    """The coupler's answer to an accepted hello. Times in s."""

    protocol: str
    process: ProcessIdentity
    silence_deadline: float
    idle_deadline: float
    heartbeat: float
    run: dict[str, Any] = field(default_factory=dict)  # settings of the run: end time, dt, folders


def check_interfaces(interfaces: Sequence[InterfaceMesh], dimension: int) -> None:
    """Raise UsageError for a mesh that the coupler would refuse."""
    names = [mesh.name for mesh in interfaces]
    if not names or len(set(names)) != len(names):
        raise UsageError(f"interfaces: found {names}, allowed: one or more, each name once")
    for mesh in interfaces:
        where = f'interface "{mesh.name}"'
        if mesh.coordinates.ndim != 2 or mesh.coordinates.shape[1] != dimension:
            raise UsageError(f"{where}: found coordinates of shape {list(mesh.coordinates.shape)}, "
                             f"allowed: num_vertices x {dimension}")
        if not np.isfinite(mesh.coordinates).all():
            raise UsageError(f"{where}: coordinates must be finite")
        if mesh.force_kind not in (END_OF_STEP, STEP_MEAN):
            raise UsageError(f'{where}: found force_kind "{mesh.force_kind}", '
                             f"allowed: {END_OF_STEP}, {STEP_MEAN}")
        if mesh.facets is None:
            continue
        if mesh.facets.ndim != 2 or mesh.facets.shape[1] not in (2, 3, 4):
            raise UsageError(f"{where}: found facets of shape {list(mesh.facets.shape)}, "
                             "allowed: num_facets x 2, 3 or 4")
        if mesh.facets.size and not (0 <= mesh.facets.min() and mesh.facets.max() < len(mesh.coordinates)):
            raise UsageError(f"{where}: facets name vertices {mesh.facets.min()} to {mesh.facets.max()}, "
                             f"allowed: 0 to {len(mesh.coordinates) - 1}")


@dataclass
class Introduction:
    """Data of a solver in the handshake. `probes`: values in the initial state, as many as names. `keeps_state`: it
    answers "save" and "load"; `takes_force_kinds`: it answers "set_force_kinds"; `start`: displacements in the initial
    state [m], of interfaces that begin displaced; `takes_start`: it answers "set_start"; `takes_facets`: it answers
    "set_facets"; `changing`: names of the interfaces whose facets may change."""

    interfaces: Sequence[InterfaceMesh]
    probe_names: Sequence[str] = ()
    probes: Sequence[float] = ()
    keeps_state: bool = False
    takes_force_kinds: bool = False
    start: InterfaceValues = field(default_factory=dict)
    takes_start: bool = False
    takes_facets: bool = False
    changing: Sequence[str] = ()


def hello(settings: ParticipantSettings, session: str, introduction: Introduction) -> Message:
    """Data of a participant about itself."""
    interfaces, probes = introduction.interfaces, introduction.probes
    check_interfaces(interfaces, settings.dimension)
    if len(introduction.probe_names) != len(probes):
        raise UsageError(f"probes: found {len(probes)} values, allowed: as many as names, "
                         f"{len(introduction.probe_names)}")
    message = Message("hello", fields={
        "protocol": PROTOCOL_VERSION, "participant": settings.name, "program": settings.program,
        "program_version": settings.program_version, "session": session, "scene_hash": settings.scene_hash,
        "dimension": settings.dimension,
        "receives": {"quantity": settings.receives, "unit": UNITS[settings.receives]},
        "sends": {"quantity": settings.sends, "unit": UNITS[settings.sends]},
        "convention": SIGN_CONVENTION,
        "interfaces": [
            {"name": mesh.name, "vertices_per_facet": 0 if mesh.facets is None else mesh.facets.shape[1],
             "force_kind": mesh.force_kind} | may_change(mesh, introduction.changing)
            for mesh in interfaces],
        "probe_names": list(introduction.probe_names), "heartbeat": True,
        "process": this_process().to_fields(), "keeps_state": introduction.keeps_state,
        "takes_force_kinds": introduction.takes_force_kinds,
        "takes_start": introduction.takes_start,
        "takes_next_step": True,  # requests are taken from the socket one by one
    })
    if introduction.takes_facets:
        message.fields["takes_facets"] = True
    for mesh in interfaces:
        message.arrays[f"coordinates:{mesh.name}"] = mesh.coordinates
        if mesh.facets is not None:
            message.arrays[f"facets:{mesh.name}"] = mesh.facets
    put_start(message, interfaces, introduction.start)
    message.arrays["probes"] = np.array(probes, dtype="<f8")
    return message


def may_change(mesh: InterfaceMesh, changing: Sequence[str]) -> dict[str, bool]:
    """The field of an interface whose facets may change. Raises UsageError where it has none."""
    if mesh.name not in changing:
        return {}
    if mesh.facets is None:
        raise UsageError(f'facets: found interface "{mesh.name}" without facets, allowed: one that has some at the '
                         "beginning")
    return {"facets_may_change": True}


def put_start(message: Message, interfaces: Sequence[InterfaceMesh], start: InterfaceValues) -> None:
    """Displacements in the initial state, where any is not zero. Raises as put_values()."""
    unknown = set(start) - {mesh.name for mesh in interfaces}
    if unknown:
        raise UsageError(f"start_displacements: found interfaces {sorted(unknown)}, "
                         f"allowed: {sorted(mesh.name for mesh in interfaces)}")
    displaced = [mesh for mesh in interfaces if np.any(start.get(mesh.name, 0.0))]
    put_values(message, "displacement", displaced, {mesh.name: start[mesh.name] for mesh in displaced})


def major_version(version: str) -> int:
    """The major of "major.minor"."""
    found = re.match(r"0*([0-9]{1,10})\.", version)
    if not found or int(found[1]) >= 2**31:
        raise ProtocolError(f'protocol version: expected "major.minor", found "{version}"')
    return int(found[1])


def read_welcome(message: Message) -> Welcome:
    """Raises ProtocolError when a field is missing, or the major of the protocol is another one."""
    protocol = message.text("protocol")
    if major_version(protocol) != major_version(PROTOCOL_VERSION):
        raise ProtocolError(f"protocol version: coupler {protocol}, participant {PROTOCOL_VERSION}")
    process = message.object("process")
    return Welcome(protocol,
                   ProcessIdentity(process.text("host"), process.integer("pid"),
                                   process.integer("start_time")),
                   message.positive_number("silence_deadline"), message.positive_number("idle_deadline"),
                   message.positive_number("heartbeat"), message.object("run").fields)


def read_force_kinds(message: Message, interfaces: Sequence[InterfaceMesh]) -> dict[str, str]:
    """Force kinds of a message "set_force_kinds". Raises ProtocolError for an interface that is none of
    these, or no such kind."""
    kinds = message.object("kinds").fields
    names = [mesh.name for mesh in interfaces]
    for name, kind in kinds.items():
        if name not in names:
            raise ProtocolError(f'message "{message.type}": interface "{name}" is none of this participant')
        if kind not in (END_OF_STEP, STEP_MEAN):
            raise ProtocolError(f'interface "{name}": expected force_kind "{END_OF_STEP}" or "{STEP_MEAN}", '
                                f"found {kind!r}")
    return dict(kinds)


def read_step_request(message: Message) -> StepRequest:
    return StepRequest(message.integer("step"), message.count("iteration"), message.number("time"),
                       message.positive_number("dt"))


def is_asked_for(message: Message, proposed_dt: float) -> bool:
    """Whether a "solve_step" is to be done after an acceptance that proposed this dt [s], 0 = no opinion, which
    is above all others."""
    least = message.number("proposed_dt_from") if "proposed_dt_from" in message.fields else 0
    below = message.positive_number("proposed_dt_below") if "proposed_dt_below" in message.fields else None
    if proposed_dt <= 0:
        return below is None
    return proposed_dt >= least and (below is None or proposed_dt < below)


def read_values(message: Message, quantity: str, interfaces: Sequence[InterfaceMesh]) -> InterfaceValues:
    """One array "<quantity>:<interface>" of num_vertices x dim an interface; none at all: free interfaces,
    {}."""
    if not message.arrays:
        return {}
    values = {mesh.name: message.reals(f"{quantity}:{mesh.name}", mesh.coordinates.shape)
              for mesh in interfaces}
    if len(message.arrays) != len(values):
        raise ProtocolError(
            f'message "{message.type}": expected {len(values)} arrays, found {len(message.arrays)}')
    return values


def put_values(message: Message, quantity: str, interfaces: Sequence[InterfaceMesh],
               values: InterfaceValues) -> None:
    """Raises UsageError for a missing or unknown interface and another shape, ProtocolError for NaN or
    infinity."""
    names = [mesh.name for mesh in interfaces]
    if set(values) != set(names):
        raise UsageError(f"{quantity}: found values of interfaces {sorted(values)}, allowed: {sorted(names)}")
    for mesh in interfaces:
        array = np.asarray(values[mesh.name], dtype="<f8")
        if array.shape != mesh.coordinates.shape:
            raise UsageError(f'{quantity} of "{mesh.name}": found shape {list(array.shape)}, '
                             f"allowed: {list(mesh.coordinates.shape)}")
        require_finite(array, f"{quantity}:{mesh.name}")
        message.arrays[f"{quantity}:{mesh.name}"] = array


def plain(value: Any) -> Any:
    """Numbers of numpy as Python's own; NaN and infinity, which JSON lacks, as null."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not math.isfinite(value) else value


def solved(report: StepReport) -> Message:
    return Message("solved", fields={
        "newton_iterations": int(report.newton_iterations),
        "linear_iterations": int(report.linear_iterations),
        "interface_active": bool(report.interface_active), "details": plain(report.details)})


def accepted(report: AcceptReport, probes: Sequence[float]) -> Message:
    return Message("accepted", fields={
        "at_rest": bool(report.at_rest), "proposed_dt": float(report.proposed_dt),
        "details": plain(report.details),
    }, arrays={"probes": np.array(probes, dtype="<f8")})


def saved(state: bytes) -> Message:
    """The bytes as one array, eight a value, filled up with zeros, and their number. Raises UsageError for
    anything else."""
    if not isinstance(state, (bytes, bytearray)):
        raise UsageError(f"saved state: found {type(state).__name__}, allowed: bytes")
    padded = state + bytes(-len(state) % VALUE_BYTES)
    return Message("saved", fields={"state": {"bytes": len(state)}},
                   arrays={"integer:bytes": np.frombuffer(padded, dtype="<i8")})


def read_state(message: Message) -> bytes:
    """The bytes of saved(). Raises ProtocolError for a state of another form."""
    count = message.object("state").count("bytes")
    values = message.integers("integer:bytes", (-1,))
    if values.size != -(-count // VALUE_BYTES):
        raise ProtocolError(
            f"state: expected an array of {count} bytes, found {values.size} values of 8 bytes")
    return values.tobytes()[:count]


def loaded(probes: Sequence[float]) -> Message:
    return Message("loaded", arrays={"probes": np.array(probes, dtype="<f8")})


def start_set(probes: Sequence[float]) -> Message:
    return Message("start_set", arrays={"probes": np.array(probes, dtype="<f8")})
