# SPDX-License-Identifier: BSD-3-Clause
"""A results folder of a run that never was: known numbers in the format of the programs."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

END, DT = 0.5, 1e-3
STEPS = round(END / DT)
AMPLITUDE = 2e-3  # of the probe [m]
CONTACT = 0.15  # [s], from then on the soil is in contact with the structure
FORCE = 20.0  # of the soil on the structure since then [N/m]

SECONDS = ["soil.busy_seconds", "soil.message_seconds", "structure.busy_seconds", "structure.message_seconds",
           "acceleration_seconds"]


def seconds(contact: bool) -> list[float]:
    """Wall times of a step, in the order of SECONDS."""
    return [5e-3, 1e-3, 1e-3, 1e-3, 1e-3] if contact else [7e-3, 1e-3, 0.0, 1e-3, 0.0]


def write_table(path: Path, head: list[str], rows: list[list]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *rows])


def displacement(time: float, scale: float = 1.0) -> float:
    return scale * AMPLITUDE * max(0.0, 1 - np.cos(40 * (time - CONTACT))) * (time > CONTACT)


def write_tables(folder: Path, scale: float, iterations: int) -> None:
    """probes.csv, steps.csv (force FORCE from CONTACT on), iterations.csv (residual 10^-k)."""
    times = [DT * step for step in range(STEPS + 1)]
    write_table(folder / "probes.csv", ["time", "soil.centre_x", "structure.A.ux", "structure.A.uy"],
                [[t, 0.1 + t / 10, displacement(t, scale), -displacement(t, 0.1 * scale)] for t in times])
    contact = {t: t > CONTACT for t in times[1:]}
    write_table(folder / "steps.csv",
                ["step", "time", "dt", "iterations", "status", "skipped", "displacement_residual",
                 "force_residual", "fx", "fy", "soil_newton", "structure_newton", "cuts",
                 "soil.kinetic_energy", *SECONDS, "wall_seconds"],
                [[n + 1, t, DT, iterations if contact[t] else 1, "converged" if contact[t] else "inactive",
                  "none" if contact[t] else "structure", 1e-9, 1e-6, scale * FORCE * contact[t], 0.0,
                  4, 1, 0, 5 * t * (1 - t), *seconds(contact[t]), 0.01] for n, t in enumerate(times[1:])])
    count = {t: iterations if contact[t] else 1 for t in times[1:]}
    rows = [[n + 1, k, t - DT, DT, "converged" if k + 1 == count[t] else "going_on", 10.0 ** -(k + 4), 2e-8,
             10.0**-k if k else "", 2e-4, 0.5, k, 1 if k else 3, 1e-3 if k else 2e-3, 2e-3]
            for n, t in enumerate(times[1:]) for k in range(count[t])]
    write_table(folder / "iterations.csv",
                ["step", "iteration", "time", "dt", "status", "displacement_residual", "displacement_limit",
                 "force_residual", "force_limit", "omega", "columns", "soil_newton", "soil_seconds", "wall_seconds"],
                rows)


def write_frame(path: Path, points: np.ndarray, cells: np.ndarray | None, fields: dict) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        file["coordinates"] = points
        if cells is not None:
            file["connectivity"] = cells
        for name, values in fields.items():
            file[name] = values


def xdmf_item(file: str, name: str, array: np.ndarray) -> str:
    size = " ".join(str(n) for n in array.shape)
    return f'<DataItem Format="HDF" Dimensions="{size}">{file}:/{name}</DataItem>'


ON_CELLS = ("stress",)  # of structures


def stresses(time: float, tension: np.ndarray) -> dict[str, np.ndarray]:
    """Uniaxial tension [Pa] of each cell along y, growing with the time, as the frames hold it."""
    return {"stress": np.outer(time * tension, [0, 0, 0, 1, 0, 0])}


def write_series(folder: Path, name: str, frames: list[tuple]) -> None:
    """frames: (time, points, cells or None, fields)."""
    grids = []
    for number, (time, points, cells, fields) in enumerate(frames):
        file = f"{name}_{number:06d}.h5"
        write_frame(folder / file, points, cells, fields)
        kind = "Polyvertex" if cells is None else {2: "Polyline", 3: "Triangle", 4: "Quadrilateral",
                                                   8: "Hexahedron"}[cells.shape[1]]
        topology = "" if cells is None else xdmf_item(file, "connectivity", cells)
        attributes = "".join(
            f'<Attribute Name="{field}" Center="{"Cell" if field in ON_CELLS else "Node"}">'
            f'{xdmf_item(file, field, values)}</Attribute>'
            for field, values in fields.items()
        )
        grids.append(
            f'<Grid Name="{name}"><Time Value="{time}"/>'
            f'<Topology TopologyType="{kind}">{topology}</Topology>'
            f'<Geometry GeometryType="{"XYZ"[:points.shape[1]]}">'
            f'{xdmf_item(file, "coordinates", points)}</Geometry>'
            f"{attributes}</Grid>"
        )
    text = "".join(grids)
    (folder / f"{name}.xdmf").write_text(
        f'<Xdmf Version="3.0"><Domain><Grid GridType="Collection" CollectionType="Temporal">{text}</Grid>'
        "</Domain></Xdmf>"
    )


def soil_frames() -> list[tuple]:
    """A column 0.2 m x 0.1 m that is sheared, linearly in height and time."""
    x, y = np.meshgrid(np.arange(0.00125, 0.2, 0.0025), np.arange(0.00125, 0.1, 0.0025))
    start = np.column_stack([x.ravel(), y.ravel()])
    frames = []
    for time in np.linspace(0, END, 6):
        u = np.column_stack([0.8 * time * start[:, 1], np.zeros(len(start))])
        frames.append((time, start + u, None, {"displacement": u, "plastic_strain": u[:, 0]}))
    return frames


def structure_frames() -> list[tuple]:
    """A wall 0.01 m x 0.05 m of 2 x 10 cells that bends."""
    x, y = np.meshgrid(np.linspace(0.25, 0.26, 3), np.linspace(0, 0.05, 11))
    points = np.column_stack([x.ravel(), y.ravel()])
    corner = (np.arange(10)[:, None] * 3 + np.arange(2)[None]).ravel()
    cells = np.column_stack([corner, corner + 1, corner + 4, corner + 3])
    frames = []
    for time in np.linspace(0, END, 6):
        u = np.column_stack([4 * time * points[:, 1] ** 2, np.zeros(len(points))])
        frames.append((time, points + u, cells, {"displacement": u, **stresses(time, np.arange(20) * 1e3)}))
    return frames


def write_contact(folder: Path, name: str = "wall", first: int = 2) -> Path:
    """Pressure 1000 (1 - y / 0.1 m) t on the upright line x = 0.25 m + t / 10.

    It begins in frame `first`; before, the gap is NaN. Facets of 0.01 m, written from the top down and one of them out
    of order.
    """
    y = np.linspace(0.1, 0, 11)
    cells = np.column_stack([np.arange(10), np.arange(1, 11)])[[1, 0, *range(2, 10)]]
    middle = y[cells].mean(axis=1)
    frames = []
    for number, time in enumerate(np.linspace(0, END, 6)):
        points = np.column_stack([np.full(11, 0.25 + time / 10), y, np.zeros(11)])
        touched = number >= first
        frames.append((time, points, cells, {"pressure": 1000 * (1 - middle / 0.1) * time * touched,
                                             "gap": np.full(10, 0.0 if touched else np.nan)}))
    write_series(folder / "mpm", f"contact_{name}", frames)
    return folder


def write_results(folder: Path, scale: float = 1.0, iterations: int = 5) -> Path:
    """A whole results folder. scale multiplies displacement and force."""
    write_tables(folder, scale, iterations)
    write_series(folder / "mpm", "soil", soil_frames())
    write_series(folder / "fem", "structure", structure_frames())
    summary = {"program": "coupler", "completed": True, "end_time": END, "steps": STEPS, "cuts": 0,
               "coupling_iterations": {"mean_in_contact": iterations, "max": iterations},
               "wall_seconds": {"total": 12.5},
               "participants": {name: {"cpu_seconds": {"largest_rank": cpu, "all_ranks": cpu},
                                       "output_cpu_seconds": {"largest_rank": 0.1, "all_ranks": 0.1}}
                                for name, cpu in (("soil", 8.0), ("structure", 2.0))}}
    (folder / "summary.json").write_text(json.dumps(summary))
    return folder


def write_rigid_walls(folder: Path) -> Path:
    """Add rigid walls to results in 2D: a bed at rest, longer than the scene, and a lid that falls 0.1 m/s and is
    dropped at 0.25 s."""
    bed, lid = [], []
    cells = np.array([[1, 2], [0, 1]])  # out of order
    for time in np.linspace(0, END, 6):
        bed.append((time, np.array([[9.0, 0, 0], [0.1, 0, 0], [-9, 0, 0]]), cells, {"pressure": np.zeros(2)}))
        height = 0.2 - 0.1 * time
        lid.append((time, np.array([[0, height, 0], [0.1, height, 0], [0.2, height, 0]]), cells,
                    {"pressure": np.zeros(2)}))
    write_series(folder / "mpm", "contact_bed", bed)
    write_series(folder / "mpm", "contact_lid", lid)
    (folder / "mpm" / "resolved_config.json").write_text(json.dumps({"mpm.json": {
        "dimension": 2, "gravity": [0, -9.81], "rigid_walls": [{"name": "bed"}, {"name": "lid"}],
        "phases": [{"until": 0.25}, {"rigid_walls": ["bed"]}]}}))
    return folder


def boulder_frames(dim: int) -> list[tuple]:
    """A square or cube of edge 0.02 m that flies 0.2 m/s along x and turns by 2 rad/s: about z; in space about x, y
    and z alike."""
    if dim == 2:
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.01
        cells, axis = np.array([[2, 3], [0, 1], [1, 2], [3, 0]]), np.array([0, 0, 1])
    else:
        corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) * 0.01
        cells = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]])
        axis = np.ones(3) / np.sqrt(3)
    frames = []
    for time in np.linspace(0, END, 6):
        angle, k = 2 * time, np.cross(np.eye(3), axis).T  # Rodrigues
        turn = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
        place = np.array([0.05 + 0.2 * time, 0.02, 0.13 if dim == 3 else 0])
        frames.append((time, corners @ turn.T + place, cells, {"pressure": np.zeros(len(cells))}))
    return frames


def write_boulder(folder: Path, dim: int) -> Path:
    """Add a boulder "block" to results, in space a rigid wall "bed" too, a square of 2 m at z = 0.

    In 2D soil and structure are written anew with z = 0, as the programs do.
    """
    write_series(folder / "mpm", "contact_block", boulder_frames(dim))
    if dim == 2:
        for place, frames in (("mpm/soil", soil_frames()), ("fem/structure", structure_frames())):
            flat = [(time, np.pad(points, ((0, 0), (0, 1))), *rest) for time, points, *rest in frames]
            write_series((folder / place).parent, place.split("/")[1], flat)
    settings = {"dimension": dim, "gravity": [0, -9.81, 0][:2] if dim == 2 else [0, 0, -9.81],
                "boulders": [{"name": "block"}]}
    if dim == 3:
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
        write_series(folder / "mpm", "contact_bed",
                     [(0.0, corners, np.array([[0, 1, 2, 3]]), {"pressure": np.zeros(1)})])
        settings["rigid_walls"] = [{"name": "bed", "surface": {"mesh": {"file": "bed.msh"}, "groups": ["top"]}}]
    (folder / "mpm" / "resolved_config.json").write_text(json.dumps({"mpm.json": settings}))
    return folder


KINDS = ("finished", "cut", "failed", "stopped", "unfinished", "killed")
REASON = 'step 501 at 0.5 s: dt would become 5e-07 s; participant "soil": <no> solution & no "end"'


def write_kind(folder: Path, kind: str) -> Path:
    """A results folder of a run that ended in one of KINDS, or did not."""
    write_results(folder)
    summary = json.loads((folder / "summary.json").read_text())
    lines = []
    if kind == "cut":
        add_cut(folder)
        summary["cuts"] = 3
        lines = [f"[cpl] warning: step 251 at 0.25 s: dt cut from {DT} to {DT / 2} s: {reason}" for reason in (
            *(f'participant "soil": Newton, iteration {k}: iteration limit reached; worst grid node {k} at (0.1, 0.2)'
              for k in (20, 21)), "the residual grows")]
    if kind in ("failed", "stopped"):
        summary |= {"completed": False,
                    "reason": REASON if kind == "failed" else "interrupted by signal 15 (Terminated)"}
    if kind == "stopped":
        (folder / "checkpoints" / "step_000500").mkdir(parents=True)
        (folder / "checkpoints" / "step_000500" / "manifest.json").write_text("{}")
    if kind in ("unfinished", "killed"):
        (folder / "summary.json").unlink()
        pid = os.getpid() if kind == "unfinished" else pid_of_the_dead()
        lines = [f'[cpl] participant "soil" ({Path(sys.executable).name}, pid {pid}) is here']
        with (folder / "steps.csv").open("a", encoding="utf-8") as file:
            file.write("501,0.5")  # a row that is half written
    else:
        (folder / "summary.json").write_text(json.dumps(summary))
    (folder / "coupler.log").write_text("".join(f"2026-01-01 00:00:00.000 {line}\n" for line in lines))
    (folder / "resolved_config.json").write_text(json.dumps({"coupler.json": {
        "time": {"end": 2 * END if kind in ("unfinished", "killed") else END, "dt": DT},
        "coupling": {"scheme": "serial_implicit"},
        "interfaces": [{"name": "wall", "soil": "soil", "structure": "structure"}]}}))
    if kind == "killed":
        for path in folder.rglob("*"):
            os.utime(path, (0, 1e9))
    return folder


def add_cut(folder: Path) -> None:
    """Step 251 was cut three times: its first iterations stand in iterations.csv once more, and diverged."""
    steps = list(csv.reader((folder / "steps.csv").read_text(encoding="utf-8").splitlines()))
    steps[251][steps[0].index("cuts")] = "3"
    write_table(folder / "steps.csv", steps[0], steps[1:])
    rows = list(csv.reader((folder / "iterations.csv").read_text(encoding="utf-8").splitlines()))
    first = next(k for k, row in enumerate(rows) if row[0] == "251")
    tried = [list(row) for row in rows[first:first + 2]]
    tried[1][rows[0].index("status")] = "diverged"
    write_table(folder / "iterations.csv", rows[0], rows[1:first] + tried * 3 + rows[first:])


def pid_of_the_dead() -> int:
    """Number of a process that has ended."""
    ended = subprocess.Popen(["true"])
    ended.wait()
    return ended.pid


def space_frames(up: int) -> tuple[list[tuple], list[tuple]]:
    """Soil and wall of a slice 0.02 m thick in space: the frames above, y laid along axis `up`, 1 or 2."""
    def lay(flat: np.ndarray, depth: float) -> np.ndarray:
        points = np.full((len(flat), 3), depth)
        points[:, 0], points[:, up] = flat.T
        return points

    soil, wall = [], []
    for time, points, _, fields in soil_frames():
        u = np.vstack([lay(fields["displacement"], 0.0)] * 2)
        soil.append((time, np.vstack([lay(points, 0.005), lay(points, 0.015)]), None, {"displacement": u}))
    for time, points, cells, fields in structure_frames():
        u = np.vstack([lay(fields["displacement"], 0.0)] * 2)
        back = cells + len(points)
        # A right-handed cell has its lower face first: x, up, depth are a left-handed triple when up is z.
        cells = np.hstack([cells, back] if up == 1 else [back, cells])
        wall.append((time, np.vstack([lay(points, 0.0), lay(points, 0.02)]), cells,
                     {"displacement": u, "stress": fields["stress"]}))
    return soil, wall


def write_space_results(folder: Path, up: int = 2, gravity: float | None = -9.81) -> Path:
    """A results folder of a run in space. gravity: along axis `up`, None: no settings at all."""
    write_tables(folder, 1.0, 5)
    times = [DT * step for step in range(STEPS + 1)]
    rows = [[t, displacement(t), 1e-9 * displacement(t), -displacement(t, 0.1)] for t in times]
    write_table(folder / "probes.csv", ["time", "structure.A.ux", "structure.A.uy", "structure.A.uz"], rows)
    soil, wall = space_frames(up)
    write_series(folder / "mpm", "soil", soil)
    write_series(folder / "fem", "structure", wall)
    if gravity is not None:
        vector = [gravity * (axis == up) for axis in range(3)]
        for program in ("mpm", "fem"):
            settings = {f"{program}.json": {"dimension": 3, "gravity": vector}}
            (folder / program / "resolved_config.json").write_text(json.dumps(settings))
    (folder / "resolved_config.json").write_text(json.dumps({"coupler.json": {"time": {"end": END}}}))
    return folder


def write_beams(folder: Path) -> Path:
    """The slice in space with a structure of one beam, which has no cells but a line, and the soil's copy of the
    surface around it, which moves 1 m/s along x."""
    write_space_results(folder)
    axis = np.array([[0.25, 0.01, 0.0], [0.25, 0.01, 0.05]])
    ring = np.array([[0.255, 0.005], [0.255, 0.015], [0.245, 0.015], [0.245, 0.005]])
    corners = np.array([[*xy, z] for z in (0.0, 0.05) for xy in ring])
    cells = np.array([[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)])
    times = np.linspace(0, END, 6)
    write_series(folder / "fem", "structure", [
        (time, axis, np.zeros((0, 8), int), {"displacement": 0 * axis}) for time in times])
    write_series(folder / "fem", "lines", [(time, axis, np.array([[0, 1]]), {}) for time in times])
    write_series(folder / "mpm", "contact_posts", [
        (time, corners + [time, 0, 0], cells, {"pressure": np.zeros(4)}) for time in times])
    (folder / "fem" / "resolved_config.json").write_text(json.dumps({"fem.json": {"interfaces": [
        {"name": "posts", "beams": ["post"]}, {"name": "wall", "groups": ["front"]}]}}))
    return folder
