# SPDX-License-Identifier: BSD-3-Clause
"""The scene at chosen times: soil points coloured by a field, structure as a deformed mesh, rigid walls as lines."""

from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize

from plotting.boulders import Boulders
from plotting.ground import FLOOR, MOST, ground_of
from plotting.results import Frame, Results, ResultsError, Series, evenly
from plotting.style import STRUCTURE, new_figure, plt, save
from plotting.view import once, plane_view, view_of
from plotting.walls import Walls, strokes, widened

UNITS = {
    "displacement": "m",
    "velocity": "m/s",
    "acceleration": "m/s²",
    "plastic_strain": "-",
    "softening_strain": "-",
    "slip": "m",
    "volume_ratio": "-",
    "stress": "Pa",
    "pressure": "Pa",
    "cohesion": "Pa",
    "modulus": "Pa",
    "cutoff": "Pa",
    "angle": "°",
    "yield_stress": "Pa",
    "volume": "m³",
    "mass": "kg",
}

BOULDER = (0.55, 0.5, 0.46)  # colour of boulders
LINES = "#1A1A1A"  # colour of ropes, bars and beams
TALL = 5.5  # height over which instants stand in pairs [inch]
SAMPLES = 9  # frames of a series that window and colours are chosen by

# Octagon of diameter 1.4: neighbours at distance 1 overlap without holes.
_ANGLES = np.pi / 4 * np.arange(8) + np.pi / 8
DISC = 0.7 * np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])


def scalar(values: np.ndarray) -> np.ndarray:
    """A vector's length, a scalar as it is; num_points."""
    return values if values.ndim == 1 else np.linalg.norm(values, axis=1)


def label_of(field: str, values: np.ndarray) -> str:
    words = field.replace("_", " ")
    unit = next((unit for name, unit in UNITS.items() if name in field), "")
    return f"{'size of ' if values.ndim > 1 else ''}{words}{f' [{unit}]' if unit else ''}"


def _first_with_points(soil: Series | None) -> Frame | None:
    """None: no soil, or none in any frame."""
    frames = (soil.frame(k) for k in range(len(soil))) if soil else ()
    return next((frame for frame in frames if len(frame.points)), None)


def point_size(points: np.ndarray, dim: int) -> float:
    """Mean distance of points [m]."""
    extent = np.ptp(points[:, :dim], axis=0)
    if dim == 2:
        return float(np.sqrt(max(np.prod(extent), 1e-12) / len(points)))
    size = float(extent.max())
    for _ in range(30):  # the body is one distance larger than its points, which counts in a thin slice
        size = float(np.cbrt(np.prod(extent + size) / len(points)))
    return size


