# SPDX-License-Identifier: BSD-3-Clause
"""Summary of a run, in about ten lines."""

import numpy as np

from plotting.history import FORCES, displacement_columns, is_rigid_wall, probe_points, wall_columns
from plotting.results import Results, is_completed
from plotting.strength import strength_search


def summary_lines(results: Results) -> list[str]:
    """Lines from summary.json and the tables; what a run does not have is left out."""
    lines = [f"Results: {results.folder}"]
    summary = results.summary
    if summary is None:
        lines.append("No summary.json: the run did not come to its end.")
    else:
        lines += [_run_line(summary), *_count_lines(summary)]
        if search := strength_search(summary):
            lines.append(f"factor of safety {search}")
    lines += _probe_lines(results) + _force_lines(results) + _wall_lines(results)
    lines += [f"ParaView: {path}" for path in sorted(results.folder.glob("*/*.xdmf"))]
    plots = sorted(path.name for path in (results.folder / "plots").glob("*"))
    if plots:
        lines.append(f"Plots: {results.folder / 'plots'}: {', '.join(plots)}")
    return lines


def _run_line(summary: dict) -> str:
    wall = summary.get("wall_seconds")
    total = wall.get("total") if isinstance(wall, dict) else wall
    end = "completed" if is_completed(summary) else f"STOPPED: {summary.get('reason', '?')}"
    took = "" if total is None else f" in {total:.1f} s"
    return f"{summary.get('program', 'Run')} {end} at t = {summary.get('end_time', float('nan')):.6g} s{took}"


def _count_lines(summary: dict) -> list[str]:
    """Steps and iterations; the methods that ran."""
    counts = [f"{summary[name]} {name.replace('_', ' ')}"
              for name in ("steps", "steps_in_contact", "cuts", "newton_iterations") if name in summary]
    coupling = summary.get("coupling_iterations")
    if coupling and coupling["mean_in_contact"] is not None:
        counts.append(f"{coupling['mean_in_contact']:.3g} coupling iterations a step in contact, "
                      f"{coupling['max']} at most")
    methods = ", ".join(f"{name} {value}" for name, value in summary.get("methods", {}).items())
    return [line for line in ("; ".join(counts), methods) if line]


def _millimetres(metres: float) -> str:
    return f"{1e3 * metres + 0.0:.4g} mm"  # + 0.0: no sign of a zero


def _probe_lines(results: Results) -> list[str]:
    table = results.table("probes.csv")
    lines = []
    for point in probe_points(table) if table is not None and table.num_rows else []:
        columns = [name for name in displacement_columns(table, point) if np.isfinite(table[name]).any()]
        if columns:  # the component that moves most
            column = max(columns, key=lambda name: np.nanmax(np.abs(table[name])))
            values = table[column]
            peak = int(np.nanargmax(np.abs(values)))
            lines.append(
                f"{column}: largest {_millimetres(values[peak])} at t = {table['time'][peak]:.4g} s, "
                f"at the end {_millimetres(values[-1])}"
            )
    return lines


def _direction(component: str, dim: int) -> str:
    """Direction of "ux", "fy", ...: in 3D which of the axes points up is the scene's choice."""
    return {"x": "horizontal", "y": "vertical"}[component[-1]] if dim == 2 else component[-1]


def _force_lines(results: Results) -> list[str]:
    table = results.table("steps.csv")
    if table is None or not table.num_rows or "fx" not in table:
        return []
    components = [name for name in FORCES if name in table]
    strongest = max(components, key=lambda name: np.nanmax(np.abs(table[name])))
    force, unit = table[strongest], results.per_metre
    peak = int(np.nanargmax(np.abs(force)))
    return [
        f"{_direction(strongest, results.dim)} force on the structure: largest {force[peak]:.4g} N{unit} "
        f"at t = {table['time'][peak]:.4g} s, "
        f"impulse {float(np.sum(force * table['dt'])):.5g} N s{unit}"
    ]


def _wall_lines(results: Results) -> list[str]:
    """The strongest component of the force on each rigid wall."""
    table = results.table("probes.csv")
    walls: dict[str, list[str]] = {}
    for column in wall_columns(table):
        if is_rigid_wall(table, column):
            walls.setdefault(column.rpartition(".")[0], []).append(column)
    lines = []
    for name, columns in walls.items():
        strongest = max(columns, key=lambda column: np.nanmax(np.abs(table[column])))
        force, unit = table[strongest], results.per_metre
        peak = int(np.nanargmax(np.abs(force)))
        lines.append(f"{_direction(strongest, results.dim)} force on {name}: largest {force[peak]:.4g} N{unit} "
                     f"at t = {table['time'][peak]:.4g} s, at the end {force[-1]:.4g} N{unit}")
    return lines
