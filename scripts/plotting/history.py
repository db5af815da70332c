# SPDX-License-Identifier: BSD-3-Clause
"""Curves over time and over iterations: probes, residuals, iterations, forces, moments, energies."""

import re
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from plotting.boulders import boulder_names
from plotting.results import Results, ResultsError, Table
from plotting.style import COLOURS, legend_beside, new_figure, plt, save
from plotting.view import AXES, up_axis

RESIDUALS = {"displacement_residual": "residual of\ndisplacement [m]", "force_residual": "change of\nforce [N]"}
FORCES = ("fx", "fy", "fz")
MOMENTS = ("mx", "my", "mz")
ITERATIONS = {
    "iterations": "coupling",
    "soil_newton": "Newton, soil",
    "structure_newton": "Newton, structure",
    "newton_iterations": "Newton",
}
BOULDER_PART = re.compile(r"\.boulders_f[xyz]$")
REMOVED = re.compile(r"(?:^|\.)(?:removed_mass|removed\..+\.mass)$")
SECTION = re.compile(r"\.(N|V_[xyz]|M_[xyz])$")  # columns of a section of a structure
GRID_WALL = re.compile(r"(?:^|\.)wall\.[^.]+\.f[xyz]$")
COMPONENTS = ("ux", "uy", "uz")
VARIED = 4  # largest over smallest step from which on step sizes are drawn on a logarithmic scale


def probe_points(table: Table) -> list[str]:
    """Names of the points whose displacement is recorded, such as "structure.A"."""
    names = [name.rpartition(".") for name in table.names]
    return list(dict.fromkeys(point for point, _, leaf in names if leaf in COMPONENTS and point))


def displacement_columns(table: Table, point: str) -> list[str]:
    return [name for name in table.names if name.rpartition(".")[0] == point
            and name.rpartition(".")[2] in COMPONENTS]


def _probe_curves(runs: dict[str, Results]) -> dict[tuple[str, str], dict[str, tuple[str, Table]]]:
    """(point, axis) -> label of a run -> (column, table) where it has that point.

    The axis is "up" for the vertical one, so that y of a run in the plane meets z of one in space. Displacements below
    1e-6 of the largest of all are round-off and left out.
    """
    curves: dict[tuple[str, str], dict[str, tuple[str, Table]]] = {}
    size: dict[tuple[str, str], float] = {}
    for label, run in runs.items():
        table = run.table("probes.csv")
        up = AXES[up_axis(run.dim, run.gravity)]
        for point in probe_points(table) if table else []:
            for column in displacement_columns(table, point):
                key = point, "up" if column[-1] == up else column[-1]
                curves.setdefault(key, {})[label] = (column, table)
                size[key] = max(size.get(key, 0.0), float(np.nanmax(np.abs(table[column]), initial=0)))
    least = 1e-6 * max(size.values(), default=0.0)
    return {key: curve for key, curve in curves.items() if size[key] >= least}


def _axis_label(axis: str, columns: list[str], in_plane: bool) -> str:
    """columns: those that are drawn; in_plane: whether all runs are 2D."""
    if axis != "up":
        return "horizontal" if in_plane else axis
    return "vertical" if in_plane else f"vertical ({'/'.join(sorted({column[-1] for column in columns}))})"


def plot_probes(runs: dict[str, Results], out: Path, name: str = "probes.png") -> Path | None:
    """Displacement of every probed point against time, all runs in one figure.

    runs: label -> results; with one run, a line a component; with more, a line a run,
    of one colour in all panels.
    """
    curves = _probe_curves(runs)
    if not curves:
        return None
    drawn = [label for label in runs if any(label in curve for curve in curves.values())]
    in_plane = all(runs[label].dim == 2 for label in drawn)
    figure, axes = new_figure(8.5, 0.8 + 2.4 * len(curves), len(curves))
    for each, ((point, axis), curve) in zip(axes, curves.items()):
        for k, label in enumerate(drawn):
            column, table = curve.get(label, (None, None))
            each.plot(*((table["time"], table[column]) if table else ([], [])), label=label,
                      color=COLOURS[k % len(COLOURS)])
        along = _axis_label(axis, [column for column, _ in curve.values()], in_plane)
        each.set_ylabel(f"{along}\ndisplacement [m]")
        each.set_title(f"point {point.rpartition('.')[2]}, {along}", loc="left")
    axes[-1].set_xlabel("time [s]")
    if len(drawn) > 1:
        legend_beside(axes[0])
    return save(figure, out / name)


