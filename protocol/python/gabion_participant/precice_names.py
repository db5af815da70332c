# SPDX-License-Identifier: BSD-3-Clause
"""The participant's side under the names of preCICE's Python bindings, version 3, for their adapters.

    import gabion_participant.precice_names as precice      in place of: import precice

or without any change, the adapter as it is:

    python3 -m gabion_participant.precice_names adapter.py ARGUMENTS --coupler tcp://host:port

The endpoint of the coupler is GABION_COUPLER of the environment, or --coupler among the arguments. Details are in
docs/precice_names.md.
"""

import os
import runpy
import sys
import warnings
from typing import Any

import numpy as np

from .errors import UsageError
from .handshake import PROTOCOL_VERSION, ParticipantSettings
from .participant import SAME_TIME
from .participant import Participant as OwnParticipant
from .precice_config import CoupledMesh, NotMapped, read_config
from .solver import END_OF_STEP

__all__ = ["NotMapped", "Participant", "get_version_information"]
__version__ = "3.0.0"  # of the names

ENDPOINT = "GABION_COUPLER"
OLD = ("Interface", "SolverInterface", "action_write_initial_data", "action_write_iteration_checkpoint",
       "action_read_iteration_checkpoint")


def __getattr__(name: str) -> Any:
    if name in OLD:
        raise NotMapped(f"precice.{name} is of preCICE 2 or before; allowed: those of version 3, "
                        "precice.Participant")
    raise AttributeError(f"module {__name__} has no attribute {name}")


def get_version_information() -> bytes:
    """Says that this is not preCICE."""
    text = f"gabion_participant, protocol {PROTOCOL_VERSION}, under the names of preCICE {__version__}"
    return text.encode()


def endpoint() -> str:
    """Endpoint at which the coupler listens. Raises UsageError when nobody has said so."""
    if "--coupler" in sys.argv[:-1]:
        return sys.argv[sys.argv.index("--coupler") + 1]
    if os.environ.get(ENDPOINT):
        return os.environ[ENDPOINT]
    raise UsageError(f"where is the coupler? Allowed: {ENDPOINT}=tcp://host:port in the environment, or "
                     "--coupler tcp://host:port among the arguments")


class _Mesh:
    """Vertices, facets and values of one provided mesh."""

    def __init__(self, known: CoupledMesh) -> None:
        self.known = known
        self.positions = np.zeros((0, known.dimension))
        self.facets: dict[int, list[list[int]]] = {2: [], 3: [], 4: []}  # by the number of their vertices
        self.written: np.ndarray | None = None  # since the last advance(); NaN: not yet
        self.before = np.zeros((0, known.dimension))  # received at the end of the last accepted step
        self.interpolated = True  # in time; mean forces hold for the whole step

    def add(self, positions: np.ndarray) -> np.ndarray:
        values = np.atleast_2d(np.asarray(positions, dtype=float))
        if values.size == 0:
            values = values.reshape(0, self.known.dimension)
        if values.shape[1] != self.known.dimension:
            raise UsageError(f'mesh "{self.known.name}": found positions of shape '
                             f"{list(np.shape(positions))}, allowed: num_vertices x {self.known.dimension}")
        first = len(self.positions)
        self.positions = np.concatenate([self.positions, values])
        return np.arange(first, len(self.positions))

    def connect(self, count: int, vertices: np.ndarray) -> None:
        self.facets[count] += np.asarray(vertices, dtype=int).reshape(-1, count).tolist()

    def surface(self) -> np.ndarray | None:
        """Segments in the plane; triangles or quadrilaterals in space, whose edges say nothing more."""
        if self.known.dimension == 2:
            return np.array(self.facets[2]) if self.facets[2] else None
        if self.facets[3] and self.facets[4]:
            raise NotMapped(f'mesh "{self.known.name}": has triangles and quadrilaterals; allowed: one kind')
        return next((np.array(self.facets[count]) for count in (3, 4) if self.facets[count]), None)

    def places(self, vertex_ids: Any) -> np.ndarray:
        ids = np.atleast_1d(np.asarray(vertex_ids, dtype=int))
        if ids.size and not (0 <= ids.min() and ids.max() < len(self.positions)):
            raise UsageError(f'mesh "{self.known.name}": found vertex ids {ids.min()} to {ids.max()}, '
                             f"allowed: 0 to {len(self.positions) - 1}")
        return ids


