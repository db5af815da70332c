# SPDX-License-Identifier: BSD-3-Clause
"""Read a results folder: tables (CSV), time series (XDMF + HDF5) and the summary (JSON)."""

import csv
import json
import xml.etree.ElementTree as ElementTree
from copy import copy
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import takewhile
from pathlib import Path

import h5py
import numpy as np

SUMMARY, RESOLVED = "summary.json", "resolved_config.json"
CONTACT = "contact_"  # begins the name of frames of an interface or wall


class ResultsError(Exception):
    """A results folder, file or column that is missing or cannot be read."""


class Table:
    """A CSV file: columns of numbers by name; a column of texts stays a column of texts."""

    def __init__(self, path: Path):
        self.path = path
        text = path.read_text(encoding="utf-8")
        rows = list(csv.reader(text.splitlines()))
        if not rows:
            raise ResultsError(f"{path}: empty")
        self.names = rows[0]
        # A run in progress or a killed one may leave half a row at the end, or half a number at the end of a row.
        body = rows[1:] if text.endswith("\n") else rows[1:-1]
        if any(len(row) != len(self.names) for row in body):
            raise ResultsError(f"{path}: rows with another number of cells than the head")
        self._columns = {
            name: _numbers_or_texts([row[i] for row in body]) for i, name in enumerate(self.names)
        }
        self.num_rows = len(body)

    def __contains__(self, name: str) -> bool:
        return name in self._columns

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._columns:
            raise ResultsError(f"{self.path}: no column {name}; there are {', '.join(self.names)}")
        return self._columns[name]

    def matching(self, *parts: str) -> list[str]:
        """Names of the columns of numbers that contain one of the parts."""
        return [
            name
            for name in self.names
            if any(part in name for part in parts) and self._columns[name].dtype.kind == "f"
        ]


def _numbers_or_texts(cells: list[str]) -> np.ndarray:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)


GAUGE_MARK = ".section_flux"  # ends a column that only gauges have


def gauge_names(table: Table) -> list[str]:
    """Names of the gauges, such as "soil.toe", in the order of the columns."""
    return [name.removesuffix(GAUGE_MARK) for name in table.names if name.endswith(GAUGE_MARK)]


def require_time(option: str, time: float, first: float, last: float) -> None:
    """A time from the first to the last frame, to the digits in which a title shows it.

    @raises ResultsError  another time
    """
    if not min(first, float(f"{first:.3g}")) <= time <= max(last, float(f"{last:.3g}")):
        raise ResultsError(f"{option}: found {time:g}, allowed: {first:g} to {last:g} s, the times of the first and "
                           "the last frame")


# Corners of the cells of second order; their nodes stand first.
CORNERS = {"Edge_3": 2, "Triangle_6": 3, "Quadrilateral_8": 4, "Quadrilateral_9": 4, "Tetrahedron_10": 4,
           "Hexahedron_20": 8, "Hexahedron_27": 8}


@dataclass
class Frame:
    """One instant of a time series.

    points: num_points x 2 or 3; cells: num_cells x nodes_per_cell, or None for a cloud of points;
    field names are looked up on reading; on_cells: those of a value a cell; kind: of the cells, as XDMF names it.
    """

    time: float
    points: np.ndarray
    cells: np.ndarray | None
    fields: dict[str, np.ndarray]
    on_cells: frozenset[str] = frozenset()
    kind: str = ""

    @property
    def corners(self) -> np.ndarray | None:
        """Cells without the nodes on their edges, faces and inside, num_cells x corners; None for a cloud of points."""
        return self.cells if self.cells is None else self.cells[:, :CORNERS.get(self.kind)]

    @property
    def standing(self) -> np.ndarray | None:
        """Corners of the cells of a structure that did not fail; all of them where none is left to show."""
        failed = self.fields.get("failed")
        left = self.corners if failed is None or self.cells is None else self.corners[failed.ravel() < 1]
        return self.corners if left is None or not len(left) else left