def plot_residuals(results: Results, out: Path) -> Path | None:
    """Residual of every coupling iteration, on a logarithmic scale.

    Left: the iterations of all steps in a row, the first and the last of each step in distinct colours, the allowed
    residual as a line; the upper scale gives the time. Right: the steps around the one with most iterations, a line a
    step over the iterations within it.
    """
    table = results.table("iterations.csv")
    if table is None or not table.num_rows:
        return None
    known = [name for name in RESIDUALS if name in table]
    if not known:
        raise ResultsError(f"{table.path}: none of the columns {', '.join(RESIDUALS)}")
    columns = [name for name in known if np.any(table[name] > 0)]
    if not columns:
        return None  # no contact yet
    starts = np.flatnonzero(table["iteration"] == np.min(table["iteration"]))
    ends = np.append(starts[1:], table.num_rows)
    worst = int(np.argmax(ends - starts))
    zoom = range(max(0, worst - 6), min(len(starts), worst + 7))

    figure, axes = plt.subplots(len(columns), 2, figsize=(11, 0.9 + 2.6 * len(columns)), squeeze=False,
                                sharex="col", sharey="row", width_ratios=[2, 1])
    for (left, right), column in zip(axes, columns):
        values = np.where(table[column] > 0, table[column], np.nan)  # a logarithm has no zero
        _draw_all_residuals(left, values, starts, ends)
        allowed = table[column.replace("residual", "limit")]
        left.plot(allowed, color=COLOURS[2], lw=1)
        _draw_some_residuals(right, values, allowed, [slice(starts[step], ends[step]) for step in zoom])
        left.set_ylabel(RESIDUALS[column].replace("[N]", f"[N{results.per_metre}]"))
    legend_beside(axes[0, 1])
    marks = np.linspace(0, table.num_rows - 1, 7).astype(int)
    axes[0, 0].secondary_xaxis("top").set_xticks(marks, [f"{table['time'][m]:.3g} s" for m in marks])
    axes[-1, 0].set_xlabel("coupling iteration, all steps in a row")
    axes[-1, 1].set_xlabel("iteration within the step")
    shown = table["step"][starts[zoom]]
    axes[-1, 1].xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0, 1].set_title(f"steps {shown[0]:.0f} to {shown[-1]:.0f}", loc="left")
    return save(figure, out / "residuals.png")