class Participant:
    """Participant with the calls of precice.Participant, version 3, in the same order."""

    def __init__(self, solver_name: str, configuration_file_name: str, solver_process_index: int,
                 solver_process_size: int, communicator: Any = None) -> None:
        """communicator: not used, one process needs none."""
        if (solver_process_index, solver_process_size) != (0, 1):
            raise NotMapped(f"found process {solver_process_index} of {solver_process_size}, allowed: 0 of 1: "
                            "one process talks to the coupler; gather the values there")
        self._config = read_config(configuration_file_name, solver_name)
        self._meshes = {name: _Mesh(known) for name, known in self._config.meshes.items()}
        self._participant = OwnParticipant(ParticipantSettings(
            self._config.participant, endpoint(), self._config.dimension, receives=self._config.receives,
            program=os.path.basename(sys.argv[0]) or "python", exit_when_coupler_is_lost=False))
        self._initialized = False
        self._elapsed = 0.0  # [s] of the open step, by steps of the code's own

    # Steering

    def initialize(self) -> None:
        for mesh in self._meshes.values():
            self._participant.set_interface(mesh.known.interface, mesh.positions, mesh.surface())
            mesh.before = np.zeros_like(mesh.positions)
        self._participant.initialize()
        self._initialized = True
        if self._config.receives == "force":
            for mesh in self._meshes.values():
                mesh.interpolated = self._participant.force_kind(mesh.known.interface) == END_OF_STEP
        self._compare("max-time", self._config.max_time, "end")
        self._compare("time-window-size", self._config.window, "dt")

    def advance(self, computed_timestep_length: float) -> None:
        left = self._participant.get_max_time_step_size()
        window = left + self._elapsed
        ends = left - computed_timestep_length <= SAME_TIME * window
        received = {}
        if ends:
            received = {name: self._received(mesh) for name, mesh in self._meshes.items()}
            for mesh in self._meshes.values():
                self._participant.write_data(mesh.known.interface, self._complete(mesh))
        self._participant.advance(computed_timestep_length)
        for mesh in self._meshes.values():
            mesh.written = None
        self._elapsed = 0.0 if ends else self._elapsed + computed_timestep_length
        if ends and self._participant.is_time_window_complete():
            for name, mesh in self._meshes.items():
                mesh.before = received[name]

    def finalize(self) -> None:
        self._participant.finalize()

    # Questions

    def get_mesh_dimensions(self, mesh_name: str) -> int:
        return self._mesh(mesh_name).known.dimension

    def get_data_dimensions(self, mesh_name: str, data_name: str) -> int:
        known = self._mesh(mesh_name).known
        self._checked(known, {**known.reads, **known.writes}, data_name)
        return known.dimension

    def is_coupling_ongoing(self) -> bool:
        return self._participant.is_coupling_ongoing()

    def is_time_window_complete(self) -> bool:
        return self._participant.is_time_window_complete()

    def get_max_time_step_size(self) -> float:
        return self._participant.get_max_time_step_size()

    def requires_initial_data(self) -> bool:
        """Never: runs start from displacement 0, and the first values are those of the first iteration."""
        return False

    def requires_writing_checkpoint(self) -> bool:
        return self._participant.requires_writing_checkpoint()

    def requires_reading_checkpoint(self) -> bool:
        return self._participant.requires_reading_checkpoint()

    # Meshes

    def requires_mesh_connectivity_for(self, mesh_name: str) -> bool:
        return self._mesh(mesh_name).known.needs_connectivity

    def set_mesh_vertex(self, mesh_name: str, position: Any) -> int:
        return int(self._open_mesh("set_mesh_vertex", mesh_name).add(position)[0])

    def set_mesh_vertices(self, mesh_name: str, positions: Any) -> np.ndarray:
        return self._open_mesh("set_mesh_vertices", mesh_name).add(positions)

    def get_mesh_vertex_size(self, mesh_name: str) -> int:
        return len(self._mesh(mesh_name).positions)

    def set_mesh_edge(self, mesh_name: str, first_vertex_id: int, second_vertex_id: int) -> None:
        self.set_mesh_edges(mesh_name, [[first_vertex_id, second_vertex_id]])

    def set_mesh_edges(self, mesh_name: str, vertices: Any) -> None:
        self._open_mesh("set_mesh_edges", mesh_name).connect(2, vertices)

    def set_mesh_triangle(self, mesh_name: str, *vertex_ids: int) -> None:
        self.set_mesh_triangles(mesh_name, [vertex_ids])

    def set_mesh_triangles(self, mesh_name: str, vertices: Any) -> None:
        self._open_surface("set_mesh_triangles", mesh_name).connect(3, vertices)

    def set_mesh_quad(self, mesh_name: str, *vertex_ids: int) -> None:
        self.set_mesh_quads(mesh_name, [vertex_ids])

    def set_mesh_quads(self, mesh_name: str, vertices: Any) -> None:
        self._open_surface("set_mesh_quads", mesh_name).connect(4, vertices)

    # Data

    def read_data(self, mesh_name: str, data_name: str, vertex_ids: Any,
                  relative_read_time: float) -> np.ndarray:
        """Linear in time from the last accepted step to the end of the open one; mean forces of a step are
        constant."""
        mesh = self._mesh(mesh_name)
        self._checked(mesh.known, mesh.known.reads, data_name)
        left = self.get_max_time_step_size()
        window = left + self._elapsed
        slack = SAME_TIME * window
        if not -slack <= relative_read_time <= left + slack:
            raise UsageError(f"read_data: found relative_read_time {relative_read_time} s, "
                             f"allowed: 0 to {left} s")
        values = self._received(mesh)
        share = (self._elapsed + relative_read_time) / window
        if mesh.interpolated and share < 1 - SAME_TIME:
            values = (1 - share) * mesh.before + share * values
        return values[mesh.places(vertex_ids)]

    def write_data(self, mesh_name: str, data_name: str, vertex_ids: Any, values: Any) -> None:
        mesh = self._mesh(mesh_name)
        self._checked(mesh.known, mesh.known.writes, data_name)
        if not self._initialized:
            raise NotMapped("write_data before initialize(): there are no initial data, "
                            "requires_initial_data() is false")
        places = mesh.places(vertex_ids)
        array = np.asarray(values, dtype=float)
        if array.shape != (len(places), mesh.known.dimension):
            raise UsageError(f'write_data: found values of shape {list(array.shape)} for "{data_name}", '
                             f"allowed: {[len(places), mesh.known.dimension]}")
        if mesh.written is None:
            mesh.written = np.full_like(mesh.positions, np.nan)
        mesh.written[places] = array

    def requires_gradient_data_for(self, mesh_name: str, data_name: str) -> bool:  # noqa: ARG002
        return False

    def start_profiling_section(self, event_name: str) -> None:
        """Nothing: steps.csv has the times."""

    def stop_last_profiling_section(self) -> None:
        """Nothing."""

    # The functions below have no counterpart.

    def set_mesh_tetrahedron(self, *_: Any) -> None:
        raise NotMapped("set_mesh_tetrahedron: couples volumes; allowed: surfaces")

    def set_mesh_tetrahedra(self, *_: Any) -> None:
        raise NotMapped("set_mesh_tetrahedra: couples volumes; allowed: surfaces")

    def reset_mesh(self, *_: Any) -> None:
        raise NotMapped("reset_mesh: a surface keeps its vertices for the whole run")

    def write_gradient_data(self, *_: Any) -> None:
        raise NotMapped("write_gradient_data: no mapping uses gradients; "
                        "requires_gradient_data_for() is false")

    def map_and_read_data(self, *_: Any) -> None:
        raise NotMapped("map_and_read_data: allowed: read_data at the vertices of set_mesh_vertices")

    def write_and_map_data(self, *_: Any) -> None:
        raise NotMapped("write_and_map_data: allowed: write_data at the vertices of set_mesh_vertices")

    def set_mesh_access_region(self, *_: Any) -> None:
        raise NotMapped("set_mesh_access_region: the meshes of other participants are not seen")

    def get_mesh_vertex_ids_and_coordinates(self, *_: Any) -> None:
        raise NotMapped("get_mesh_vertex_ids_and_coordinates: the meshes of other participants are not seen")

    # Help

    def _mesh(self, name: str) -> _Mesh:
        if name not in self._meshes:
            raise UsageError(f'found mesh "{name}", allowed: {", ".join(self._meshes)}, as provided in '
                             f"{self._config.path}")
        return self._meshes[name]

    def _open_mesh(self, call: str, name: str) -> _Mesh:
        if self._initialized:
            raise UsageError(f"{call}: allowed before initialize() only")
        return self._mesh(name)

    def _open_surface(self, call: str, name: str) -> _Mesh:
        mesh = self._open_mesh(call, name)
        if mesh.known.dimension == 2:
            raise NotMapped(f"{call}: couples volumes in 2D; allowed: edges, which are the surface")
        return mesh

    def _checked(self, known: CoupledMesh, data: dict[str, str], name: str) -> None:
        if name not in data:
            raise UsageError(f'found data "{name}" of mesh "{known.name}", allowed here: '
                             f'{", ".join(data) or "none"}, as in {self._config.path}')

    def _received(self, mesh: _Mesh) -> np.ndarray:
        return self._participant.read_data(mesh.known.interface)

    def _complete(self, mesh: _Mesh) -> np.ndarray:
        """The values written since the last advance(), of every vertex."""
        if mesh.written is None or np.isnan(mesh.written).any():
            raise UsageError(f'advance: values of mesh "{mesh.known.name}" are missing or not a number; '
                             "allowed: write_data for all vertices before each advance")
        return mesh.written

    def _compare(self, element: str, found: float | None, key: str) -> None:
        """Warn where a setting of the file differs from that of the run."""
        ours = self._participant.run_settings().get(key)
        if found is not None and ours is not None and found != ours:
            warnings.warn(f"{element} is {found:g} s in {self._config.path}, {key} is {ours:g} s in "
                          "coupler.json, which decides", stacklevel=3)


def main() -> None:
    """Run an adapter whose `import precice` then finds this module."""
    arguments = sys.argv[1:]
    if "--coupler" in arguments[:-1]:
        place = arguments.index("--coupler")
        os.environ[ENDPOINT] = arguments[place + 1]
        del arguments[place:place + 2]
    if not arguments or arguments[0].startswith("-"):
        sys.exit("usage: python3 -m gabion_participant.precice_names ADAPTER.py [ARGUMENT]... "
                 "--coupler tcp://host:port")
    import gabion_participant.precice_names as names  # noqa: PLC0415: the module under its name, not __main__
    sys.modules["precice"] = names
    sys.argv = arguments
    sys.path.insert(0, os.path.dirname(os.path.abspath(arguments[0])))
    runpy.run_path(arguments[0], run_name="__main__")


if __name__ == "__main__":
    main()
