# SPDX-License-Identifier: BSD-3-Clause
"""A picture of a scene before it runs: slope, mass and barrier from above, and a section through them."""

from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.colors import LightSource
from plotting.style import COLOURS, STRUCTURE, plt, save

from .scene import Made


def draw_map(axes: plt.Axes, made: Made) -> None:
    """Shaded slope with contour lines, depth of the mass, barrier; coordinates of the world."""
    h = made.slope.spacing
    x0, y0, z0 = made.origin
    width, length = made.slope.size()
    extent = (x0, x0 + width, y0, y0 + length)
    shade = LightSource(azdeg=315, altdeg=45).hillshade(made.slope.z, vert_exag=1, dx=h, dy=h)
    axes.imshow(shade, cmap="gray", origin="lower", extent=extent, vmin=-0.3, vmax=1)
    rows, columns = made.slope.z.shape
    lines = axes.contour(x0 + h * np.arange(columns), y0 + h * np.arange(rows), made.slope.z + z0, 12, colors="k",
                         linewidths=0.4, alpha=0.6)
    axes.clabel(lines, fontsize=7, fmt="%g")
    depth = np.where(made.columns.depth > 0, made.columns.depth, np.nan)
    mass = axes.imshow(depth, cmap="YlOrBr", origin="lower", extent=extent, vmin=0, alpha=0.85)
    axes.figure.colorbar(mass, ax=axes, label="depth of the mass [m]", shrink=0.8)
    if made.plan.barrier is not None:
        axes.plot(*made.plan.barrier.line.T, color=COLOURS[0], linewidth=3, label="barrier")
    for gauge, colour in zip(made.plan.gauges, cycle(COLOURS[2:])):
        axes.plot(*gauge.line.T, color=colour, linewidth=1.5, linestyle="--", label=f"gauge {gauge.name}")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="from above")
    axes.ticklabel_format(useOffset=False, style="plain")
    axes.grid(False)


def section_line(made: Made) -> tuple[np.ndarray, np.ndarray]:
    """Line through the mass towards the barrier, else down the mean slope under the mass; it goes to the rim at both
    ends."""
    h = made.slope.spacing
    depth = made.columns.depth
    j, i = np.indices(depth.shape)
    centre = np.array([(depth * (i + 0.5)).sum(), (depth * (j + 0.5)).sum()]) / depth.sum() * h
    if made.wall is not None:
        direction = made.wall.crest[:2] - centre
    else:
        fall_y, fall_x = np.gradient(made.slope.z, h)
        under = depth > 0
        direction = -np.array([fall_x[:-1, :-1][under].mean(), fall_y[:-1, :-1][under].mean()])
    if not np.linalg.norm(direction) > 0:
        direction = np.array([1.0, 0.0])
    direction = direction / np.linalg.norm(direction)
    way = np.linspace(-1, 1, 4001) * sum(made.slope.size())
    places = centre + way[:, None] * direction
    inside = ((places >= 0) & (places <= np.array(made.slope.size()))).all(axis=1)
    return places[inside], way[inside] - way[inside][0]


def draw_section(axes: plt.Axes, made: Made) -> None:
    """Slope, mass and barrier along that line, as high as wide."""
    places, way = section_line(made)
    h, z0 = made.slope.spacing, made.origin[2]
    ground = made.slope.at(*places.T) + z0
    index = np.minimum((places / h).astype(int), np.array(made.columns.depth.shape)[::-1] - 1)
    depth = made.columns.depth[index[:, 1], index[:, 0]]
    axes.fill_between(way, np.nanmin(ground) - 2 * h, ground, color="0.8")
    axes.plot(way, ground, color="k", linewidth=1, label="slope")
    axes.fill_between(way, ground, np.where(depth > 0, ground + depth, np.nan), color=COLOURS[1], label="mass")
    if made.wall is not None:
        barrier = made.plan.barrier
        near = np.argmin(np.linalg.norm(places - made.wall.crest[:2], axis=1))
        axes.add_patch(plt.Rectangle((way[near] - barrier.thickness / 2, ground[near]), barrier.thickness,
                                     barrier.height,
                                     color=STRUCTURE, label="barrier"))
    axes.set(xlabel="along the section [m]", ylabel="z [m]", aspect="equal", title="section through mass and barrier"
             if made.wall is not None else "section down the slope")
    axes.legend(loc="upper right")


def draw(made: Made, path: Path) -> Path:
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(9, 8.5), height_ratios=(1.6, 1))
    draw_map(top, made)
    draw_section(bottom, made)
    return save(figure, path)
