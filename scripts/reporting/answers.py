# SPDX-License-Identifier: BSD-3-Clause
"""What is asked of a run first, as numbers: factor of safety, displacements, forces, moments, pressures, run-up,
passed mass, stability."""

import re

import numpy as np

from plotting.history import FORCES, SECTION, boulder_parts, displacement_columns, is_rigid_wall, probe_points
from plotting.results import Results, Table, gauge_names
from plotting.strength import strength_search
from plotting.view import AXES, up_axis

from .surfaces import moments, touched_faces

# Columns of fem_solver about lines, metal and concrete: what they are called, their units, whether these are per metre
# in 2D, and of which values the largest one is asked: of the sizes, of the values, or of these with the other sign.
MEMBERS = {"axial_max": ("largest axial force in the lines of", "N", True, np.positive),
           "axial_min": ("least axial force in the lines of", "N", True, np.negative),
           "stress_max": ("largest stress in the bars of", "Pa", False, np.positive),
           "stress_min": ("least stress in the bars of", "Pa", False, np.negative),
           "brake_run": ("largest run of a brake of", "m", False, np.abs),
           "plastic_strain": ("largest plastic strain of", "", False, np.abs),
           "crack_width": ("widest crack of", "m", False, np.abs),
           "damage_work": ("work of cracks and crushing of", "J", True, np.abs)}
# A participant has no dot in its name, a group may have some.
MEMBER = re.compile(rf"(?:(?P<who>[^.]+)\.)?(?P<of>{'|'.join(MEMBERS)})(?:_(?P<group>.+))?$")
Row = tuple[str, str]  # what is asked, answer


def answers(results: Results) -> list[Row]:
    """Rows in the order in which they are asked; what a run does not have is left out."""
    return [*safety(results), *displacements(results), *forces(results), *boulder_forces(results),
            *base_moments(results), *pressures(results), *members(results), *gauges(results), *stability(results)]


def safety(results: Results) -> list[Row]:
    """Factor of safety of a slope, of a run that searched for it."""
    search = strength_search(results.summary)
    return [("factor of safety", search)] if search else []


def number(value: float, unit: str) -> str:
    return f"{value + 0.0:.4g} {unit}".rstrip()  # + 0.0: no sign of a zero


def peak(time: np.ndarray, values: np.ndarray, unit: str, measure: np.ufunc = np.abs) -> str | None:
    """Value with the largest measure, with its time, and last value; None: without any number, or all zero."""
    known = np.isfinite(values)
    if not known.any() or not np.any(values[known] != 0):
        return None
    k = int(np.nanargmax(measure(values)))
    return f"{number(values[k], unit)} at {time[k]:.4g} s; at the end {number(values[known][-1], unit)}"


def displacements(results: Results) -> list[Row]:
    """Displacement of each probed point of a structure, by component; those that are round-off of the largest are left
    out."""
    table = results.table("probes.csv")
    if table is None or not table.num_rows:
        return []
    rows = []
    for point in probe_points(table):
        columns = displacement_columns(table, point)
        least = 1e-6 * max(float(np.nanmax(np.abs(table[each]), initial=0)) for each in columns)
        for column in columns:
            text = peak(table["time"], table[column], "m")
            if text and np.nanmax(np.abs(table[column])) > least:
                rows.append((f"displacement {column}", text))
    return rows


def forces(results: Results) -> list[Row]:
    """Force on the structure with its impulse, and on each of several surfaces."""
    table, unit = results.table("steps.csv"), results.per_metre
    if table is None or not table.num_rows:
        return []
    rows = []
    whole = [name for name in FORCES if name in table]
    parts = [name for name in table.names if name.rpartition(".")[0] and name.rpartition(".")[2] in FORCES]
    several = len({name.rpartition(".")[0] for name in parts}) > 1
    for column in [*whole, *(parts if several else [])]:
        text = peak(table["time"], table[column], f"N{unit}")
        if text:
            where = column.rpartition(".")[0] or "the structure"
            impulse = float(np.nansum(table[column] * table["dt"]))
            rows.append((f"force on {where}, {column[-1]}", f"{text}; impulse {number(impulse, f'N s{unit}')}"))
    return rows


def boulder_forces(results: Results) -> list[Row]:
    """What boulders have of the force on each interface, with their impulse."""
    table, unit = results.table("probes.csv"), results.per_metre
    rows = []
    for column in boulder_parts(table):
        surface, _, part = column.rpartition(".")
        text = peak(table["time"], table[column], f"N{unit}")
        if not text or is_wall_of(table, surface.rpartition(".")[2]):
            continue
        impulse = float(np.nansum(table[column] * np.diff(table["time"], prepend=0)))
        rows.append((f"force of boulders on {surface.rpartition('.')[2]}, {part[-1]}",
                     f"{text}; impulse {number(impulse, f'N s{unit}')}"))
    return rows


def base_moments(results: Results) -> list[Row]:
    """Moments of the soil's forces on interfaces, about the feet of these."""
    table, unit = results.table("probes.csv"), results.per_metre
    rows = []
    for name, time, moment, foot in moments(results):
        if table is not None and is_wall_of(table, name):
            continue
        for axis, values in zip("z" if moment.shape[1] == 1 else AXES, moment.T):
            text = peak(time, values, f"N m{unit}")
            if text:
                rows.append((f"moment on {name} about its foot, {axis}", f"{text}; foot at {place(foot)} m"))
    return rows