def evenly(count: int, most: int) -> np.ndarray:
    """Numbers of at most `most` of `count` frames, evenly, the first and the last one too."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


class Series:
    """A time series as its .xdmf index lists it; frames are read when asked for."""

    def __init__(self, path: Path):
        self.path = path
        try:
            tree = ElementTree.parse(path)
        except ElementTree.ParseError as error:
            raise ResultsError(f"{path}: not a complete XDMF file: {error}") from error
        self._grids = [
            grid for grid in tree.iter("Grid") if grid.get("GridType", "Uniform") == "Uniform"
        ]
        self.times = np.array([float(grid.find("Time").get("Value")) for grid in self._grids])
        if not len(self.times):
            raise ResultsError(f"{path}: lists no frame")

    def __len__(self) -> int:
        return len(self._grids)

    def nearest(self, time: float) -> int:
        return int(np.argmin(np.abs(self.times - time)))

    def nearest_within(self, time: float) -> int:
        """Number of the frame for the option --time. @raises ResultsError  a time before the first or after the last
        frame"""
        require_time("--time", time, float(self.times[0]), float(self.times[-1]))
        return self.nearest(time)

    def of_one_mesh(self) -> "Series":
        """The frames up to the first with other cells: facets of a structure that breaks leave its surface."""
        meshes = (self._array(grid.find("Topology/DataItem")) for grid in self._grids)
        count = sum(1 for _ in takewhile(partial(np.array_equal, next(meshes)), meshes)) + 1
        first = copy(self)
        first._grids, first.times = self._grids[:count], self.times[:count]
        return first

    def grid(self, index: int) -> ElementTree.Element:
        """The XML of a frame."""
        return self._grids[index]

    def frame(self, index: int) -> Frame:
        grid = self._grids[index]
        points = self._array(grid.find("Geometry/DataItem"))
        topology = grid.find("Topology")
        item = topology.find("DataItem")
        cells = None
        if item is not None and topology.get("TopologyType") != "Polyvertex":
            cells = self._array(item).astype(int)
            cells = cells.reshape(-1, cells.shape[-1]) if cells.ndim > 1 else cells[:, None]
            cells = cells if cells.shape[1] > 1 else None
        fields = {
            attribute.get("Name"): self._array(attribute.find("DataItem"))
            for attribute in grid.findall("Attribute")
        }
        on_cells = frozenset(each.get("Name") for each in grid.findall("Attribute") if each.get("Center") == "Cell")
        return Frame(float(self.times[index]), points, cells, fields, on_cells, topology.get("TopologyType", ""))

    def _array(self, item: ElementTree.Element) -> np.ndarray:
        file, _, dataset = item.text.strip().partition(":")
        path = self.path.parent / file
        if not path.exists():
            raise ResultsError(f"{self.path}: names {file}, which is not there")
        try:
            with h5py.File(path) as data:
                values = data[dataset][()]
        except (OSError, KeyError) as error:
            raise ResultsError(f"{path}: {error}; allowed: the frame as the run wrote it") from error
        size = [int(n) for n in item.get("Dimensions", "").split()]
        return values.reshape(size) if size else values


def object_of(path: Path) -> dict | None:
    """The object in a JSON file of a run; None: there is no file, or a run in progress has written half of it."""
    if not path.exists():
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return None


def is_completed(summary: dict | None) -> bool:
    """Whether a summary.json says that its run came to its end. Without that statement it did not, as for the
    programs."""
    return summary is not None and summary.get("completed") is True


class Results:
    """Contents of a results folder; missing parts are None."""

    def __init__(self, folder: Path):
        if not folder.is_dir():
            raise ResultsError(f"{folder}: no such results folder")
        self.folder = folder

    def table(self, name: str) -> Table | None:
        path = self.folder / name
        return Table(path) if path.exists() else None

    def series(self, name: str) -> Series | None:
        path = self.folder / name
        return Series(path) if path.exists() else None

    @property
    def soil(self) -> Series | None:
        return self.series("mpm/soil.xdmf")

    def frames_of_soil(self) -> Series:
        """@raises ResultsError  there are none"""
        soil = self.soil
        if soil is None:
            raise ResultsError(f"{self.folder}: no mpm/soil.xdmf")
        return soil

    @property
    def contacts(self) -> dict[str, Series]:
        """Name of an interface, rigid wall or boulder -> its frames, with the pressure of the soil on its facets,
        as long as these are the same."""
        paths = sorted(self.folder.glob(f"mpm/{CONTACT}*.xdmf"))
        found = {path.stem.removeprefix(CONTACT): Series(path) for path in paths}
        changing = {item["name"] for file, settings in self.resolved.items() if file.endswith("fem.json")
                    for item in settings.get("interfaces") or [] if item.get("behind")}
        return {name: series.of_one_mesh() if name in changing else series for name, series in found.items()}

    @property
    def boulders(self) -> list[str]:
        """Entries of `contacts` that are boulders, in the order of the settings, drawn ones behind."""
        settings = self.settings("mpm.json")
        names = [boulder["name"] for boulder in settings.get("boulders", [])]
        drawn = [group["name"] for group in settings.get("random_boulders", [])]
        series = self.contacts if names or drawn else {}
        names += [name for name in series if name.rpartition("_")[0] in drawn and name.rpartition("_")[2].isdigit()]
        return [name for name in names if name in series]

    @property
    def surfaces(self) -> dict[str, Series]:
        """Entries of `contacts` that are interfaces or rigid walls."""
        boulders = set(self.boulders)
        return {name: series for name, series in self.contacts.items() if name not in boulders}

    @property
    def beam_surfaces(self) -> list[Series]:
        """The soil's copies of surfaces around beams, whose structures have no faces of their own."""
        names = [item["name"] for file, settings in self.resolved.items() if file.endswith("fem.json")
                 for item in settings.get("interfaces") or [] if item.get("beams")]
        return [self.contacts[name] for name in names if name in self.contacts]

    @property
    def lines(self) -> list[Series]:
        """Lines of each fem_solver, such as ropes, bars and beams, in the order of their folders."""
        return [Series(path) for path in sorted(self.folder.glob("*/lines.xdmf"))]

    @property
    def structures(self) -> list[Series]:
        """Results of each fem_solver, in the order of their folders."""
        return [Series(path) for path in sorted(self.folder.glob("*/structure.xdmf"))]

    @cached_property
    def dim(self) -> int:
        tables = (self.table("probes.csv"), self.table("steps.csv"))
        names = {name for table in tables if table for name in table.names}
        # A moment about z alone, as that of a support, belongs to a run in 2D.
        return 3 if any(name.endswith(("fz", ".uz")) or (name.endswith("_z") and name[:-1] + "y" in names)
                        for name in names) else 2

    @cached_property
    def resolved(self) -> dict[str, dict]:
        """Name of a file of the scene -> its settings with all defaults. Of further solvers with their folder.

        @raises ResultsError  the run has ended, and one of the files is no JSON
        """
        found: dict[str, dict] = {}
        for path in (self.folder / RESOLVED, *sorted(self.folder.glob(f"*/{RESOLVED}"))):
            files = object_of(path)
            if files is None and path.exists() and self.summary is not None:
                raise ResultsError(f"{path}: not a complete JSON file")
            for name, settings in (files or {}).items():
                found[name if name not in found else f"{path.parent.name}/{name}"] = settings
        return found

    @property
    def gravity(self) -> list[float] | None:
        """Gravity of the first resolved settings that have it [m/s^2]; None without."""
        return next((settings["gravity"] for settings in self.resolved.values()
                     if isinstance(settings, dict) and settings.get("gravity")), None)

    def settings(self, name: str) -> dict:
        """Resolved settings of a file such as mpm.json; empty: there are none."""
        return self.resolved.get(name, {})

    @property
    def origin(self) -> np.ndarray:
        """Origin of the soil's coordinates on the map [m]: x, y, z."""
        return np.array(self.settings("mpm.json").get("origin", [0, 0, 0]))

    @property
    def per_metre(self) -> str:
        """Ending of the units of forces and energies: in plane strain they are per metre of thickness."""
        return "/m" if self.dim == 2 else ""

    @property
    def summary(self) -> dict | None:
        return object_of(self.folder / SUMMARY)

    @property
    def completed(self) -> bool:
        """Whether the run came to its end."""
        return is_completed(self.summary)
