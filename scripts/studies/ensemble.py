# SPDX-License-Identifier: BSD-3-Clause
"""Runs of one scene that differ by details which should not matter: their common part is the answer.

A body of soil that hits something amplifies round-off, so one run is one sample. Runs that part in the heap only
still share one arrival: a wall at other places of its cell gives each an arrival of its own.
"""

import json

import numpy as np

from measured import text_of
from studies.measures import Measured
from studies.runner import ROOT, Runner, folder_of


def over_places(runner: Runner, name: str, scene: str, settings: list[str], members: int,
                cell: float) -> list[Measured]:
    """Members with the wall at places evenly over a cell [m] along x, half of them on either side of its own.

    @raises ResultsError  a run failed
    """
    places = (np.arange(members) + 0.5) / members - 0.5
    return runner.run_all([(f"{folder_of(name)}_{k}", scene, [*settings, *moved(scene, float(way))])
                           for k, way in enumerate(cell * places)])


def moved(scene: str, way: float) -> list[str]:
    """Settings that move the structure, its surface and its probes by way [m] along x."""
    surface = _read(scene, "mpm.json")["interfaces"][0]["surface"]["polyline"]
    structure = _read(scene, "fem.json")
    box = structure["mesh"]["box"]
    return [f"mpm.json:/interfaces/0/surface/polyline={json.dumps([_moved(point, way) for point in surface])}",
            *(f"fem.json:/mesh/box/{corner}={json.dumps(_moved(box[corner], way))}" for corner in ("low", "high")),
            *(f"fem.json:/probes/{i}/point={json.dumps(_moved(probe['point'], way))}"
              for i, probe in enumerate(structure["probes"]))]


def with_other_modulus(runner: Runner, name: str, scene: str, settings: list[str], members: int,
                       change: float) -> list[Measured]:
    """Members 0 .. members - 1 with Young's modulus of the soil times 1 + change k."""
    key, E = "/bodies/0/material/young_modulus", _read(scene, "mpm.json")["bodies"][0]["material"]["young_modulus"]
    return runner.run_all([(f"{folder_of(name)}_{k}", scene,
                            [*settings, *([f"mpm.json:{key}={E * (1 + change * k)!r}"] if k else [])])
                           for k in range(members)])


def deviation(values) -> float:
    """Standard deviation of one member from a straight line over the members: a nearer wall is hit harder.

    values: [n] of places evenly apart, n > 2.
    """
    off = np.asarray(values, dtype=float) - np.mean(values)
    place = np.linspace(-1, 1, len(off))
    off -= place * (place @ off) / (place @ place)
    return float(np.sqrt(off @ off / (len(off) - 2)))


def error(values) -> float:
    """Standard error of the mean over places."""
    return deviation(values) / np.sqrt(len(values))


def mean_and_error(values) -> str:
    """Mean and standard error, such as "20.36 ± 0.15": two digits of the standard error, no more of the mean."""
    of_mean = error(values)
    digits = max(0, 1 - int(np.floor(np.log10(of_mean)))) if of_mean > 0 else 4
    return f"{np.mean(values):.{digits}f} ± {of_mean:.{digits}f}"


def _read(scene: str, name: str) -> dict:
    return json.loads((ROOT / "configs" / scene / name).read_text(encoding="utf-8"))


def _moved(point: list[float], way: float) -> list[float]:
    return [point[0] + way, *point[1:]]
