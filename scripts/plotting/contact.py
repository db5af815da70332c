# SPDX-License-Identifier: BSD-3-Clause
"""Pressure of the soil on an interface or a rigid wall: profiles at chosen times, and over all of them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plotting.faces import Face, faces_of, facet_vectors, upright_share
from plotting.results import CONTACT, Frame, Results, Series
from plotting.style import COLOURS, plt, save
from plotting.view import AXES, up_axis

NUM_TIMES = 5
NUM_BINS = 40
CORNER = 0.87  # cosine of the turn from which on a line has a corner
MOSTLY = 0.5  # part of a surface that is upright, from which on its faces are drawn by themselves
STEEP = 0.99  # sine of the least inclination of what counts as upright


def contact_series(results: Results) -> dict[str, Series]:
    """Name of the interface, wall or boulder -> its frames."""
    return results.contacts


def chain(cells: np.ndarray) -> np.ndarray:
    """Numbers of segments in the order in which they follow each other; one line after the other."""
    following = {start: number for number, start in enumerate(cells[:, 0])}
    ends = set(cells[:, 1])
    heads = [number for number, start in enumerate(cells[:, 0]) if start not in ends]
    order: list[int] = []
    seen: set[int] = set()
    for first in [*heads, *range(len(cells))]:
        number = first
        while number is not None and number not in seen:
            seen.add(number)
            order.append(number)
            number = following.get(cells[number, 1])
    return np.array(order)


@dataclass(frozen=True)
class Profile:
    """Positions of the facets along the axis over which pressure is drawn, by the first frame.

    edges: of the intervals [m]; interval: of each facet; area: of each facet [m] or [m²];
    corners: of a line [m].
    """

    label: str
    edges: np.ndarray
    interval: np.ndarray
    area: np.ndarray
    corners: tuple[float, ...] = ()

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over the facets of each interval, by area; NaN where there is none."""
        count = len(self.edges) - 1
        area = np.bincount(self.interval, self.area, count)
        total = np.bincount(self.interval, self.area * values, count)
        return np.divide(total, area, out=np.full(count, np.nan), where=area > 0)


def profile_of(frame: Frame, dim: int, up: int) -> Profile:
    """A line: along its length, or by height when it is upright.

    In space: by height, or along the longest horizontal axis when it is flat.
    """
    vectors = facet_vectors(frame.points, frame.cells)
    area = np.linalg.norm(vectors, axis=1)
    along_up = np.abs(vectors[:, up]) / area
    if dim == 2:
        order = chain(frame.cells)
        length = np.concatenate([[0.0], np.cumsum(area[order])])
        interval = np.empty(len(order), dtype=int)
        interval[order] = np.arange(len(order))
        if (along_up < STEEP).any() or np.ptp(np.sign(vectors[:, up])) != 0:
            ways = vectors[order] / area[order, None]
            turns = np.sum(ways[1:] * ways[:-1], axis=1) < CORNER
            return Profile("length along the surface [m]", length, interval, area, tuple(length[1:-1][turns]))
        height = frame.points[frame.cells[order[0], 0], up] + np.sign(vectors[0, up]) * length
        if height[0] > height[-1]:
            return Profile(f"{AXES[up]} [m]", height[::-1], len(order) - 1 - interval, area)
        return Profile(f"{AXES[up]} [m]", height, interval, area)
    centres = frame.points[frame.cells].mean(axis=1)
    upright = np.sum(area * along_up) < 0.5 * np.sum(area)
    axis = up if upright else int(np.argmax(np.where(np.arange(3) == up, -1, np.ptp(frame.points, axis=0))))
    low, high = frame.points[:, axis].min(), frame.points[:, axis].max()
    along = np.abs(vectors[:, axis]) < 0.99 * area  # end faces lie on the edge of an interval
    layers = len(np.unique(centres[along, axis].round(9)))
    edges = np.linspace(low, high, min(NUM_BINS, layers) + 1)
    interval = np.clip(np.searchsorted(edges, centres[:, axis]) - 1, 0, len(edges) - 2)
    return Profile(f"{AXES[axis]} [m]", edges, interval, area)


