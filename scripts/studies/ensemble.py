# SPDX-License-Identifier: BSD-3-Clause
"""Runs of one scene that differ by less than anyone knows: what they share is the answer.

A body of soil that hits something amplifies round-off, so one run is one sample.
"""

import json

import numpy as np

from measured import text_of
from studies.measures import Measured
from studies.runner import ROOT, Runner, folder_of

SHORTER = 0.04  # steps against those of the member before: parts runs before the impact


def ensemble(runner: Runner, name: str, scene: str, settings: list[str], members: int,
             dt: float) -> list[Measured]:
    """Members 0 .. members - 1 in steps of dt (1 - SHORTER k) [s], each in a folder of its own.

    @raises ResultsError  a run failed
    """
    return [runner.run(f"{folder_of(name)}_{k}", scene,
                       [*settings, f"coupler.json:/time/dt={dt * (1 - SHORTER * k):.12g}"])
            for k in range(members)]


def with_other_modulus(runner: Runner, name: str, scene: str, settings: list[str], members: int,
                       change: float) -> list[Measured]:
    """Members 0 .. members - 1 with Young's modulus of the soil times 1 + change k."""
    soil = json.loads((ROOT / "configs" / scene / "mpm.json").read_text(encoding="utf-8"))
    key, E = "/bodies/0/material/young_modulus", soil["bodies"][0]["material"]["young_modulus"]
    return [runner.run(f"{folder_of(name)}_{k}", scene,
                       [*settings, *([f"mpm.json:{key}={E * (1 + change * k)!r}"] if k else [])])
            for k in range(members)]


def deviation(values) -> float:
    """Standard deviation of one member."""
    return float(np.std(values, ddof=1))


def error(values) -> float:
    """Standard error of the mean."""
    return deviation(values) / np.sqrt(len(values))


def mean_and_error(values) -> str:
    """Such as "20.36 ± 0.15": two digits of the standard error, no more of the mean. One run has no error."""
    if len(values) == 1:
        return text_of(float(values[0]))
    of_mean = error(values)
    digits = max(0, 1 - int(np.floor(np.log10(of_mean)))) if of_mean > 0 else 4
    return f"{np.mean(values):.{digits}f} ± {of_mean:.{digits}f}"
