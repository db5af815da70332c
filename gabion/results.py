# SPDX-License-Identifier: BSD-3-Clause
"""Results of a run as numpy arrays, and as pandas and xarray where these are installed."""

import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._root import ROOT

from plotting import results as reader
from plotting.results import Frame, ResultsError, Series, Table

PICTURES = (".png", ".gif")


@dataclass(frozen=True)
class Picture:
    """A picture that scripts/plot drew; a notebook shows it."""

    path: Path

    def _repr_png_(self) -> bytes | None:
        return self.path.read_bytes() if self.path.suffix == ".png" else None


class Results(reader.Results):
    """Contents of a results folder (docs/results.md), SI units; in 2D forces and energies are per metre.

        results.probes["front"]            # [num_steps + 1], over results.probes["time"]
        results.steps["dt"]                # [num_steps]
        results.soil.frame(-1).points      # [num_points, 3] at the last frame

    Beside what is here: `summary`, `settings("mpm.json")` with all defaults, `gravity`, `dim`, `origin`.
    """

    def __init__(self, folder: str | Path):
        """@raises ResultsError  no such folder"""
        super().__init__(Path(folder))

    def __repr__(self) -> str:
        return f"Results({str(self.folder)!r}, {'completed' if self.completed else 'not completed'})"

    def _table(self, name: str) -> Table:
        found = self.table(name)
        if found is None:
            raise ResultsError(f"{self.folder}: no {name}")
        return found

    @property
    def steps(self) -> Table:
        """A row an accepted step: `time`, `dt`, iterations, forces; a column is an array [num_steps]."""
        return self._table("steps.csv")

    @property
    def iterations(self) -> Table:
        """A row an iteration of the coupling, those of rejected steps too."""
        return self._table("iterations.csv")

    @property
    def probes(self) -> Table:
        """Probes, energies, walls and gauges at time 0 and after each accepted step: [num_steps + 1]."""
        return self._table("probes.csv")

    @property
    def gauges(self) -> dict[str, dict[str, np.ndarray]]:
        """Name of a gauge -> name of a quantity, such as depth [m] or section_flux [kg/s] -> [num_steps + 1]."""
        probes = self._table("probes.csv")
        return {gauge.rpartition(".")[2]: {name.removeprefix(f"{gauge}."): probes[name] for name in probes.names
                                           if name.startswith(f"{gauge}.")} for gauge in reader.gauge_names(probes)}

    def draw(self, *options: str) -> dict[str, Picture]:
        """Draw with scripts/plot into the folder plots of the results: name such as "probes" -> picture.

        options: those of scripts/plot, such as "--field", "velocity".

        @raises ResultsError  it fails
        """
        command = [str(ROOT / "scripts" / "plot"), str(self.folder), *options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ResultsError(done.stderr.strip())
        paths = [Path(line) for line in done.stdout.splitlines()]
        return {path.stem: Picture(path) for path in paths if path.suffix in PICTURES}


def stack(series: Series, field: str | None = None) -> np.ndarray:
    """All frames of a series in one array: [num_frames, num_points, ...].

    field: such as "velocity" [m/s] of the soil or "pressure" [Pa] of a contact, None: the points themselves [m].

    @raises ResultsError  no such field, or points that left the grid: their number differs from frame to frame
    """
    values = [_values(series, series.frame(k), field) for k in range(len(series))]
    if len({each.shape for each in values}) > 1:
        counts = [len(each) for each in values]
        raise ResultsError(f"{series.path}: found {min(counts)} to {max(counts)} points in the frames, allowed: the "
                           "same number in all; read frame by frame")
    return np.stack(values)


def _values(series: Series, frame: Frame, field: str | None) -> np.ndarray:
    if field is None:
        return frame.points
    if field not in frame.fields:
        raise ResultsError(f"{series.path}: no field {field}; there are {', '.join(frame.fields)}")
    return frame.fields[field]


def _module(name: str, package: str) -> Any:
    try:
        return __import__(name)
    except ImportError as error:
        raise ImportError(f"{name} is not installed: apt-get install {package}, or pip install {name}; columns and "
                          "frames are arrays of numpy without it") from error


def to_pandas(table: Table) -> Any:
    """A table as a pandas.DataFrame, over its time where it has one."""
    frame = _module("pandas", "python3-pandas").DataFrame({name: table[name] for name in table.names})
    return frame.set_index("time") if "time" in table else frame


def to_xarray(series: Series, *fields: str) -> Any:
    """Fields of a series, all where none is named, as an xarray.Dataset: over time [s], point or cell, component.
    "position" has the points' places [m].

    @raises ResultsError  as of `stack`
    """
    xarray = _module("xarray", "python3-xarray")
    centres = {each.get("Name"): each.get("Center") for each in series.grid(0).findall("Attribute")}
    arrays = {"position": stack(series), **{name: stack(series, name) for name in fields or centres}}
    axes = {}
    for name, values in arrays.items():
        item = "cell" if centres.get(name) == "Cell" else "point"
        axes[name] = (("time", item, f"{name}_component")[: values.ndim], values)
    return xarray.Dataset(axes, coords={"time": series.times})
