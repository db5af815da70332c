# SPDX-License-Identifier: BSD-3-Clause
"""A scene in space as it is seen: surface of the soil, deformed structures, rigid walls, shaded. No display is
needed."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection

from plotting.ground import FLOOR, ground_of
from plotting.results import Results, ResultsError, Series, evenly
from plotting.scene import BOULDER, DISC, ScenePlot, label_of, scalar
from plotting.style import new_figure, plt, save
from plotting.surface import surface_of
from plotting.view import FACES, outer_faces

STEEL = np.array([0.45, 0.52, 0.60])
SIDES = {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1), "bottom": (2, 0), "top": (2, 1)}
GRAIN = 0.5  # size of a loose point
TILES = 24  # of the side of a box along its longer edge
MAX_FRAMES = 80


@dataclass(frozen=True)
class Camera:
    """Direction of view, from far away: unit vectors to the right and upwards in the picture, and towards the eye."""

    right: np.ndarray
    up: np.ndarray
    eye: np.ndarray

    def project(self, points: np.ndarray) -> np.ndarray:
        return points @ np.stack([self.right, self.up], axis=1)

    def depth(self, points: np.ndarray) -> np.ndarray:
        return points @ self.eye


def camera_of(gravity: list[float] | None, extent: np.ndarray, azimuth: float, elevation: float) -> Camera:
    """A camera with gravity downwards.

    azimuth, elevation: of the eye [degrees]; at azimuth 0 the downhill direction, or the longest level one, runs to the
    right, at 90 it comes towards the eye.
    """
    g = np.array(gravity if gravity and np.any(gravity) else [0.0, 0.0, -1.0])
    vertical = -g / np.linalg.norm(g)
    main = np.argmax(np.abs(g))
    slope = np.where(np.arange(3) == main, 0.0, g)
    along = slope if np.linalg.norm(slope) > 1e-6 * np.linalg.norm(g) else np.eye(3)[np.argmax(np.where(
        np.arange(3) == main, 0.0, extent))]
    along = along - (along @ vertical) * vertical
    along /= np.linalg.norm(along)
    across = np.cross(along, vertical)  # towards the eye at azimuth 0
    a, e = np.radians([azimuth, elevation])
    level = np.cos(a) * across + np.sin(a) * along
    eye = np.cos(e) * level + np.sin(e) * vertical
    right = np.cross(vertical, level)
    return Camera(right, np.cross(eye, right), eye)


def shade(colours: np.ndarray, normals: np.ndarray, camera: Camera) -> np.ndarray:
    """Colours (n x 3, or one) under a light above the left shoulder."""
    light = camera.eye + 1.2 * camera.up - 0.7 * camera.right
    light /= np.linalg.norm(light)
    bright = 0.45 + 0.55 * np.clip(normals @ light, 0, 1)
    return np.clip(np.asarray(colours) * bright[:, None], 0, 1)


def normals_of(polygons: np.ndarray) -> np.ndarray:
    """Unit normals of polygons (n x corners x 3) by their first three corners."""
    normals = np.cross(polygons[:, 1] - polygons[:, 0], polygons[:, 2] - polygons[:, 0])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def box_side(low: list[float], high: list[float], side: str) -> np.ndarray:
    """Tiles of a side of a box with their normals outwards, num_tiles x 4 x 3."""
    axis, end = SIDES[side]
    low, high = np.array(low), np.array(high)
    first, second = [k for k in range(3) if k != axis]
    length = (high - low)[[first, second]]
    counts = np.maximum(np.round(TILES * length / length.max()).astype(int), 1)
    i, j = (k.ravel() for k in np.meshgrid(*map(np.arange, counts), indexing="ij"))
    tiles = np.empty((len(i), 4, 3))
    tiles[:, :, axis] = (low, high)[end][axis]
    for corner, (a, b) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        tiles[:, corner, first] = low[first] + length[0] * (i + a) / counts[0]
        tiles[:, corner, second] = low[second] + length[1] * (j + b) / counts[1]
    outwards = 1 if end else -1
    return tiles if normals_of(tiles)[0, axis] * outwards > 0 else tiles[:, ::-1]


def rigid_walls(results: Results) -> list[np.ndarray]:
    """The rigid walls that are sides of boxes, at their place at the start; the bottom of the grid where there is none,
    nor terrain.
    """
    settings = results.settings("mpm.json")
    walls = []
    for wall in settings.get("rigid_walls", []):
        box = wall["surface"].get("mesh", {}).get("box")
        if box:
            walls += [box_side(box["low"], box["high"], group) for group in wall["surface"]["groups"]]
    grid = settings.get("grid", {}).get("box")
    terrain = any("triangles" in wall["surface"] for wall in settings.get("rigid_walls", []))
    has_floor = any(wall["group"] == "bottom" for wall in settings.get("walls", []))
    if not walls and not terrain and grid and has_floor:
        walls.append(box_side(grid["low"], grid["high"], "bottom")[:, ::-1])
    return walls


class SpacePlot(ScenePlot):
    """Draws a scene in 3D with one camera, window and colours for all instants."""

    def __init__(self, results: Results, field: str | None, direction: tuple[float, float]):
        if results.dim != 3:
            raise ResultsError(f"{results.folder}: a scene in 2D has no view in space")
        self.walls = rigid_walls(results)
        self.ground = ground_of(results)
        self.direction = direction
        super().__init__(results, field)

    def _window(self, results: Results, plane: str | None) -> None:
        clouds = [f.points for series in (self.soil, *self.structures) if series for f in self._sample(series)]
        every = np.vstack([*clouds, *(wall.reshape(-1, 3) for wall in self.walls),
                           self.ground.reshape(-1, 3)])
        self.camera = camera_of(results.gravity, np.ptp(every, axis=0), *self.direction)
        seen = self.camera.project(every)
        margin = 0.03 * np.ptp(seen, axis=0).max()
        self.low, self.high = seen.min(axis=0) - margin, seen.max(axis=0) + margin

    def _project(self, points: np.ndarray) -> np.ndarray:
        return self.camera.project(points)

    def _wall_collection(self) -> PolyCollection | None:
        tiles = [wall for wall in self.walls if normals_of(wall)[0] @ self.camera.eye > 0]
        if not tiles:
            return None
        tiles = np.concatenate(tiles)
        colours = shade(FLOOR, normals_of(tiles), self.camera)
        return PolyCollection(self.camera.project(tiles), facecolors=colours, edgecolors=0.94 * colours, linewidths=0.3)

    def _colours_of(self, values: np.ndarray) -> np.ndarray:
        return plt.get_cmap("viridis")(self.norm(values))[:, :3]

    def _soil_parts(self, time: float) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Polygons, colours and normals of the surface, and of loose points as discs that face the eye."""
        frame = self.soil.frame(self.soil.nearest(time))
        values = scalar(frame.fields[self.field])
        surface = surface_of(frame.points, values, self.size)
        plane = np.stack([self.camera.right, self.camera.up])
        discs = frame.points[surface.loose, None] + self.size * (GRAIN * DISC @ plane)[None]
        return [(surface.triangles, self._colours_of(surface.values), surface.normals),
                (discs, self._colours_of(values[surface.loose]), np.tile(self.camera.eye, (len(discs), 1)))]

    def _structure_faces(self, structure: Series, time: float) -> np.ndarray:
        frame = structure.frame(structure.nearest(time))
        if frame.cells is None or frame.corners.shape[1] not in FACES:
            return np.zeros((0, 4, 3))
        return frame.points[outer_faces(frame.standing)]

    def _beam_faces(self, time: float) -> list[np.ndarray]:
        frames = [series.frame(series.nearest(time)) for series in self.beam_surfaces]
        return [frame.points[frame.cells] for frame in frames]

    def _with_ground(self, polygons: list, shaded: np.ndarray, normals: np.ndarray,
                     depths: np.ndarray) -> tuple[list, np.ndarray, np.ndarray, np.ndarray]:
        """Polygons that are drawn, with the ground first: ground hides polygons that lie behind it by more than the
        size of its triangles."""
        own = normals_of(self.ground)
        size = np.linalg.norm(self.ground[:, 1] - self.ground[:, 0], axis=1) + np.linalg.norm(
            self.ground[:, 2] - self.ground[:, 0], axis=1)
        behind = self.camera.depth(self.ground.mean(axis=1)) - size
        return ([*self.ground, *polygons], np.vstack([shade(FLOOR, own, self.camera), shaded]),
                np.vstack([own, normals]),
                np.concatenate([behind, depths]))

    def draw(self, axes: Axes, time: float) -> ScalarMappable | None:
        """Order of drawing: sides of boxes first, then all else from the back to the front; polygons turned away are
        left out."""
        parts = self._soil_parts(time) if self.soil else []
        solids = [self._structure_faces(structure, time) for structure in self.structures]
        for faces in (*solids, *self._beam_faces(time)):
            parts.append((faces, np.tile(STEEL, (len(faces), 1)), normals_of(faces)))
        for faces in self.boulders.at(self.times[np.argmin(np.abs(self.times - time))]):
            parts.append((faces, np.tile(BOULDER, (len(faces), 1)), normals_of(faces)))
        walls = self._wall_collection()
        if walls is not None:
            axes.add_collection(walls)
        polygons = [polygon for part, _, _ in parts for polygon in part]
        normals = np.concatenate([part for _, _, part in parts])
        shaded = shade(np.concatenate([part for _, part, _ in parts]), normals, self.camera)
        depths = np.array([self.camera.depth(polygon.mean(axis=0)) for polygon in polygons])
        if len(self.ground):
            polygons, shaded, normals, depths = self._with_ground(polygons, shaded, normals, depths)
        order = np.argsort(depths, kind="stable")
        order = order[normals[order] @ self.camera.eye > 0]
        axes.add_collection(PolyCollection([self.camera.project(polygons[k]) for k in order], facecolors=shaded[order],
                                           edgecolors=shaded[order], linewidths=0.2))
        self._draw_lines(axes, time)
        axes.set(aspect="equal", xlim=(self.low[0], self.high[0]), ylim=(self.low[1], self.high[1]))
        axes.set_axis_off()
        axes.set_title(f"t = {self.times[np.argmin(np.abs(self.times - time))]:.3g} s", loc="left")
        return ScalarMappable(self.norm, "viridis") if self.soil else None


