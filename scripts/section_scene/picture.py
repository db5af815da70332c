# SPDX-License-Identifier: BSD-3-Clause
"""A picture of a section before it runs: its masses with their cells, base, water table, wall and gauges."""

from itertools import cycle
from pathlib import Path

from matplotlib.collections import PolyCollection
from plotting.style import COLOURS, STRUCTURE, plt, save

from .scene import Made

SOIL_COLOURS = ["#D9B38C", "#B98B5E", "#E5D3A5", "#8F7A66", "#C9C2A8"]
MOST_EDGES = 20_000  # cells whose edges are drawn


def draw(made: Made, path: Path) -> Path:
    """Coordinates of the plan; as high as wide."""
    x0, z0 = made.origin
    plan, base = made.plan, made.base
    figure, axes = plt.subplots(figsize=(10, 5))
    bottom = made.low[1] + z0
    axes.fill_between(base.x + x0, bottom, base.z + z0, color="0.85")
    axes.plot(base.x + x0, base.z + z0, color="k", linewidth=1.2, label="rigid base")
    edges = "#00000030" if sum(len(mass.cells) for mass in made.masses) <= MOST_EDGES else "none"
    for mass, colour in zip(made.masses, cycle(SOIL_COLOURS)):
        shown = COLOURS[1] if mass.name == "slide" else colour
        axes.add_collection(PolyCollection(mass.nodes[mass.cells] + made.origin, facecolors=shown, edgecolors=edges,
                                           linewidths=0.3, label=f"{mass.name}, {mass.area:.4g} m²"))
    if made.wall is not None:
        axes.add_collection(PolyCollection(made.wall.nodes[made.wall.cells] + made.origin, facecolors=STRUCTURE,
                                           edgecolors="#FFFFFF60", linewidths=0.2, label="wall"))
    if plan.table is not None:
        axes.plot([x + x0 for x in plan.ends()], [plan.table + z0] * 2, color=COLOURS[0], linestyle="-.",
                  label="water table")
    for gauge, colour in zip(plan.gauges, cycle(COLOURS[2:])):
        foot = float(plan.ground.at(gauge.at)) + z0
        axes.plot([gauge.at + x0] * 2, [foot, foot + gauge.height], color=colour, linestyle="--",
                  label=f"gauge {gauge.name}")
    axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", xlim=[x + x0 for x in plan.ends()],
             ylim=(bottom, bottom + made.cells[1] * plan.cell_size))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=4)
    return save(figure, path)