class ScenePlot:
    """Draws one instant at a time with the same plane, window and colours for all instants.

    field: soil field that gives the colour; default: displacement, else the first one there is.
    plane: axes to the right and upwards, such as "xy"; default: of gravity and the longest horizontal extent.
    most_ground: triangles of the ground.
    """

    def __init__(self, results: Results, field: str | None = None, plane: str | None = None, most_ground: int = MOST):
        self.most_ground = most_ground
        self.first = _first_with_points(results.soil)
        self.soil = results.soil if self.first else None
        self.structures = results.structures
        self.beam_surfaces = results.beam_surfaces
        self.lines = results.lines
        self.rigid_walls = Walls(results)
        self.boulders = Boulders(results)
        series = next((s for s in (self.soil, *self.structures) if s), None)
        if series is None:
            raise ResultsError(f"{results.folder}: neither points in mpm/soil.xdmf nor fem/structure.xdmf")
        self.times = series.times
        self.field = field
        last = series.frame(len(series) - 1)
        if self.soil:
            self.field = self._choose(last, field)
            self.size = point_size(self.first.points, results.dim)
        self._window(results, plane)
        self._colours()

    def _choose(self, frame: Frame, field: str | None) -> str:
        names = list(frame.fields)
        if field is not None and field not in names:
            raise ResultsError(f"{self.soil.path}: no field {field}; there are {', '.join(names)}")
        return field or next((n for n in ("displacement", "velocity") if n in names), names[0])

    def _sample(self, series: Series) -> list[Frame]:
        """Some frames, without those whose points have all left or are not there yet."""
        frames = [series.frame(i) for i in evenly(len(series), SAMPLES)]
        return [frame for frame in frames if len(frame.points)] or [self.first]

    def _window(self, results: Results, plane: str | None) -> None:
        clouds = [f.points for f in self._sample(self.soil)] if self.soil else []
        for structure in self.structures:
            clouds += [f.points for f in self._sample(structure)]
        times = self.times[evenly(len(self.times), SAMPLES)]
        clouds += [faces.reshape(-1, 3) for time in times for faces in self.boulders.at(time)]
        every = np.vstack(clouds)
        if plane is None:
            self.view = view_of(results.dim, results.gravity, np.ptp(every, axis=0))
        elif results.dim == 2:
            raise ResultsError(f"{results.folder}: plane {plane} of a scene in 2D; only scenes in 3D have a choice")
        else:
            self.view = plane_view(results.dim, plane)
        every = self.view.project(every)
        walls = [segments for time in times for segments in self.rigid_walls.at(time)]
        self.ground = self._ground(ground_of(results, self.most_ground))
        ground = self.ground[0].reshape(-1, 2)
        if len(ground):
            walls.append(np.stack([ground.min(axis=0), ground.max(axis=0)])[None])
        low, high = widened(every.min(axis=0), every.max(axis=0), walls)
        margin = 0.04 * (high - low).max()
        self.low, self.high = low - margin, high + margin

    def _ground(self, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles in the picture, those behind first, n x 3 x 2 [m], and how bright each is: the more it looks
        upwards."""
        if not len(triangles):
            return np.zeros((0, 3, 2)), np.zeros(0)
        triangles = triangles[self.view.order(triangles.mean(axis=1))]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        level = np.abs(normals[:, self.view.up]) / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
        return self.view.project(triangles), 0.6 + 0.4 * level

    def _draw_ground(self, axes: Axes) -> None:
        """Draw the ground behind all else: from the side it would hide the soil in a gully."""
        triangles, bright = self.ground
        colours = FLOOR * bright[:, None]
        axes.add_collection(PolyCollection(triangles, facecolors=colours, edgecolors=colours, linewidths=0.2,
                                           rasterized=True))

    def _colours(self) -> None:
        if not self.soil:
            return
        values = np.concatenate([scalar(f.fields[self.field]) for f in self._sample(self.soil)])
        # A few points that fly far must not take up the whole scale.
        low, high = np.nanmin(values), np.nanpercentile(values, 99.5)
        self.norm = Normalize(low, high if high > low else low + 1)
        self.beyond = "max" if np.nanmax(values) > 1.01 * high else "neither"

    def _draw_soil(self, axes: Axes, time: float) -> PolyCollection:
        frame = self.soil.frame(self.soil.nearest(time))
        order = self.view.order(frame.points)
        discs = self.view.project(frame.points)[order, None] + self.size * DISC[None]
        values = scalar(frame.fields[self.field])[order]
        soil = PolyCollection(discs, array=values, cmap="viridis", norm=self.norm, linewidths=0)
        return axes.add_collection(soil)

    def _draw_structure(self, axes: Axes, structure: Series, time: float) -> None:
        """The mesh as it is at `time`, without cells that failed, and its outline at the start, dotted.

        In space soil beside it shines through.
        """
        frame = structure.frame(structure.nearest(time))
        if frame.cells is None or len(frame.cells) == 0:  # lines alone
            return
        first = structure.frame(0)
        faces = self.view.faces(frame.points, frame.standing)
        edges = _outline(self.view.faces(first.points, first.corners))
        colour = (0.74, 0.74, 0.74, 1 if self.view.dim == 2 else 0.7)
        axes.add_collection(PolyCollection(self.view.project(frame.points[faces]), facecolor=colour,
                                           edgecolor=STRUCTURE, linewidth=0.4))
        axes.add_collection(LineCollection(self.view.project(first.points[edges]),
                                           colors=STRUCTURE, linewidths=0.8, linestyles=":"))

    def _draw_beams(self, axes: Axes, time: float) -> None:
        """The soil's copy of the surfaces around beams."""
        for series in self.beam_surfaces:
            frame = series.frame(series.nearest(time))
            facets = self.view.project(frame.points)[frame.cells]
            if facets.shape[1] == 2:
                axes.add_collection(LineCollection(facets, colors=STRUCTURE, linewidths=0.8))
            else:
                axes.add_collection(PolyCollection(facets, facecolor=(0.74, 0.74, 0.74, 0.7), edgecolor="none"))

    def _draw_lines(self, axes: Axes, time: float) -> None:
        """Ropes, bars and beams, over all else: they are thinner than a stroke."""
        for series in self.lines:
            frame = series.frame(series.nearest(time))
            axes.add_collection(LineCollection(self._project(frame.points)[frame.cells], colors=LINES, linewidths=0.9))

    def _project(self, points: np.ndarray) -> np.ndarray:
        return self.view.project(points)

    def wall_lines(self, time: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """Segments of each rigid wall that acts at `time`, and the strokes behind them."""
        window = (self.high - self.low).max()
        return [(segments, strokes(segments, window)) for segments in self.rigid_walls.at(time)]

    def _draw_walls(self, axes: Axes, time: float) -> None:
        for segments, behind in self.wall_lines(time):
            axes.add_collection(LineCollection(segments, colors=STRUCTURE, linewidths=1.4, capstyle="round"))
            axes.add_collection(LineCollection(behind, colors=STRUCTURE, linewidths=0.6))

    def _draw_boulders(self, axes: Axes, time: float) -> None:
        for faces in self.boulders.at(time):
            axes.add_collection(PolyCollection(self.view.project(faces), facecolor=BOULDER, edgecolor=STRUCTURE,
                                               linewidth=0.6))

    def draw(self, axes: Axes, time: float) -> PolyCollection | None:
        """Draw the instant nearest to `time`; returns what a colour bar needs."""
        instant = self.times[np.argmin(np.abs(self.times - time))]
        if len(self.ground[1]):
            self._draw_ground(axes)
        soil = self._draw_soil(axes, time) if self.soil else None
        for structure in self.structures:
            self._draw_structure(axes, structure, time)
        self._draw_beams(axes, time)
        self._draw_walls(axes, instant)
        self._draw_boulders(axes, instant)
        self._draw_lines(axes, time)
        axes.set_aspect("equal")
        axes.set_xlim(self.low[0], self.high[0])
        axes.set_ylim(*((self.high[1], self.low[1]) if self.view.inverted else (self.low[1], self.high[1])))
        axes.set_ylabel(self.view.labels[1])
        axes.set_title(f"t = {instant:.3g} s", loc="left")
        return soil

    def height_inch(self, width: float) -> float:
        """Height of axes of this width with equal scales [inch]."""
        extent = self.high - self.low
        return float(np.clip(0.72 * width * extent[1] / extent[0], 1.2, 8.0))

    def colour_bar(self, figure: plt.Figure, soil: PolyCollection, axes: list[Axes], rows: int = 1) -> None:
        values = self.soil.frame(0).fields[self.field]
        figure.colorbar(soil, ax=axes, label=label_of(self.field, values),
                        extend=self.beyond, shrink=min(1.0, 2.2 / rows),
                        aspect=18, anchor=(0.0, 1.0))


def _outline(cells: np.ndarray) -> np.ndarray:
    """Edges that belong to one cell (or face) only, num_edges x 2."""
    return once(np.concatenate([cells[:, [i, (i + 1) % cells.shape[1]]] for i in range(cells.shape[1])]))


def plot_scene(scene: ScenePlot, times: list[float] | None, out: Path) -> Path:
    """The scene at the given times, four evenly spaced ones by default, below each other, tall ones in pairs."""
    chosen = times or list(np.unique(np.linspace(scene.times[0], scene.times[-1], 4)))
    in_a_row = 2 if len(chosen) > 1 and scene.height_inch(8.5) > TALL else 1
    rows = -(-len(chosen) // in_a_row)
    size = 8.5, 0.4 + (0.3 + scene.height_inch(8.5 / in_a_row)) * rows
    figure, grid = plt.subplots(rows, in_a_row, figsize=size, sharex=True, sharey=True, squeeze=False)
    soil = None
    for each, time in zip(grid.flat, chosen):
        soil = scene.draw(each, time)
    for each in grid.flat[len(chosen):]:
        each.remove()
    for column in range(in_a_row):
        lowest = (len(chosen) - 1 - column) // in_a_row
        grid[lowest, column].set_xlabel(scene.view.labels[0])
        grid[lowest, column].tick_params(labelbottom=True)
    for each in grid[:, 1:].flat:
        each.set_ylabel("")
    if soil is not None:
        scene.colour_bar(figure, soil, list(grid.flat[:len(chosen)]), rows)
    return save(figure, out / "scene.png")


def animate_scene(scene: ScenePlot, out: Path, max_frames: int = 120) -> Path:
    """The run as a GIF of at most `max_frames` frames."""
    picked = evenly(len(scene.times), max_frames)
    figure, (axes,) = new_figure(8.5, 1.1 + scene.height_inch(8.5))
    soil = scene.draw(axes, scene.times[0])
    if soil is not None:
        scene.colour_bar(figure, soil, [axes])

    def draw(index: int) -> list:
        axes.clear()
        scene.draw(axes, scene.times[index])
        axes.set_xlabel(scene.view.labels[0])
        return []

    out.mkdir(parents=True, exist_ok=True)
    path = out / "scene.gif"
    FuncAnimation(figure, draw, frames=picked).save(path, writer=PillowWriter(fps=15), dpi=90)
    plt.close(figure)
    return path
