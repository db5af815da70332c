# SPDX-License-Identifier: BSD-3-Clause
"""The first answers on a run, as numbers: factor of safety, displacements, forces, impact coefficient, moments,
pressures, run-up, volume past a surface, flow at gauges, stability."""

import re
from collections.abc import Callable

import numpy as np
from scipy.integrate import trapezoid

from plotting.history import FORCES, SECTION, boulder_parts, displacement_columns, is_rigid_wall, probe_points
from plotting.results import Results, Table, gauge_names
from plotting.strength import strength_search
from plotting.view import AXES

from .beyond import soil_past
from .footing import stability
from .incoming import Impact, froude, impacts
from .surfaces import all_loads, loaded_surfaces, moments, rigid_walls, touched_faces

# Columns of fem_solver about lines, membranes, metal and concrete: what they are called, their units, whether these
# are per metre in 2D, and of which values the largest one is asked: of the sizes, of the values, or of these with the
# other sign.
MEMBERS = {"axial_max": ("largest axial force in the lines of", "N", True, np.positive),
           "axial_min": ("least axial force in the lines of", "N", True, np.negative),
           "shear_max": ("largest shear force in the beams of", "N", True, np.abs),
           "bending_max": ("largest bending moment in the beams of", "N m", True, np.abs),
           "torsion_max": ("largest torsional moment in the beams of", "N m", True, np.abs),
           "stress_max": ("largest stress in the bars of", "Pa", False, np.positive),
           "stress_min": ("least stress in the bars of", "Pa", False, np.negative),
           "tension_max": ("largest tension in the membranes of", "N/m", False, np.positive),
           "strain_max": ("largest strain in the membranes of", "", False, np.positive),
           "brake_run": ("largest run of a brake of", "m", False, np.abs),
           "plastic_strain": ("largest plastic strain of", "", False, np.abs),
           "crack_width": ("widest crack of", "m", False, np.abs),
           "damage_work": ("work of cracks and crushing of", "J", True, np.abs)}
FLOW = (("depth", "depth", "m"), ("mean speed", "normal_speed", "m/s"), ("dynamic pressure", "dynamic_pressure", "Pa"))
# A participant has no dot in its name, a group may have some.
MEMBER = re.compile(rf"(?:(?P<who>[^.]+)\.)?(?P<of>{'|'.join(MEMBERS)})(?:_(?P<group>.+))?$")
LAST = 0.1  # part of the time whose mean is the residual value
Row = tuple[str, str]  # what is asked, answer


def parts(base_friction: float | None = None) -> list[Callable[[Results], list[Row]]]:
    """The functions that make the rows, in their order; rows that a run lacks are left out.

    base_friction: coefficient under footings, None: not known.
    """
    return [safety, displacements, forces, impact_rows, boulder_forces, base_moments,
            lambda results: stability(results, base_friction), pressures, past, members, gauges]


def answers(results: Results, base_friction: float | None = None) -> list[Row]:
    """All rows. @raises ResultsError, OSError, KeyError  a file that cannot be read"""
    return [row for part in parts(base_friction) for row in part(results)]


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


def residual(time: np.ndarray, values: np.ndarray, unit: str) -> str:
    """Mean over the last tenth of the time, and how far the values are from it there; empty: no time has passed."""
    known = np.isfinite(values)
    late = known & (time >= time[-1] - LAST * (time[-1] - time[0]))
    if np.count_nonzero(late) < 2:
        return ""
    t, v = time[late], values[late]
    mean = float(trapezoid(v, t)) / (t[-1] - t[0])
    return f"; in the last tenth {number(mean, unit)} on average, within {number(float(np.abs(v - mean).max()), unit)}"


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
                rows.append((f"displacement {column}", text + residual(table["time"], table[column], "m")))
    return rows