def _draw_all_residuals(axes: Axes, values: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> None:
    axes.semilogy(values, ".", color="0.75", ms=2, rasterized=True)
    axes.semilogy(starts, values[starts], ".", color=COLOURS[1], ms=2.5)
    axes.semilogy(ends - 1, values[ends - 1], ".", color=COLOURS[0], ms=2.5)


def _draw_some_residuals(axes: Axes, values: np.ndarray, allowed: np.ndarray, steps: list[slice]) -> None:
    """Each step from its iteration 0 on, all over each other. steps: their rows."""
    for step in steps:
        axes.semilogy(values[step], ".-", color="0.6", lw=1, ms=4)
    for k, step in enumerate(steps):
        label = "{} of a step" if k == 0 else "_"
        axes.semilogy(0, values[step.start], ".", color=COLOURS[1], ms=6, label=label.format("first"))
        axes.semilogy(step.stop - step.start - 1, values[step.stop - 1], ".", color=COLOURS[0], ms=6,
                      label=label.format("last"))
        axes.plot(allowed[step], color=COLOURS[2], lw=1, label="_" if k else "allowed")


def plot_iterations(results: Results, out: Path) -> Path | None:
    """Coupling or Newton iterations and the size of each step against time."""
    table = results.table("steps.csv")
    if table is None or not table.num_rows:
        return None
    columns = [name for name in ITERATIONS if name in table]
    figure, axes = new_figure(8.5, 4.8, 2)
    for column in columns:
        axes[0].step(table["time"], table[column], where="pre", lw=1,
                     label=ITERATIONS[column])
    axes[0].set_ylabel("iterations a step")
    axes[0].set_ylim(bottom=0)
    legend_beside(axes[0])
    axes[1].step(table["time"], table["dt"], where="pre", lw=1)
    axes[1].set_ylabel("step size [s]")
    if table["dt"].max() > VARIED * table["dt"].min():
        axes[1].set_yscale("log")
    else:
        axes[1].set_ylim(bottom=0)
        axes[1].ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
    axes[1].set_xlabel("time [s]")
    return save(figure, out / "iterations.png")


def energy_curves(results: Results) -> list[tuple[Table, str]]:
    """Energies of steps.csv and probes.csv, and sums of work and losses of probes.csv.

    Those of round-off and those of single boulders are left out.
    """
    sums = ("energy", "work", "dissipation", "damping", "loss")
    tables = [(results.table("probes.csv"), sums), (results.table("steps.csv"), ("energy",))]
    curves = [(table, name) for table, parts in tables if table for name in table.matching(*parts)
              if name.rpartition(".")[0] not in boulder_names(table)]
    sizes = [float(np.nanmax(np.abs(table[name]), initial=0)) for table, name in curves]
    least = 1e-12 * max(sizes, default=0.0)
    return [curve for curve, size in zip(curves, sizes) if size > least]


def plot_energies(results: Results, out: Path) -> Path | None:
    """Energies against time."""
    return _plot_curves(energy_curves(results), f"energy [J{results.per_metre}]", out / "energies.png")


def plot_forces(results: Results, out: Path) -> Path | None:
    """Resultant force of soil and boulders on the structure against time, and the part of the boulders."""
    table = results.table("steps.csv")
    columns = [] if table is None else [name for name in FORCES if name in table]
    several = _of_surfaces(table, FORCES)
    if len({name.rpartition(".")[0] for name in several}) > 1:
        columns += several
    probes = results.table("probes.csv")
    rocks = [(probes, name) for name in boulder_parts(probes) if not is_rigid_wall(probes, name)]
    return _plot_curves([*((table, name) for name in columns), *rocks],
                        f"force on the structure [N{results.per_metre}]", out / "forces.png")


def boulder_parts(table: Table | None) -> list[str]:
    """Columns of probes.csv with the part of a force that boulders exert; not those of zeros."""
    return [name for name in table.names if BOULDER_PART.search(name) and np.any(table[name] != 0)] if table else []


def wall_columns(table: Table | None) -> list[str]:
    """Columns of probes.csv with the force of the soil on rigid walls and walls of the grid; not those of zeros."""
    return [name for name in _of_surfaces(table, FORCES)
            if (GRID_WALL.search(name) or is_rigid_wall(table, name)) and np.any(table[name] != 0)]


def is_rigid_wall(table: Table, column: str) -> bool:
    """Whether a column such as "lid.fx" is of a rigid wall; a wall of the grid has no moment, a boulder turns."""
    name = column.rpartition(".")[0]
    return f"{name}.mz" in table and name not in boulder_names(table)


def plot_wall_forces(results: Results, out: Path) -> Path | None:
    """Force on each rigid wall and wall of the grid against time, and the part of the boulders."""
    table = results.table("probes.csv")
    rocks = [name for name in boulder_parts(table) if is_rigid_wall(table, name)]
    return _plot_curves([(table, name) for name in (*wall_columns(table), *rocks)],
                        f"force on the wall [N{results.per_metre}]", out / "wall_forces.png")


def plot_moments(results: Results, out: Path) -> Path | None:
    """Moment of the soil on each interface and rigid wall against time, a panel a surface: each has a scale of its
    own."""
    surfaces: dict[str, list[tuple[Table, str]]] = {}
    for table in (results.table("steps.csv"), results.table("probes.csv")):
        for name in _of_surfaces(table, MOMENTS):
            surfaces.setdefault(name.rpartition(".")[0], []).append((table, name))
    if not surfaces:
        return None
    figure, panels = new_figure(9.5, 1.6 + 2.6 * len(surfaces), len(surfaces))
    for axes, curves in zip(panels, surfaces.values()):
        _draw_curves(axes, curves, f"moment [N m{results.per_metre}]")
    panels[-1].set_xlabel("time [s]")
    return save(figure, out / "moments.png")


def plot_sections(results: Results, out: Path) -> Path | None:
    """Forces and moments of the sections of structures against time, a panel for each of the two."""
    table = results.table("probes.csv")
    names = [name for name in table.names if SECTION.search(name)] if table else []
    if not names:
        return None
    moments = [name for name in names if ".M_" in name]
    figure, panels = new_figure(9.5, 7.4, 2)
    _draw_curves(panels[0], [(table, name) for name in names if name not in moments],
                 f"force [N{results.per_metre}]")
    _draw_curves(panels[1], [(table, name) for name in moments], f"moment [N m{results.per_metre}]")
    panels[1].set_xlabel("time [s]")
    return save(figure, out / "sections.png")


def plot_removed(results: Results, out: Path) -> Path | None:
    """Mass that has left the grid, by side, against time."""
    table = results.table("probes.csv")
    names = [name for name in table.names if REMOVED.search(name)] if table else []
    curves = [(table, name) for name in names if np.any(table[name] > 0)]
    return _plot_curves(curves, f"mass that left the grid [kg{results.per_metre}]", out / "removed.png")


def _of_surfaces(table: Table | None, components: tuple[str, ...]) -> list[str]:
    """Columns such as "wall.fx", of single interfaces and rigid walls."""
    names = table.names if table else []
    return [name for name in names if "." in name and name.rpartition(".")[2] in components]


def _plot_curves(curves: list[tuple[Table, str]], label: str, path: Path) -> Path | None:
    if not curves:
        return None
    figure, (axes,) = new_figure(9.5, 4.2)
    _draw_curves(axes, curves, label)
    axes.set_xlabel("time [s]")
    return save(axes.figure, path)


def _draw_curves(axes: Axes, curves: list[tuple[Table, str]], label: str) -> None:
    for k, (table, name) in enumerate(curves):
        dashes = ("-", "--", ":")[k // len(COLOURS) % 3]
        axes.plot(table["time"], table[name], dashes, lw=1.1, label=name.replace("_", " ").replace(".", " "))
    axes.set_ylabel(label)
    _plain_zero(axes)
    legend_beside(axes)


def _plain_zero(axes: Axes) -> None:
    axes.axhline(0, color="0.6", lw=0.6, zorder=0)
