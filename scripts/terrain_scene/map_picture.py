# SPDX-License-Identifier: BSD-3-Clause
"""Maps of results on a hillshade, in coordinates of the world, and sections along lines."""

from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.colors import LightSource
from plotting.style import COLOURS, STRUCTURE, new_figure, plt, save

from .raster import Raster

WIDTH = 7.5  # of a map [inch]
AROUND = 5  # cells of the raster around what is drawn


@dataclass
class Drawn:
    """Lines that are drawn over the results, in coordinates of the world: lines n x 2 by name, rings of the release."""

    barrier: np.ndarray | None
    gauges: dict[str, np.ndarray]
    sections: dict[str, np.ndarray]
    release: list[np.ndarray]


def part_of(raster: Raster, low: np.ndarray, high: np.ndarray) -> Raster:
    """The part between two corners, and some cells around it."""
    rows, columns = raster.values.shape
    i, k = (max(0, int((low[n] - (raster.x, raster.y)[n]) / raster.spacing) - AROUND) for n in (0, 1))
    j, m = (int((high[n] - (raster.x, raster.y)[n]) / raster.spacing) + 2 + AROUND for n in (0, 1))
    values = raster.values[k:min(m, rows), i:min(j, columns)]
    return Raster(raster.path, raster.x + i * raster.spacing, raster.y + k * raster.spacing, raster.spacing, values)


def extent_of(raster: Raster) -> tuple[float, float, float, float]:
    half = raster.spacing / 2
    low_x, low_y, high_x, high_y = raster.limits()
    return low_x - half, high_x + half, low_y - half, high_y + half


def draw_map(slope: Raster, result: Raster, title: str, drawn: Drawn, path: Path) -> Path:
    """slope: part of the raster that is shown; result: values on its cells, or a part of them."""
    left, right, low, high = extent_of(slope)
    height = WIDTH * np.clip((high - low) / (right - left), 0.3, 2)
    figure, axes = plt.subplots(figsize=(WIDTH + 1.6, height + 0.8))
    shade = LightSource(azdeg=315, altdeg=45).hillshade(slope.values, dx=slope.spacing, dy=slope.spacing)
    axes.imshow(np.where(np.isnan(slope.values), np.nan, shade), cmap="gray", origin="lower", extent=extent_of(slope),
                vmin=-0.3, vmax=1, interpolation="bilinear")
    if np.nanmax(slope.values) > np.nanmin(slope.values):
        x, y = (start + slope.spacing * np.arange(count) for start,
                count in zip((slope.x, slope.y), slope.values.shape[::-1]))
        axes.clabel(axes.contour(x, y, slope.values, 12, colors="k", linewidths=0.4, alpha=0.5), fontsize=7, fmt="%g")
    values = np.ma.masked_invalid(result.values)
    most = float(np.percentile(values.compressed(), 99.5)) if values.count() else 1.0
    image = axes.imshow(values, cmap="viridis", origin="lower", extent=extent_of(result), vmin=0, vmax=most or 1.0,
                        alpha=0.85,
                        interpolation="nearest")
    beyond = "max" if values.count() and values.max() > most else "neither"
    figure.colorbar(image, ax=axes, shrink=0.7, label=title, extend=beyond)
    draw_lines(axes, drawn)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(left, right), ylim=(low, high))
    axes.ticklabel_format(useOffset=False, style="plain")
    axes.tick_params(axis="x", labelrotation=30)
    axes.grid(False)
    return save(figure, path)


def draw_lines(axes: plt.Axes, drawn: Drawn) -> None:
    for k, ring in enumerate(drawn.release):
        axes.plot(*np.vstack([ring, ring[:1]]).T, color="w", linewidth=1.6)
        axes.plot(*np.vstack([ring, ring[:1]]).T, color=COLOURS[1], linewidth=1, label=None if k else "release")
    if drawn.barrier is not None:
        axes.plot(*drawn.barrier.T, color=COLOURS[3], linewidth=2.5, label="barrier")
    colours = cycle([COLOURS[k] for k in range(len(COLOURS)) if k not in (1, 3)])
    for name, line in drawn.gauges.items():
        axes.plot(*line.T, color=next(colours), linewidth=1.5, linestyle="--", label=f"gauge {name}")
    for name, line in drawn.sections.items():
        axes.plot(*line.T, color="k", linewidth=1, linestyle="-.", label=f"section {name}")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=3, fontsize=9)


def along(line: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Places on a line n x 2 at most `step` apart [m], its corners among them, and the distance along the line to
    each."""
    parts = [line[:1]]
    for start, end in zip(line[:-1], line[1:]):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / step - 1e-9)))
        parts.append(start + (end - start) * np.arange(1, count + 1)[:, None] / count)
    places = np.concatenate(parts)
    return places, np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])


def cell_values(raster: Raster, places: np.ndarray) -> np.ndarray:
    """Value of the cell that each place lies in, nan outside."""
    i, j = (np.floor((places[:, k] - (raster.x, raster.y)[k]) / raster.spacing + 0.5).astype(int) for k in (0, 1))
    inside = (i >= 0) & (i < raster.values.shape[1]) & (j >= 0) & (j < raster.values.shape[0])
    values = np.full(len(places), np.nan)
    values[inside] = raster.values[j[inside], i[inside]]
    return values


def write_section(name: str, line: np.ndarray, slope: Raster, results: dict[str, Raster], folder: Path) -> list[Path]:
    """section_NAME.csv and .png: ground (bilinear), and the results of the cells that the line crosses."""
    places, way = along(line, slope.spacing / 2)
    ground = slope.at(*places.T)
    fields = {key: cell_values(raster, places) for key, raster in results.items()}
    table = folder / f"section_{name}.csv"
    rows = np.column_stack([way, places, ground, *fields.values()])
    np.savetxt(table, rows, delimiter=",", header=",".join(["way", "x", "y", "ground", *fields]), comments="",
               fmt="%.12g")
    figure, (upper, middle, lower) = new_figure(9.5, 8, 3)
    upper.plot(way, ground, color="k", linewidth=1)
    upper.set(ylabel="z [m]", title=f"section {name}")
    dry = {key: np.nan_to_num(values) for key, values in fields.items()}
    middle.fill_between(way, dry["depth"], step="mid", color=COLOURS[1], alpha=0.6, label="at the end")
    middle.step(way, dry["max_depth"], where="mid", color=STRUCTURE, linewidth=1, label="largest")
    middle.set_ylabel("depth [m]")
    middle.legend(loc="upper right")
    lower.step(way, dry["max_speed"], where="mid", color=COLOURS[0])
    lower.set(ylabel="largest speed [m/s]", xlabel="along the section [m]")
    return [table, save(figure, folder / f"section_{name}.png")]