def forces(results: Results) -> list[Row]:
    """Force on the structure with its impulse, on each of several surfaces, and on upright rigid walls.
    """
    table, rows = results.table("steps.csv"), []
    if table is not None and table.num_rows:
        whole = [name for name in FORCES if name in table]
        parts = [name for name in table.names if name.rpartition(".")[0] and name.rpartition(".")[2] in FORCES]
        surfaces = list(dict.fromkeys(name.rpartition(".")[0] for name in parts))
        rows += force_rows(results, "the structure", table["time"], table["dt"], [table[name] for name in whole])
        if whole and not any(np.any(table[name] != 0) for name in whole + parts):
            rows.append(("force on the structure", f"none until {table['time'][-1]:.4g} s: nothing has touched it"))
        for surface in surfaces if len(surfaces) > 1 else []:
            columns = [table[name] for name in parts if name.rpartition(".")[0] == surface]
            rows += force_rows(results, surface, table["time"], table["dt"], columns)
    rigid = rigid_walls(results) & set(loaded_surfaces(results))
    for loads in all_loads(results):
        if loads.name in rigid:
            rows += force_rows(results, loads.name, loads.time, np.diff(loads.time, prepend=loads.time[:1]),
                               list(loads.force.T))
    return rows


def force_rows(results: Results, where: str, time: np.ndarray, dt: np.ndarray, columns: list[np.ndarray]) -> list[Row]:
    """Rows of the components x, y, z of a force, and of its size where it has several."""
    unit, rows = results.per_metre, []
    for axis, values in zip(AXES, columns):
        text = peak(time, values, f"N{unit}")
        if text:
            impulse = float(np.nansum(values * dt))
            rows.append((f"force on {where}, {axis}", f"{text}{residual(time, values, f'N{unit}')}; impulse "
                         f"{number(impulse, f'N s{unit}')}"))
    if len(rows) > 1:
        size = np.linalg.norm(np.column_stack(columns), axis=1)
        impulse = float(np.linalg.norm([np.nansum(values * dt) for values in columns]))
        rows.append((f"force on {where}, size", f"{peak(time, size, f'N{unit}')}; impulse "
                     f"{number(impulse, f'N s{unit}')}"))
    return rows


def impact_rows(results: Results) -> list[Row]:
    """Impact coefficient of each surface, with the flow that it refers to, or why there is none."""
    return [(f"impact coefficient of {name}", impact if isinstance(impact, str) else impact_words(results, impact))
            for name, impact in impacts(results)]


def impact_words(results: Results, impact: Impact) -> str:
    flow, alpha = impact.flow, impact.coefficient
    k = int(np.nanargmax(alpha))
    b, width = ("", "") if results.dim == 2 else (" b", f", b {impact.width:.4g} m (the surface across the flow)")
    number_of_froude = froude(flow, results.gravity)
    ratio = "" if number_of_froude is None else f"; Froude number {number_of_froude:.3g}"
    return (f"{alpha[k]:.4g} at {impact.time[k]:.4g} s; at the end {alpha[-1]:.4g}: force along the flow over "
            f"rho v² h{b} of gauge {flow.gauge.name} at {flow.time:.4g} s, when this was largest there: "
            f"rho {flow.density:.4g} kg/m³, v {flow.speed:.4g} m/s, h {flow.depth:.4g} m{width}{ratio}")


def boulder_forces(results: Results) -> list[Row]:
    """Part of the boulders in the force on each interface, with their impulse."""
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
    """Moments of the soil's forces on surfaces, about the feet of these."""
    unit, rows = results.per_metre, []
    for name, time, moment, foot in moments(results):
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
    rows = []
    for face in touched_faces(results):
        frame, row = np.unravel_index(np.nanargmax(face.pressure), face.pressure.shape)
        where = f"{face.surface}, side {face.side}"
        rows.append((f"largest pressure on {where}", f"{number(face.pressure[frame, row], 'Pa')} at a height of "
                     f"{face.height[row]:.4g} m above its foot at {face.times[frame]:.4g} s (of {len(face.times)} "
                     "frames)"))
        pressed = face.pressure > 0
        touched = np.flatnonzero(pressed.any(axis=0))[-1]
        first = int(np.argmax(pressed[:, touched]))
        is_crest = touched + 1 == len(face.height)
        crest = ", up to its crest" if is_crest else f"; the face ends at {face.height[-1]:.4g} m"
        rows.append((f"run-up on {where}", f"{face.height[touched]:.4g} m above its foot, first at "
                     f"{face.times[first]:.4g} s: the highest facets that soil pressed on{crest}"))
    return rows


