# SPDX-License-Identifier: BSD-3-Clause
"""Curves of the gauges over time: depth, speed, flux, mass, pressure."""

from pathlib import Path

from matplotlib.axes import Axes

from plotting.results import Results, Table, gauge_names
from plotting.style import COLOURS, legend_beside, new_figure, save

# Label of a panel, columns that are drawn solid and dashed.
PANELS = (
    ("depth [m]", "depth", "top"),
    ("speed [m/s]", "normal_speed", "max_speed"),
    ("mass flux [kg/s{}]", "section_flux", ""),
    ("mass passed\n[kg{}]", "passed_mass", ""),
    ("pressure [Pa]", "pressure", "dynamic_pressure"),
)


def _draw_panel(axes: Axes, table: Table, gauges: list[str], columns: tuple[str, str]) -> None:
    solid, dashed = columns
    for k, gauge in enumerate(gauges):
        colour = COLOURS[k % len(COLOURS)]
        axes.plot(table["time"], table[f"{gauge}.{solid}"], color=colour, lw=1.1,
                  label=f"{gauge.rpartition('.')[2]} {solid}".replace("_", " "))
        if dashed:
            axes.plot(table["time"], table[f"{gauge}.{dashed}"], "--", color=colour, lw=0.9,
                      label=f"{gauge.rpartition('.')[2]} {dashed}".replace("_", " "))
    axes.axhline(0, color="0.6", lw=0.6, zorder=0)
    legend_beside(axes)


def plot_gauges(results: Results, out: Path) -> Path | None:
    """Figure of all gauges: a panel a quantity, a colour a gauge."""
    table = results.table("probes.csv")
    gauges = gauge_names(table) if table else []
    if not gauges:
        return None
    figure, axes = new_figure(9.5, 2.2 * len(PANELS), len(PANELS))
    for each, (label, *columns) in zip(axes, PANELS):
        _draw_panel(each, table, gauges, tuple(columns))
        each.set_ylabel(label.format(results.per_metre))
    axes[-1].set_xlabel("time [s]")
    return save(figure, out / "gauges.png")
