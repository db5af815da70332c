# SPDX-License-Identifier: BSD-3-Clause
"""Curves of a page: lists of numbers, thinned out where a screen shows no more."""

from typing import Any

import numpy as np

from plotting import history
from plotting.gauges import PANELS
from plotting.results import Results, Table, gauge_names
from .answers import place
from .incoming import impacts
from .surfaces import moments, touched_faces

BINS = 600  # of a curve: each keeps its first, lowest, highest and last value
MAX_ROWS = 30000  # of the residuals of all steps together
DIGITS = 5
SEEN = 1e-3  # of the largest curve of a chart of energies: what is smaller lies on its zero
ITERATIONS = {"iterations": "coupling", "soil_newton": "Newton, soil", "structure_newton": "Newton, structure",
              "newton_iterations": "Newton"}


def plain(values: np.ndarray) -> list[float | None]:
    """Numbers of DIGITS digits; None where JSON has no number for them."""
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]


def thinned(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Numbers of the points to keep so that no peak is lost."""
    if len(x) <= 4 * BINS:
        return np.arange(len(x))
    keep = set()
    for part in np.array_split(np.arange(len(x)), BINS):
        known = part[np.isfinite(y[part])]
        extremes = [known[np.argmin(y[known])], known[np.argmax(y[known])]] if len(known) else []
        keep.update((part[0], part[-1], *extremes))
    return np.array(sorted(keep))


def curve(name: str, x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    keep = thinned(x, y)
    return {"name": name, "x": plain(x[keep]), "y": plain(y[keep])}


def chart(name: str, title: str, curves: list[tuple[str, np.ndarray, np.ndarray]], **how: Any) -> dict[str, Any]:
    """A chart against time [s]; `title` has the unit."""
    return {"name": name, "title": title, "curves": [curve(*each) for each in curves], **how}


def charts(results: Results) -> list[dict[str, Any]]:
    """Charts that the folder has data for."""
    steps, probes, unit = results.table("steps.csv"), results.table("probes.csv"), results.per_metre
    found = []
    if steps is not None and steps.num_rows:
        forces = [name for name in history.FORCES if name in steps]
        found.append(chart("force", f"force of the soil on the structure [N{unit}]", _of(steps, forces)))
    if probes is not None and probes.num_rows:
        found.append(chart("displacement", "displacement [m]", _displacements(probes)))
    if steps is not None and steps.num_rows:
        names = [name for name in ITERATIONS if name in steps]
        found += [chart("iterations", "iterations of a step",
                        [(ITERATIONS[name], steps["time"], steps[name]) for name in names], floor=0),
                  chart("dt", "step size [s]", _of(steps, ["dt"]), log=True),
                  chart("wall", "wall time of a step [s]", _wall(steps), log=True)]
    found[1:1] = [*_impacts(results), *_moments(results), *_pressures(results)]
    found += _gauges(results)
    energies = [(name.replace("_", " "), table["time"], table[name])
                for table, name in history.energy_curves(results)]
    sizes = [float(np.nanmax(np.abs(values), initial=0)) for _, _, values in energies]
    seen = SEEN * max(sizes, default=0.0)
    left_out = [each[0] for each, size in zip(energies, sizes) if size < seen]
    found.append(chart("energy", f"energies and work [J{unit}]",
                       [each for each, size in zip(energies, sizes) if size >= seen],
                       **({"hint": f"At zero on this scale: {', '.join(left_out)}."} if left_out else {})))
    return [each for each in found if each["curves"]]


def _moments(results: Results) -> list[dict[str, Any]]:
    """A chart a surface: moments of a bed would leave no scale for those of a wall."""
    return [chart(f"moment-{name}", f"moment on {name} about its foot, {place(foot)} m [N m{results.per_metre}]",
                  [("mz" if moment.shape[1] == 1 else f"m{axis}", time, values)
                   for axis, values in zip("z" if moment.shape[1] == 1 else "xyz", moment.T)])
            for name, time, moment, foot in moments(results)]


def _pressures(results: Results) -> list[dict[str, Any]]:
    """A chart an upright face: pressure over the height."""
    found = []
    for face in touched_faces(results):
        k = int(np.argmax(np.nansum(face.pressure, axis=1)))
        curves = [("largest over the frames", face.height, np.nanmax(face.pressure, axis=0)),
                  (f"at {face.times[k]:.4g} s, of the largest sum", face.height, face.pressure[k]),
                  ("at the end", face.height, face.pressure[-1])]
        found.append(chart(f"pressure-{face.surface}{face.side}", f"pressure on {face.surface}, side {face.side} [Pa]",
                           curves,
                           label="height above its foot [m]", floor=0))
        latest = np.where(np.nanmax(face.pressure, axis=0) > 0, face.times[np.argmax(face.pressure, axis=0)], np.nan)
        found.append(chart(f"pressure-time-{face.surface}{face.side}",
                           f"time of the largest pressure on {face.surface}, side {face.side} [s]",
                           [("largest over the frames", face.height, latest)], label="height above its foot [m]"))
    return found


def _impacts(results: Results) -> list[dict[str, Any]]:
    return [chart(f"impact-{name}", f"impact coefficient of {name}, by gauge {impact.flow.gauge.name} [-]",
                  [("alpha", impact.time, impact.coefficient)])
            for name, impact in impacts(results) if not isinstance(impact, str)]


def _gauges(results: Results) -> list[dict[str, Any]]:
    """A chart a quantity, with all gauges."""
    table = results.table("probes.csv")
    names = gauge_names(table) if table is not None and table.num_rows else []
    found = []
    for title, *leaves in PANELS:
        curves = [(f"{name.rpartition('.')[2]} {leaf}".replace("_", " "), table["time"], table[f"{name}.{leaf}"])
                  for name in names for leaf in leaves if leaf and f"{name}.{leaf}" in table]
        words = title.format(results.per_metre).replace("\n", " ")
        found.append(chart(f"gauge-{leaves[0].replace('_', '-')}", f"gauges: {words}", curves))
    return found


def compared(own: list[dict[str, Any]], other: list[dict[str, Any]], label: str) -> list[dict[str, Any]]:
    """Charts of a run with the curves of another one beside them, where it has the same quantity."""
    theirs = {each["name"]: each["curves"] for each in other}
    return [each | {"curves": [*each["curves"], *(curve | {"name": f"{curve['name']}, {label}"}
                                                  for curve in theirs.get(each["name"], []))]} for each in own]


def _of(table: Table, names: list[str]) -> list[tuple[str, np.ndarray, np.ndarray]]:
    return [(name, table["time"], table[name]) for name in names]


def _displacements(probes: Table) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Displacements of all probed points, but for components that are round-off of the largest."""
    names = [name for point in history.probe_points(probes) for name in history.displacement_columns(probes, point)]
    sizes = {name: float(np.nanmax(np.abs(probes[name]), initial=0)) for name in names}
    least = 1e-6 * max(sizes.values(), default=0.0)
    return _of(probes, [name for name in names if sizes[name] > least])


def _wall(steps: Table) -> list[tuple[str, np.ndarray, np.ndarray]]:
    parts = [name for name in steps.names if name.endswith((".busy_seconds", ".message_seconds"))]
    curves = [("whole", steps["time"], steps["wall_seconds"])] if "wall_seconds" in steps else []
    for name in parts:
        label = name.removesuffix("_seconds").replace(".busy", "").replace(".message", ", messages")
        curves.append((label, steps["time"], steps[name]))
    return curves


def residuals(results: Results) -> dict[str, Any] | None:
    """Residuals and limits of each try of a step that took iterations, a number an iteration."""
    table = results.table("iterations.csv")
    if table is None or not table.num_rows:
        return None
    starts = np.flatnonzero(table["iteration"] == 0)
    if not len(starts):
        return None
    ends = np.append(starts[1:], table.num_rows)
    tries = [(begin, end) for begin, end in zip(starts, ends) if _tells(table, begin, end)]
    kept = _chosen(table, tries)
    columns = [name for name in ("displacement_residual", "displacement_limit", "force_residual", "force_limit")
               if name in table]
    rows = []
    for begin, end in kept:
        time, dt = plain([table["time"][begin], table["dt"][begin]])
        rows.append([int(table["step"][begin]), time, dt, str(table["status"][end - 1]),
                     *[plain(table[name][begin:end]) for name in columns]])
    return {"columns": ["step", "time", "dt", "status", *columns], "tries": rows, "all": len(tries),
            "unit": results.per_metre}


def _tells(table: Table, begin: int, end: int) -> bool:
    """Whether a try is worth showing: the one pass of a step without contact is not."""
    return end - begin > 1 or table["status"][begin] != "converged" or table["displacement_residual"][begin] > 0


def _chosen(table: Table, tries: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The tries to show, as many as fit, in their order: those that did not converge, the longest, then evenly spread
    ones."""
    if sum(end - begin for begin, end in tries) <= MAX_ROWS:
        return tries
    first = sorted(range(len(tries)), key=lambda k: (table["status"][tries[k][1] - 1] == "converged",
                                                     tries[k][0] - tries[k][1]))[:200]
    mean = sum(end - begin for begin, end in tries) / len(tries)
    evenly = np.linspace(0, len(tries) - 1, int(0.8 * MAX_ROWS / mean)).astype(int)
    return [tries[k] for k in sorted({*first, *evenly.tolist()})]