def _chosen(series: Series, pressure: np.ndarray, times: list[float] | None) -> np.ndarray:
    """Numbers of the frames to draw: nearest to `times`, else evenly from the first contact to the end."""
    if times:
        return np.unique([series.nearest(time) for time in times])
    touched = np.flatnonzero((pressure > 0).any(axis=1))
    return np.unique(np.linspace(touched[0], len(series) - 1, NUM_TIMES).astype(int))


def _draw_profiles(axes: Axes, label: str, edges: np.ndarray, pressure: np.ndarray, times: np.ndarray) -> None:
    for k, (values, time) in enumerate(zip(pressure, times)):
        axes.stairs(np.nan_to_num(values), edges, orientation="horizontal", baseline=None,
                    color=COLOURS[k % len(COLOURS)], linestyle=("-", "--", ":")[k // len(COLOURS) % 3],
                    lw=1.4, label=f"{time:.3g} s")
    axes.set_xlabel("pressure [Pa]")
    axes.set_ylabel(label)
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=NUM_TIMES, fontsize=9, handlelength=1,
                columnspacing=0.8)


def draw_history(figure: Figure, axes: Axes, series: Series, edges: np.ndarray, pressure: np.ndarray,
                 chosen: np.ndarray) -> None:
    """Pressure over place and time, with marks at the chosen frames. pressure: frames x places."""
    axes.grid(False)
    if len(series) > 1:
        middles = (series.times[1:] + series.times[:-1]) / 2
        borders = np.concatenate([series.times[:1], middles, series.times[-1:]])
        image = axes.pcolormesh(borders, edges, pressure.T, cmap="viridis", rasterized=True)
        figure.colorbar(image, ax=axes, label="pressure [Pa]")
    for k, time in enumerate(series.times[chosen]):
        axes.axvline(time, color=COLOURS[k % len(COLOURS)], lw=1)
    axes.set_xlabel("time [s]")


def plot_contact(results: Results, name: str, series: Series, times: list[float] | None,
                 out: Path) -> Path | None:
    """Left: pressure at some times over the height or length; right: over all times. None without contact.

    A wall has a row for each upright face that soil pressed on, over the height above its foot.
    """
    dim, up = results.dim, up_axis(results.dim, results.gravity)
    first = series.frame(0)
    profile = profile_of(first, dim, up)
    if upright_share(first, dim, up) >= MOSTLY:
        faces = faces_of(name, series, dim, up)
        touched = [face for face in faces if np.nanmax(face.pressure, initial=0) > 0]
        if touched and (len(faces) > 1 or profile.corners):
            return plot_faces(name, series, touched, times, out)
    pressure = np.array([profile.mean(series.frame(k).fields["pressure"]) for k in range(len(series))])
    if not np.nanmax(pressure) > 0:
        return None
    chosen = _chosen(series, pressure, times)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6), sharey=True, width_ratios=[1, 1.2])
    _draw_profiles(left, profile.label, profile.edges, pressure[chosen], series.times[chosen])
    draw_history(figure, right, series, profile.edges, pressure, chosen)
    right.set_title(name.replace("_", " "), loc="left")
    for axes in (left, right):
        for corner in profile.corners:
            axes.axhline(corner, color="0.6", lw=0.8, ls=":")
    return save(figure, out / f"{CONTACT}{name}.png")


def plot_faces(name: str, series: Series, faces: list[Face], times: list[float] | None, out: Path) -> Path:
    """A row a face; all have the same times."""
    chosen = _chosen(series, np.hstack([face.pressure for face in faces]), times)
    figure, rows = plt.subplots(len(faces), 2, figsize=(11, 0.6 + 4 * len(faces)), sharey="row", squeeze=False,
                                width_ratios=[1, 1.2])
    for face, (left, right) in zip(faces, rows):
        _draw_profiles(left, "height above its foot [m]", face.edges, face.pressure[chosen], series.times[chosen])
        draw_history(figure, right, series, face.edges, face.pressure, chosen)
        right.set_title(f"{name.replace('_', ' ')}, side {face.side}", loc="left")
    return save(figure, out / f"{CONTACT}{name}.png")


def plot_contacts(results: Results, times: list[float] | None, out: Path) -> list[Path | None]:
    """The frames without boulders, which have a picture of their own."""
    return [plot_contact(results, name, series, times, out) for name, series in results.surfaces.items()]
