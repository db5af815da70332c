# SPDX-License-Identifier: BSD-3-Clause
"""How deep soil lies over the plan, from the material points of frames: rasters in 3D, a profile in 2D."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plotting.results import Frame, Results, ResultsError, Series
from plotting.style import legend_beside, new_figure, plt, save
from plotting.view import AXES, up_axis

MAX_CELLS = 4_000_000
ROUND_OFF = 1e-9  # of a cell: less of a point over the next cell makes no new cell


@dataclass(frozen=True)
class Plan:
    """Square cells over the plan. 2D: a row of cells along x.

    axes: of the scene, those of the plan, one less than its dimension; low: corner of the first cell [m]; cell: its
    side [m]; shape: number of cells along each axis.
    """

    axes: tuple[int, ...]
    low: np.ndarray
    cell: float
    shape: tuple[int, ...]

    @property
    def area(self) -> float:
        """Area of a cell [m^2], in 2D its length [m]."""
        return self.cell ** len(self.axes)

    def centres(self, k: int) -> np.ndarray:
        return self.low[k] + self.cell * (np.arange(self.shape[k]) + 0.5)


@dataclass(frozen=True)
class Deposit:
    """Fields over the cells of a plan.

    depth: mass over the density at rest and the area of the cell [m]; opened: what the present volume is more than
    that, as depth [m], below 0 where soil is compressed; speed: largest |v| [m/s].
    """

    plan: Plan
    time: float
    depth: np.ndarray
    opened: np.ndarray
    max_depth: np.ndarray  # over all frames up to `time`
    max_speed: np.ndarray


def volumes_of(frame: Frame, series: Series) -> tuple[np.ndarray, np.ndarray]:
    """Volumes of each point [m^3]: at rest (mass over density), and at present."""
    for name in ("volume", "volume_ratio"):
        if name not in frame.fields:
            raise ResultsError(f"{series.path}: its points have no {name}")
    volume = frame.fields["volume"]
    return volume / frame.fields["volume_ratio"], volume


def extents_of(frame: Frame, axes: tuple[int, ...], series: Series) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners in the plan of the cubes (2D: squares) that the points at rest stand for."""
    half = 0.5 * volumes_of(frame, series)[0] ** (1 / (len(axes) + 1))
    centres = frame.points[:, axes]
    return centres - half[:, None], centres + half[:, None]


def make_plan(series: Series, axes: tuple[int, ...], last: int, cell: float | None,
              corner: np.ndarray | float = 0.0) -> Plan:
    """Cells that hold all soil of the frames 0 to `last`; their corners are multiples of the cell away from `corner`
    [m].

    cell: None: two mean points of the first frame with soil wide.
    """
    corners = []
    for k in range(last + 1):
        frame = series.frame(k)
        if not len(frame.points):
            continue
        if cell is None:
            cell = 2 * float(np.mean(volumes_of(frame, series)[0])) ** (1 / (len(axes) + 1))
        low, high = extents_of(frame, axes, series)
        corners += [low.min(axis=0), high.max(axis=0)]
    if not corners:
        raise ResultsError(f"{series.path}: its frames have no material points")
    first = np.floor((np.min(corners, axis=0) - corner) / cell + ROUND_OFF)
    shape = np.maximum(1, np.ceil((np.max(corners, axis=0) - corner) / cell - ROUND_OFF) - first)
    if np.prod(shape) > MAX_CELLS:
        raise ResultsError(f"cells of {cell:g} m make {np.prod(shape):.0f} of them, allowed: {MAX_CELLS}")
    return Plan(axes, corner + first * cell, cell, tuple(int(n) for n in shape))


@dataclass(frozen=True)
class Shares:
    """Assignment of each point to at most one cell. points: which ones have one; share: of the point that
    lies over it."""

    points: np.ndarray
    cells: tuple[np.ndarray, ...]
    share: np.ndarray


def shares_of(low: np.ndarray, high: np.ndarray, plan: Plan) -> Iterator[Shares]:
    """All cells below each point; the shares of a point add up to 1."""
    low = np.maximum(low, plan.low)
    high = np.minimum(high, plan.low + plan.cell * np.array(plan.shape))
    first = np.clip(np.floor((low - plan.low) / plan.cell).astype(int), 0, np.array(plan.shape) - 1)
    last = np.clip(np.floor((high - plan.low) / plan.cell).astype(int), 0, np.array(plan.shape) - 1)
    for step in np.ndindex(*(np.max(last - first, axis=0) + 1)):
        cells = first + np.array(step)
        begin = plan.low + plan.cell * cells
        overlap = np.minimum(high, begin + plan.cell) - np.maximum(low, begin)
        inside = np.all((cells <= last) & (overlap > 0), axis=1)
        share = np.prod(overlap[inside] / (high - low)[inside], axis=1)
        yield Shares(inside, tuple(cells[inside].T), share)


@dataclass(frozen=True)
class Heap:
    """Depth at rest, what is opened [m] and largest speed [m/s] over each cell at one instant."""

    depth: np.ndarray
    opened: np.ndarray
    speed: np.ndarray


