# SPDX-License-Identifier: BSD-3-Clause
"""The studies of collapsing columns of soil, against experiments."""

import json
from dataclasses import dataclass

import numpy as np

from plotting.column import SurfaceError, area_under, compare_surface, failure_line, read_reference, surface_of
from plotting.results import Results, ResultsError
from plotting.style import COLOURS, legend_beside, new_figure
from studies.measures import Measured
from studies.runner import ROOT, Runner, folder_of

COLLAPSE = "column_collapse"
MEASURED = ROOT / "configs" / COLLAPSE / "data" / "bui2008_column_collapse.csv"
MOVED = 2e-3  # [m]: soil that went less counts as at rest; accuracy of the reading of the experiment


def setting(pointer: str, value: object) -> str:
    return f"mpm.json:/{pointer}={json.dumps(value)}"


def box(width: float, height: float, h: float, cell: str) -> dict:
    """A box of cells from the origin [m]."""
    cells = [round(width / h), round(height / h)]
    return {"box": {"low": [0, 0], "high": [width, height], "cells": cells, "type": cell}}


def on_boxes(h: float, basis: str, cell: str = "quad4") -> list[str]:
    """The scene of Bui et al. (2008) on boxes of cells of size h [m]."""
    return [
        setting("basis", basis),
        setting("grid", box(0.56, 0.12, h, cell)),
        setting("bodies/0/mesh", box(0.2, 0.1, h, cell)),
        setting("bodies/0/points_per_cell", 3 if cell == "tri3" else 4),
        *step_size(0.2 * h),
    ]


def step_size(dt: float) -> list[str]:
    """dt [s], which Newton's method may cut to dt / 256."""
    return [setting("time/dt", dt), setting("time/dt_min", dt / 256)]


def with_fbar(on: bool) -> list[str]:
    return [setting("locking/method", "fbar" if on else "none")]


@dataclass
class Deposit:
    """The final deposit of a run of column_collapse."""

    surface: tuple[np.ndarray, np.ndarray]  #: positions and heights [m]
    failure: tuple[np.ndarray, np.ndarray]  #: of soil at the start: highest that stayed [m]
    error: SurfaceError
    failure_error: float  #: mean of |height difference| of the failure line [m]
    area: float  #: under the surface, by that at the start


def deposit_of(results: Results, series: dict[str, np.ndarray]) -> Deposit:
    soil = results.frames_of_soil()
    start, last = soil.frame(0), soil.frame(len(soil) - 1)
    spacing = float(np.sqrt(np.prod(np.ptp(start.points[:, :2], axis=0)) / len(start.points)))
    line = series["exp_failure_line_by_eye"]
    failure = failure_line(last, line[:, 0], MOVED, spacing)
    surface = surface_of(last.points, spacing)
    return Deposit(surface, (line[:, 0], failure),
                   compare_surface(last.points, spacing, series["exp_surface"]),
                   float(np.mean(np.abs(failure - line[:, 1]))),
                   area_under(*surface) / area_under(*surface_of(start.points, spacing)))


HEAD = ["model", "mean [mm]", "largest [mm]", "at x [m]", "front [m]", "failure line [mm]",
        "area kept", "Newton a step", "cuts", "CPU [s]"]


def row_of(name: str, run: Measured, deposit: Deposit) -> list:
    error = deposit.error
    return [name, 1e3 * error.mean_abs_m, 1e3 * error.max_abs_m, error.max_at_m, error.front_m,
            1e3 * deposit.failure_error, deposit.area, run.newton_per_step(), run.cuts(), run.cpu_seconds()]


def compare(runner: Runner, models: dict[str, list[str]]) -> dict[str, Deposit]:
    """Run the models of column_collapse and report each one's errors; a run that fails says so."""
    series = read_reference(MEASURED)
    rows, deposits = [], {}
    for name, settings in models.items():
        try:
            run = runner.run(folder_of(name), COLLAPSE, settings)
        except ResultsError as error:
            print(error)
            rows.append([name, "failed", *[""] * (len(HEAD) - 2)])
            continue
        deposits[name] = deposit_of(run.results, series)
        rows.append(row_of(name, run, deposits[name]))
    front = next(iter(deposits.values())).error.front_measured_m if deposits else float("nan")
    runner.report(HEAD, rows)
    runner.remark(f"measured front: {front:.3g} m; errors of surface and failure line against Bui et al. (2008)")
    return deposits


def columns(runner: Runner) -> None:
    """Column of Bui et al. (2008): surface, front and failure line for each basis on two grids."""
    models = {"tri3, 5 mm": []}
    for h, averaged in ((5e-3, ("linear", "gimp", "bspline")), (2.5e-3, ("linear",))):
        for basis in ("linear", "gimp", "bspline"):
            name = "quad4" if basis == "linear" else basis
            models[f"{name}, {1e3 * h:g} mm"] = [*on_boxes(h, basis), *with_fbar(False)]
            if basis in averaged:
                models[f"{name} F-bar, {1e3 * h:g} mm"] = [*on_boxes(h, basis), *with_fbar(True)]
    deposits = compare(runner, models)

    series = read_reference(MEASURED)
    figure, axes = new_figure(10, 5, 2)
    for panel, size in zip(axes, ("5 mm", "2.5 mm")):
        panel.plot(*series["exp_surface"].T, "ko", ms=4, label="measured surface")
        panel.plot(*series["exp_failure_line_by_eye"].T, "k^", ms=4, label="measured failure line")
        shown = [name for name in deposits if name.endswith(f" {size}") and "F-bar" not in name]
        for name, colour in zip(shown, COLOURS):
            panel.plot(*deposits[name].surface, color=colour, label=name)
            panel.plot(*deposits[name].failure, "--", color=colour)
        panel.set_aspect("equal")
        panel.set_ylabel("height [m]")
        legend_beside(panel)
    axes[-1].set_xlabel("x [m]")
    runner.save(figure, "columns.png")


FACTORS = {
    "as the scene": [],
    "base slips": [setting("walls/1/condition", "slip")],
    "wall behind slips": [setting("walls/0/condition", "slip")],
    "apex volume forgotten": [setting("bodies/0/material/apex_volume", "forget")],
    "dilation 5 deg": [setting("bodies/0/material/dilation_angle", 5)],
    "F-bar": with_fbar(True),
    "dt 2 ms": step_size(2e-3),
    "dt 0.5 ms": step_size(5e-4),
    "dt 0.2 ms": step_size(2e-4),
    "1 point a cell": [setting("bodies/0/points_per_cell", 1)],
    "6 points a cell": [setting("bodies/0/points_per_cell", 6)],
    "noise kept": [setting("transfer/noise_damping", 0)],
    "noise damped by 1": [setting("transfer/noise_damping", 1)],
    "PIC 1 %": [setting("transfer/noise_damping", 0), setting("transfer/pic_share", 0.01)],
    "TPIC": [setting("transfer/method", "tpic")],
    "Newton to 1e-4": [setting("newton/residual_tolerance", 1e-4)],
    "matrix reused": [setting("newton/reuse_matrix", True)],
}


def column_factors(runner: Runner) -> None:
    """The column of Bui et al. (2008) with one setting of the scene changed at a time."""
    compare(runner, FACTORS)


STUDIES = {study.__name__: study for study in (columns, column_factors)}
