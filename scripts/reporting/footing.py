# SPDX-License-Identifier: BSD-3-Clause
"""Sliding and overturning of structures by the reaction and the moment of their held footings."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from plotting.results import Results, Series, Table
from plotting.view import AXES, up_axis

FLAT = 1e-6  # height of an underside over the size of its structure
WEIGHTLESS = 1e-6  # upward reaction that is round-off, over the largest reaction of the run
HELD = 1e-6  # movement of its nodes relative to each other over the largest one of the structure


@dataclass(frozen=True)
class Underside:
    """Outline of the lowest nodes of a structure, in the plan. normals, offsets: n . x <= c holds within it, with its
    middle at x = 0; size: its extent along each axis of the plan [m]."""

    normals: np.ndarray
    offsets: np.ndarray
    size: np.ndarray

    def reach(self, places: np.ndarray) -> np.ndarray:
        """Distance from the middle to the outline, over that of each place in the same direction; inf in the middle.

        places: num_places x (1 or 2).
        """
        share = places @ self.normals.T / self.offsets
        most = share.max(axis=1)
        return np.where(most > 0, 1 / np.where(most > 0, most, 1), np.inf)


@dataclass(frozen=True)
class Held:
    """Reaction of a held group over time, on the structure: upward [N], 2D [N/m]; across: num_times x (dim - 1).

    resultant: where it acts in the plan, from the middle of the group [m], None: no moment is reported. Only times with
    upward > 0 have a place.
    """

    label: str
    owner: str
    time: np.ndarray
    upward: np.ndarray
    across: np.ndarray
    resultant: np.ndarray | None


def plan_axes(dim: int, up: int) -> list[int]:
    return [axis for axis in range(dim) if axis != up]


def held_groups(results: Results, table: Table) -> list[Held]:
    """Groups of supports whose reaction is reported."""
    dim, up = results.dim, up_axis(results.dim, results.gravity)
    sign = -1.0 if results.gravity and results.gravity[up] > 0 else 1.0
    found = []
    for column in [name for name in table.names if "reaction_" in name and name.endswith("_x")]:
        owner, _, leaf = column.rpartition(".")
        names = [f"{column[:-2]}_{axis}" for axis in AXES[:dim]]
        if not leaf.startswith("reaction_") or not all(name in table for name in names):
            continue
        group = leaf.removeprefix("reaction_")[:-2]
        force = np.column_stack([table[name] for name in names])
        upward = sign * force[:, up]
        label = f"{owner}.{group}" if owner else group
        turning = [f"{owner}.".lstrip(".") + f"moment_{group}_{axis}" for axis in ("z" if dim == 2 else AXES)]
        place = None
        if all(name in table for name in turning):
            moment = np.zeros((table.num_rows, 3))
            moment[:, 3 - len(turning):] = np.column_stack([table[name] for name in turning])
            # M = e x (V u) with e in the plan: e = u x M / V, of the part of M about axes in the plan
            direction = sign * np.eye(3)[up]
            arms = np.cross(direction, moment) / np.where(upward > 0, upward, np.nan)[:, None]
            place = arms[:, plan_axes(dim, up)]
        found.append(Held(label, owner, table["time"], upward, force[:, plan_axes(dim, up)], place))
    return found


def structure_of(results: Results, owner: str) -> Series | None:
    """Frames of the participant `owner`; None: it cannot be told which."""
    series = results.structures
    if len(series) == 1:
        return series[0]
    named = [each for each in series if each.path.parent.name == owner]
    return named[0] if len(named) == 1 else None


def underside_of(series: Series, up: int, dim: int, upwards: float = 1.0) -> Underside | None:
    """Outline of the lowest nodes before loading; None where these are no flat underside, or not held: they move
    relative to each other until the last frame."""
    points = series.frame(0).points[:, :dim]
    height = upwards * points[:, up]
    is_low = height <= height.min() + FLAT * float(np.ptp(points, axis=0).max())
    moved = series.frame(len(series) - 1).points[:, :dim] - points
    if np.ptp(moved[is_low], axis=0).max() > HELD * np.abs(moved).max():
        return None
    lowest = points[is_low][:, plan_axes(dim, up)]
    size = np.ptp(lowest, axis=0)
    if not np.all(size > FLAT * np.ptp(points, axis=0).max()):
        return None
    if dim == 2:
        half = size[0] / 2
        return Underside(np.array([[1.0], [-1.0]]), np.array([half, half]), size)
    try:
        hull = ConvexHull(lowest)
    except QhullError:
        return None
    corners = lowest[hull.vertices]
    triangles = np.array([[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)])
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    middle = area @ triangles.mean(axis=1) / area.sum()
    return Underside(hull.equations[:, :2], -(hull.equations[:, 2] + hull.equations[:, :2] @ middle), size)


def stability(results: Results, friction: float | None = None) -> list[tuple[str, str]]:
    """Rows on sliding, overturning and uplift of each held group whose moment is reported; with a friction, of all.

    friction: coefficient under the footings, None: not known.
    """
    table = results.table("probes.csv")
    if table is None or not table.num_rows:
        return []
    rows = []
    for held in held_groups(results, table):
        if held.resultant is None and friction is None:
            continue
        force = np.hypot(held.upward, np.linalg.norm(held.across, axis=1))
        least = WEIGHTLESS * force.max()
        pressed, lifted = held.upward > least, held.upward < -least
        bare = ~pressed & ~lifted & (force > least)
        if lifted.any():
            rows.append((f"uplift of {held.label}",
                         f"pulled up first at {held.time[np.argmax(lifted)]:.4g} s, when neither friction nor weight "
                         "holds it"))
        if bare.any():
            rows.append((f"weight on {held.label}",
                         f"no weight on the footing, first at {held.time[np.argmax(bare)]:.4g} s: nothing but its "
                         "supports holds it, friction and weight do not"))
        if pressed.any():
            rows.append((f"sliding of {held.label}", sliding(held, pressed, friction)))
        if pressed.any() and held.resultant is not None:
            rows.append((f"overturning of {held.label}", overturning(results, held, pressed)))
    return rows


def sliding(held: Held, pressed: np.ndarray, friction: float | None) -> str:
    """Friction that holds the footing, and the safety that a given friction has; over the times of `pressed`."""
    slope = np.linalg.norm(held.across, axis=1)[pressed] / held.upward[pressed]
    k = int(np.argmax(slope))
    words = (f"needs a friction coefficient of {slope[k]:.4g} at {held.time[pressed][k]:.4g} s, {slope[-1]:.4g} at the "
             "end")
    if friction is None:
        return f"{words}; --base-friction gives the safety"
    if slope[k] == 0:
        return f"{words}; nothing pushes it"
    last = f"{friction / slope[-1]:.4g}" if slope[-1] > 0 else "without bound"
    return f"safety {friction / slope[k]:.4g} with friction {friction:g}, {last} at the end; {words}"


def overturning(results: Results, held: Held, pressed: np.ndarray) -> str:
    """Where the resultant acts and, where the outline of the underside is known, the safety: distance of its edge over
    that of the resultant from its middle, which equals the moment of the upward reaction about that edge over the
    moment that turns it."""
    time, place = held.time[pressed], held.resultant[pressed]
    far = np.linalg.norm(place, axis=1)
    up = up_axis(results.dim, results.gravity)
    series = structure_of(results, held.owner)
    upwards = -1.0 if results.gravity and results.gravity[up] > 0 else 1.0
    below = underside_of(series, up, results.dim, upwards) if series is not None else None
    if below is None:
        n = int(np.argmax(far))
        return (f"resultant {far[n]:.4g} m from the middle at {time[n]:.4g} s, {far[-1]:.4g} m at the end; no safety: "
                "the frames show no flat, held underside of its structure")
    reach = below.reach(place)
    n = int(np.argmin(reach))
    size = " by ".join(f"{each:.4g}" for each in below.size)
    words = (f"resultant {far[n]:.4g} m from the middle at {time[n]:.4g} s, {far[-1]:.4g} m at the end, of an "
             f"underside of {size} m, the lowest nodes of the structure")
    if results.dim == 2:
        words += "; it gapes beyond a sixth of the width"
    if not np.isfinite(reach[n]):
        return f"{words}; nothing turns it"
    last = f"{reach[-1]:.4g}" if np.isfinite(reach[-1]) else "without bound"
    return f"safety {reach[n]:.4g} at {time[n]:.4g} s, {last} at the end: {words}"