def past(results: Results) -> list[Row]:
    """Soil that got past each surface, as its volume at rest."""
    unit, rows = ("m³", "m³/m")[results.dim == 2], []
    left = removed_mass(results)
    for each in soil_past(results):
        k = int(np.argmax(each.volume))
        if each.volume[k] <= 0 and not left:
            rows.append((f"volume past {each.surface}", f"none in {len(each.times)} frames"))
            continue
        share = each.volume[-1] / each.whole
        words = (f"{number(each.volume[-1], unit)} at the end ({share:.3g} of all soil), at most "
                 f"{number(each.volume[k], unit)} at {each.times[k]:.4g} s: over, under or around it, measured at rest "
                 f"beyond its last node along {place(each.direction)}")
        if each.behind is not None:
            words += f"; {number(each.behind[-1], unit)} of that at the end lies within its width"
        if left:
            words += f"; {number(left, f'kg{results.per_metre}')} that left the grid are not counted"
        rows.append((f"volume past {each.surface}", words))
    return rows


def removed_mass(results: Results) -> float:
    """Mass of soil that has left the grid until the end."""
    table = results.table("probes.csv")
    names = [name for name in table.names if name.rpartition(".")[2] == "removed_mass"] if table is not None else []
    return sum(float(table[name][-1]) for name in names) if names and table.num_rows else 0.0


def members(results: Results) -> list[Row]:
    """Rows on sections, ropes, brakes, metal and concrete of structures, over all steps."""
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
            if found["of"] == "torsion_max" and not np.any(table[column]):
                continue  # in the plane
            asked, of = f"{words} {place_of(found, several)}", of + unit * per_metre
        else:
            continue
        text = peak(table["time"], table[column], of, measure)
        if text:
            rows.append((asked, text))
    return rows


def place_of(found: re.Match, several: bool) -> str:
    """Owner of a column of a structure; other columns have other places. several: structures."""
    who, group = found["who"], found["group"]
    if group and who and (several or group == who):
        return f"{who}.{group}"
    return group or who or "the structure"


def gauges(results: Results) -> list[Row]:
    """Soil that passed each gauge, such as one on a crest, and the flow there."""
    table, unit = results.table("probes.csv"), results.per_metre
    rows = []
    density = one_density(results)
    for name in gauge_names(table) if table is not None and table.num_rows else []:
        column, label = f"{name}.passed_mass", name.rpartition(".")[2]
        if column in table:
            volume = "" if density is None else f" ({number(table[column][-1] / density, f'm³{unit}')} at rest)"
            rows.append((f"passed gauge {label}", f"{number(table[column][-1], f'kg{unit}')} until the end{volume}"))
        parts = [(words, peak(table["time"], table[f"{name}.{leaf}"], of)) for words, leaf, of in FLOW
                 if f"{name}.{leaf}" in table]
        texts = [f"{words} {text}" for words, text in parts if text]
        if texts:
            rows.append((f"flow at gauge {label}", "; ".join(texts)))
    return rows


def one_density(results: Results) -> float | None:
    """Density at rest of all soil [kg/m³]; None: bodies differ, or it is not known."""
    values = {body.get("material", {}).get("density") for body in results.settings("mpm.json").get("bodies", [])}
    value = values.pop() if len(values) == 1 else None
    return float(value) if isinstance(value, (int, float)) else None