def plot_space(view: SpacePlot, times: list[float] | None, out: Path) -> Path:
    """The scene at the given times, four evenly spaced ones by default, two beside each other."""
    chosen = times or list(np.unique(np.linspace(view.times[0], view.times[-1], 4)))
    columns = min(2, len(chosen))
    rows = -(-len(chosen) // columns)
    width = 5.0 * columns
    figure, axes = plt.subplots(rows, columns,
                                figsize=(width + 0.9, 0.2 + rows * (0.35 + view.height_inch(width / columns) / 0.72)),
                                squeeze=False)
    soil = None
    for each, time in zip(axes.flat, chosen):
        soil = view.draw(each, time)
    for each in list(axes.flat)[len(chosen):]:
        each.set_axis_off()
    if soil is not None:
        _colour_bar(figure, soil, view, list(axes.flat))
    return save(figure, out / "space.png")


def animate_space(view: SpacePlot, out: Path) -> Path:
    """The run as a GIF of at most MAX_FRAMES frames."""
    picked = evenly(len(view.times), MAX_FRAMES)
    figure, (axes,) = new_figure(8.5, 0.6 + view.height_inch(8.5) / 0.72)
    soil = view.draw(axes, view.times[0])
    if soil is not None:
        _colour_bar(figure, soil, view, [axes])

    def draw(index: int) -> list:
        axes.clear()
        view.draw(axes, view.times[index])
        return []

    out.mkdir(parents=True, exist_ok=True)
    path = out / "space.gif"
    FuncAnimation(figure, draw, frames=picked).save(path, writer=PillowWriter(fps=12), dpi=80)
    plt.close(figure)
    return path


def _colour_bar(figure: plt.Figure, soil: ScalarMappable, view: SpacePlot, axes: list[Axes]) -> None:
    values = view.soil.frame(0).fields[view.field]
    figure.colorbar(soil, ax=axes, label=label_of(view.field, values), extend=view.beyond, shrink=0.6, aspect=25)
