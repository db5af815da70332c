# SPDX-License-Identifier: BSD-3-Clause
"""Final surface of a collapsed column against an experiment."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plotting.results import Frame, Results, ResultsError
from plotting.style import COLOURS, legend_beside, new_figure, save


@dataclass
class SurfaceError:
    """Simulated minus measured surface."""

    mean_abs_m: float  #: mean of |height difference| over the measured positions under the deposit
    max_abs_m: float  #: largest |height difference|
    max_at_m: float  #: its position x
    front_m: float  #: simulated position of the front
    front_measured_m: float

    def __str__(self) -> str:
        return (
            f"height error: mean {1e3 * self.mean_abs_m:.1f} mm, largest {1e3 * self.max_abs_m:.1f} mm "
            f"at x = {1e3 * self.max_at_m:.0f} mm; front {1e3 * self.front_m:.0f} mm, "
            f"measured {1e3 * self.front_measured_m:.0f} mm"
        )


def read_reference(path: Path) -> dict[str, np.ndarray]:
    """Series name -> num_points x 2 (x, height) [m]. Lines that start with # are remarks.

    @raises ResultsError  no such file, or a row that is not a name and two numbers
    """
    series: dict[str, list[tuple[float, float]]] = {}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            for row in csv.reader(line for line in file if not line.startswith("#")):
                if row and row[0] != "series":
                    series.setdefault(row[0], []).append((float(row[1]), float(row[2])))
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}") from None
    except (ValueError, IndexError):
        raise ResultsError(f"{path}: found a row {row}, allowed: a series' name, x and height [m]") from None
    return {name: np.array(points) for name, points in series.items()}


def surface_of(points: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Free surface of a cloud of points: the highest point of each bin of width 3 `spacing`.

    points: num_points x 2 (or 3) [m]; spacing: mean distance of points at the start [m].
    A point stands for a square of that side, hence half of it is added to the height.
    returns: positions of these points and heights [m]; an empty bin has height 0 at its centre.
    """
    width = 3 * spacing
    count = int(points[:, 0].max() / width) + 2
    x, height = width * (np.arange(count) + 0.5), np.zeros(count)
    upwards = points[np.argsort(points[:, 1])]
    index = np.clip(upwards[:, 0] / width, 0, count - 1).astype(int)
    for i in np.unique(index):
        top = upwards[np.flatnonzero(index == i)[-1]]
        x[i], height[i] = top[0], top[1] + 0.5 * spacing
    return x, height


def front_of(points: np.ndarray, spacing: float) -> float:
    """Position of the front [m]: where the connected deposit ends, single grains left aside."""
    x = np.sort(points[:, 0])
    gaps = np.flatnonzero(np.diff(x) > 4 * spacing)
    behind = x[: gaps[0] + 1] if len(gaps) else x
    return float(behind[-1] + 0.5 * spacing)


def area_under(x: np.ndarray, height: np.ndarray) -> float:
    """Area under a surface of surface_of [m^2]; left of the first point it is level."""
    return float(np.sum(0.5 * (height[1:] + height[:-1]) * np.diff(x)) + height[0] * x[0])


def compare_surface(points: np.ndarray, spacing: float, measured: np.ndarray) -> SurfaceError:
    """Height differences at the measured positions that either deposit covers."""
    x, height = surface_of(points, spacing)
    front, front_measured = front_of(points, spacing), float(measured[measured[:, 1] > 5e-4, 0].max())
    covered = measured[measured[:, 0] <= max(front, front_measured)]
    difference = np.abs(np.interp(covered[:, 0], x, height, right=0) - covered[:, 1])
    worst = int(np.argmax(difference))
    return SurfaceError(
        float(difference.mean()), float(difference[worst]), float(covered[worst, 0]), front, front_measured
    )


def failure_line(last: Frame, x: np.ndarray, moved: float, spacing: float) -> np.ndarray:
    """Upper border of the soil that stayed, in the configuration at the start.

    last: frame with the field displacement [m]; x: positions at the start [m]; moved: soil that went
    farther does not count as at rest [m]; spacing: mean distance of points at the start [m].
    returns: for each x, height below which no point within 1.5 spacings went farther than `moved`
    """
    u = last.fields["displacement"][:, :2]
    start = last.points[:, :2] - u
    far = np.linalg.norm(u, axis=1) > moved
    heights = np.empty(len(x))
    for i, position in enumerate(x):
        near = np.abs(start[:, 0] - position) <= 1.5 * spacing
        if not near.any():
            raise ResultsError(f"no soil at x = {position:g} m at the start")
        above = start[near & far, 1]
        heights[i] = above.min() - 0.5 * spacing if len(above) else start[near, 1].max() + 0.5 * spacing
    return heights


def plot_column(results: Results, reference: Path, out: Path) -> tuple[Path, SurfaceError]:
    """Draw the final deposit over the measured surface.

    reference: table with the series exp_surface and, if present, exp_failure_line… and others.
    """
    soil = results.frames_of_soil()
    series = read_reference(reference)
    if "exp_surface" not in series:
        raise ResultsError(f"{reference}: no series exp_surface; there are {', '.join(series)}")
    start, last = soil.frame(0), soil.frame(len(soil) - 1)
    spacing = float(np.sqrt(np.prod(np.ptp(start.points[:, :2], axis=0)) / len(start.points)))
    error = compare_surface(last.points, spacing, series["exp_surface"])

    figure, (axes,) = new_figure(10, 2.4)
    axes.plot(last.points[:, 0], last.points[:, 1], ".", ms=1.6, color="0.72", label="material points")
    axes.plot(*surface_of(last.points, spacing), color=COLOURS[0], label="simulated surface")
    for (name, points), colour in zip(series.items(), COLOURS[1:]):
        style = "o" if name == "exp_surface" else "--"
        label = name.replace("exp_", "measured_").replace("_", " ")
        axes.plot(*points.T, style, ms=4, color=colour, label=label)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("height [m]")
    axes.set_title(f"t = {last.time:.3g} s: {error}", loc="left", fontsize=9)
    legend_beside(axes)
    return save(figure, out / "column.png"), error
