# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces in contact with soil, each by itself: moment about its own foot, pressure over the height of its upright
faces."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plotting.faces import Face, faces_of
from plotting.results import Frame, Results, Series
from plotting.view import AXES, up_axis


@dataclass(frozen=True)
class Loads:
    """Force and moment of the soil on a surface over time, components x dim and x 1 or 3, the moment about `about`
    [m]."""

    name: str
    time: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    about: np.ndarray

    def moment_about(self, place: np.ndarray) -> np.ndarray:
        """Moment about another place [N m]."""
        arm = place - self.about
        if len(arm) == 2:
            return self.moment - (arm[0] * self.force[:, 1] - arm[1] * self.force[:, 0])[:, None]
        return self.moment - np.cross(arm, self.force)


def moment_places(results: Results) -> dict[str, np.ndarray]:
    """Name of an interface or rigid wall -> the place about which the tables give its moment [m]."""
    origin = [0.0] * results.dim
    entries = [*results.settings("coupler.json").get("interfaces", []),
               *results.settings("mpm.json").get("rigid_walls", [])]
    return {each["name"]: np.array(each.get("moment_about") or origin, dtype=float)[:results.dim]
            for each in entries if "name" in each}


def all_loads(results: Results) -> list[Loads]:
    """Loads of the interfaces, then of the rigid walls, as far as the tables have force and moment of them."""
    dim = results.dim
    turning = ("mz",) if dim == 2 else ("mx", "my", "mz")
    places = moment_places(results)
    found = []
    for table in (results.table("steps.csv"), results.table("probes.csv")):
        if table is None or not table.num_rows:
            continue
        for prefix in dict.fromkeys(name.rpartition(".")[0] for name in table.names if name.endswith(".mz")):
            name = prefix.rpartition(".")[2]
            columns = [f"{prefix}.f{axis}" for axis in AXES[:dim]], [f"{prefix}.{axis}" for axis in turning]
            if name in places and all(column in table for column in (*columns[0], *columns[1])):
                force, moment = (np.column_stack([table[column] for column in group]) for group in columns)
                found.append(Loads(name, table["time"], force, moment, places[name]))
    return found


def foot_of(frame: Frame, up: int, dim: int) -> np.ndarray:
    """Middle of the lowest points of a surface [m]."""
    points = frame.points[np.unique(frame.cells)]
    height = points[:, up]
    lowest = points[height <= height.min() + 1e-6 * max(float(np.ptp(points, axis=0).max()), 1e-12)]
    return ((lowest.min(axis=0) + lowest.max(axis=0)) / 2)[:dim]


def moments(results: Results) -> list[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Surface, time, moment about its own foot, the foot; of surfaces with frames and any moment, but not of beds."""
    up, contacts, found = up_axis(results.dim, results.gravity), loaded_surfaces(results), []
    for loads in all_loads(results):
        if loads.name not in contacts:
            continue
        foot = foot_of(contacts[loads.name].frame(0), up, results.dim)
        moment = loads.moment_about(foot)
        if np.any(moment != 0):
            found.append((loads.name, loads.time, moment, foot))
    return found


@lru_cache(maxsize=2)
def upright_faces(results: Results) -> list[Face]:
    """Faces of interfaces and rigid walls, but not those of the ground."""
    up, ground = up_axis(results.dim, results.gravity), grounds(results)
    return [face for name, series in results.surfaces.items() if len(series) and name not in ground
            for face in faces_of(name, series, results.dim, up)]


def touched_faces(results: Results) -> list[Face]:
    """Of these, those that soil pressed on."""
    return [face for face in upright_faces(results) if np.nanmax(face.pressure, initial=0) > 0]


def grounds(results: Results) -> set[str]:
    """Rigid walls that are terrain."""
    return {wall["name"] for wall in results.settings("mpm.json").get("rigid_walls", [])
            if "triangles" in wall.get("surface", {})}


def rigid_walls(results: Results) -> set[str]:
    return {wall["name"] for wall in results.settings("mpm.json").get("rigid_walls", []) if "name" in wall}


def loaded_surfaces(results: Results) -> dict[str, Series]:
    """Name -> frames of the interfaces, and of those rigid walls that stand upright and had soil on their faces, or
    may have had a pool: a bed is none."""
    by_pools = bool(results.settings("mpm.json").get("pools"))  # frames of a surface have no pressure of pools
    touched = {face.surface for face in (upright_faces if by_pools else touched_faces)(results)}
    rigid, ground = rigid_walls(results), grounds(results)
    return {name: series for name, series in results.surfaces.items() if len(series) and name not in ground
            and (name not in rigid or name in touched)}