def is_wall_of(table: Table, name: str) -> bool:
    """Whether a surface is a rigid wall of probes.csv."""
    return any(column.rpartition(".")[0].rpartition(".")[2] == name and is_rigid_wall(table, column)
               for column in table.names if column.endswith(".fx"))


def place(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{v + 0.0:.4g}" for v in point) + ")"


def pressures(results: Results) -> list[Row]:
    """Largest pressure on each upright face, and the highest place that soil pressed on, by the frames."""
    table, rows = results.table("probes.csv"), []
    for face in touched_faces(results):
        if table is not None and is_wall_of(table, face.surface):
            continue
        frame, row = np.unravel_index(np.nanargmax(face.pressure), face.pressure.shape)
        where = f"{face.surface}, side {face.side}"
        rows.append((f"largest pressure on {where}", f"{number(face.pressure[frame, row], 'Pa')} at a height of "
                     f"{face.height[row]:.4g} m above its foot at {face.times[frame]:.4g} s (of {len(face.times)} "
                     "frames)"))
        touched = np.flatnonzero((face.pressure > 0).any(axis=0))[-1]
        rows.append((f"run-up on {where}", f"{face.height[touched]:.4g} m above its foot: the highest facets that soil "
                     f"pressed on; the face ends at {face.height[-1]:.4g} m"))
    return rows


def members(results: Results) -> list[Row]:
    """What is asked of sections, ropes, brakes, metal and concrete of structures, over all steps."""
    table, unit, rows = results.table("probes.csv"), results.per_metre, []
    names = table.names if table is not None and table.num_rows else []
    several = len({found["who"] for found in map(MEMBER.match, names) if found}) > 1
    for column in names:
        measure = np.abs
        if SECTION.search(column) and not MEMBER.match(column):
            section, _, part = column.rpartition(".")
            is_moment = part.startswith("M_")
            asked = f"{'moment' if is_moment else 'force'} in section {section}, {part}"
            of = f"N{' m' * is_moment}{unit}"
        elif found := MEMBER.match(column):
            words, of, per_metre, measure = MEMBERS[found["of"]]
            if measure is np.negative and not np.any(table[column] < 0):
                continue  # nothing is compressed
            asked, of = f"{words} {place_of(found, several)}", of + unit * per_metre
        else:
            continue
        text = peak(table["time"], table[column], of, measure)
        if text:
            rows.append((asked, text))
    return rows


def place_of(found: re.Match, several: bool) -> str:
    """What a column of a structure is of; other columns have other places. several: structures."""
    who, group = found["who"], found["group"]
    if group and who and (several or group == who):
        return f"{who}.{group}"
    return group or who or "the structure"


def gauges(results: Results) -> list[Row]:
    """What passed each gauge, such as one on a crest."""
    table, unit = results.table("probes.csv"), results.per_metre
    rows = []
    for name in gauge_names(table) if table is not None and table.num_rows else []:
        column = f"{name}.passed_mass"
        if column in table:
            rows.append((f"passed gauge {name.rpartition('.')[2]}",
                         f"{number(table[column][-1], f'kg{unit}')} until the end"))
    return rows


def stability(results: Results) -> list[Row]:
    """Stability of held groups in 2D whose reaction and moment are reported: friction that holds against sliding, place
    of the resultant."""
    table = results.table("probes.csv")
    if table is None or not table.num_rows or results.dim != 2:
        return []
    up = up_axis(2, results.gravity)
    rows = []
    for column in [name for name in table.names if ".moment_" in f".{name}" and name.endswith("_z")]:
        group = column.removesuffix("_z").replace("moment_", "reaction_")
        names = [f"{group}_{axis}" for axis in AXES[:2]]
        if not all(name in table for name in names):
            continue
        upward, across = table[names[up]], table[names[1 - up]]
        pressed = upward > 0
        label = group.replace("reaction_", "")
        if not pressed.all():
            rows.append((f"uplift of {label}", f"pulled up first at {table['time'][np.argmin(pressed)]:.4g} s"))
        if pressed.any():
            rows += resultant(label, table["time"][pressed], (across / np.where(pressed, upward, 1))[pressed],
                              (table[column] / np.where(pressed, upward, 1))[pressed])
    return rows


def resultant(label: str, time: np.ndarray, slope: np.ndarray, arm: np.ndarray) -> list[Row]:
    """slope: horizontal over vertical reaction; arm: moment over vertical reaction [m]."""
    k, n = int(np.argmax(np.abs(slope))), int(np.argmax(np.abs(arm)))
    return [(f"sliding of {label}", f"needs a friction coefficient of {abs(slope[k]):.4g} at {time[k]:.4g} s, "
             f"{abs(slope[-1]):.4g} at the end"),
            (f"overturning of {label}",
             f"resultant {abs(arm[n]):.4g} m from the middle at {time[n]:.4g} s, {abs(arm[-1]):.4g} m "
             "at the end; it overturns beyond half the width of the footing, and gapes beyond a sixth of it")]