def heap_of(frame: Frame, plan: Plan, series: Series) -> Heap:
    heap = Heap(*(np.zeros(plan.shape) for _ in range(3)))
    if not len(frame.points):
        return heap
    low, high = extents_of(frame, plan.axes, series)
    at_rest, volumes = volumes_of(frame, series)
    speeds = np.linalg.norm(frame.fields["velocity"], axis=1)
    for part in shares_of(low, high, plan):
        share = part.share / plan.area
        np.add.at(heap.depth, part.cells, at_rest[part.points] * share)
        np.add.at(heap.opened, part.cells, (volumes - at_rest)[part.points] * share)
        np.maximum.at(heap.speed, part.cells, speeds[part.points])
    return heap


def find_deposit(results: Results, time: float | None = None, cell: float | None = None) -> Deposit:
    """Deposit at the frame nearest to a time [s]; None: at the last one.

    @raises ResultsError  no frames, a time beyond them, too many cells
    """
    series = results.frames_of_soil()
    last = len(series) - 1 if time is None else series.nearest_within(time)
    up = up_axis(results.dim, results.gravity)
    plan = make_plan(series, tuple(axis for axis in range(results.dim) if axis != up), last, cell)
    max_depth, max_speed = np.zeros(plan.shape), np.zeros(plan.shape)
    for k in range(last + 1):
        heap = heap_of(series.frame(k), plan, series)
        max_depth, max_speed = np.maximum(max_depth, heap.depth), np.maximum(max_speed, heap.speed)
    return Deposit(plan, float(series.times[last]), heap.depth, heap.opened, max_depth, max_speed)


def _write_raster(path: Path, plan: Plan, values: np.ndarray, origin: np.ndarray) -> None:
    """ESRI ASCII grid: the first axis of the plan to the east, the second to the north."""
    low = plan.low + origin
    head = (f"ncols {plan.shape[0]}\nnrows {plan.shape[1]}\nxllcorner {float(low[0])!r}\n"
            f"yllcorner {float(low[1])!r}\ncellsize {plan.cell!r}\nNODATA_value -9999\n")
    rows = "\n".join(" ".join(repr(float(value)) for value in row) for row in values.T[::-1])
    path.write_text(head + rows + "\n", encoding="utf-8")


def write_tables(deposit: Deposit, out: Path, origin: tuple[float, ...] = (0.0, 0.0)) -> list[Path]:
    """Rasters depth.asc, opened.asc, max_depth.asc, max_speed.asc; in 2D the columns of deposit.csv.

    origin: added to the coordinates [m].
    """
    fields = {"depth": deposit.depth, "opened": deposit.opened, "max_depth": deposit.max_depth,
              "max_speed": deposit.max_speed}
    out.mkdir(parents=True, exist_ok=True)
    plan = deposit.plan
    if len(plan.axes) == 2:
        paths = [out / f"{name}.asc" for name in fields]
        for path, values in zip(paths, fields.values()):
            _write_raster(path, plan, values, np.array(origin[:2]))
        return paths
    lines = [",".join(["x", *fields])]
    for row in zip(plan.centres(0) + origin[0], *fields.values()):
        lines.append(",".join(repr(float(value)) for value in row))
    path = out / "deposit.csv"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return [path]


def draw(deposit: Deposit, out: Path) -> Path:
    """deposit.png: depth, largest depth, largest speed."""
    return (_draw_map if len(deposit.plan.axes) == 2 else _draw_profile)(deposit, out / "deposit.png")


def _draw_profile(deposit: Deposit, path: Path) -> Path:
    figure, (depths, speeds) = new_figure(9.5, 5, 2)
    x = deposit.plan.centres(0)
    depths.step(x, deposit.depth, where="mid", label=f"at {deposit.time:.3g} s")
    depths.step(x, deposit.max_depth, where="mid", lw=1, label="largest")
    depths.set_ylabel("depth [m]")
    legend_beside(depths)
    speeds.step(x, deposit.max_speed, where="mid")
    speeds.set_ylabel("largest speed [m/s]")
    speeds.set_xlabel(f"{AXES[deposit.plan.axes[0]]} [m]")
    return save(figure, path)


def _draw_map(deposit: Deposit, path: Path) -> Path:
    plan = deposit.plan
    panels = ((f"depth at {deposit.time:.3g} s [m]", deposit.depth), ("largest depth [m]", deposit.max_depth),
              ("largest speed [m/s]", deposit.max_speed))
    figure, axes = plt.subplots(1, len(panels), figsize=(13, 4.2), sharey=True)
    high = plan.low + plan.cell * np.array(plan.shape)
    for each, (title, values) in zip(axes, panels):
        image = each.imshow(np.ma.masked_equal(values.T, 0), origin="lower", cmap="viridis", vmin=0,
                            extent=(plan.low[0], high[0], plan.low[1], high[1]))
        figure.colorbar(image, ax=each, shrink=0.8)
        each.set_title(title, loc="left")
        each.set_xlabel(f"{AXES[plan.axes[0]]} [m]")
    axes[0].set_ylabel(f"{AXES[plan.axes[1]]} [m]")
    return save(figure, path)
