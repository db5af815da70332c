# SPDX-License-Identifier: BSD-3-Clause
"""Answers of every run of the stability sweep: its end, energy, momentum and points."""

import re
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path as Polygon

from plotting.results import Results, ResultsError, is_completed
from studies.runner import Attempt
from studies.throw import FACE, Throw

GRAVITY = 9.81  # [m/s^2]
MAX_GAIN = 1e-3  # of energy, over the largest that was there
MAX_MOMENTUM = 1e-4  # error of momentum over what gravity and the throw gave


@dataclass
class Outcome:
    """Numbers of a run that left nothing are 0."""

    ended: str  #: "end", or when and why it stopped
    named: bool  #: it came to its end, or has a reason
    steps: int = 0
    cuts: int = 0
    iterations: int = 0  #: of the coupling in a step, at most
    gained: float = 0  #: largest rise of all energy over the largest that was there
    contact: float = 0  #: contact_created over the same
    momentum: float = 0  #: error of momentum over what gravity and the throw gave
    behind: int = 0  #: points lost, or behind the wall

    @property
    def faults(self) -> list[str]:
        found = [] if self.ended == "end" else [self.ended]
        found += [f"energy + {100 * self.gained:.2g} %"] * (self.gained > MAX_GAIN)
        found += [f"momentum error {self.momentum:.1g}"] * (self.momentum > MAX_MOMENTUM)
        return found + [f"{self.behind} points through the wall"] * (self.behind > 0)


def verdict(summary: dict) -> str:
    """"end", or when and why the run stopped.

    @raises ResultsError  it does not say why
    """
    if is_completed(summary):
        return "end"
    if not summary.get("reason"):
        raise ResultsError("a run ended without a reason")
    reason = re.sub(r"^.*\(dt_min = [^)]*\): ", "", " ".join(summary["reason"].split()))
    return f"{summary['end_time']:.3g} s: {reason.partition(';')[0]}"


def largest_rise(values: np.ndarray) -> float:
    """Largest rise of the values above their lowest earlier one."""
    return float(np.max(values - np.minimum.accumulate(values)))


def column(results: Results, name: str) -> np.ndarray:
    """Column of the soil in probes.csv, with a coupler or alone."""
    table = results.table("probes.csv")
    return table[name if name in table else f"soil.{name}"]


def total_energy(results: Results) -> np.ndarray:
    """Sum of kinetic, elastic, gravitational and contact energy of soil and structure [J/m]."""
    table = results.table("probes.csv")
    soil = sum(column(results, f"{kind}_energy") for kind in ("kinetic", "elastic", "contact"))
    names = ("structure.kinetic_energy", "structure.elastic_energy")
    structure = sum(table[name] for name in names if name in table)
    return soil + structure - column(results, "gravity_work")


def beyond(face: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Marks of the points to the right of a line that leads upwards and may be bent; both num x 2."""
    low, high = face[0, 1] - 1, face[-1, 1] + 1
    region = np.vstack([[face[0, 0], low], face, [face[-1, 0], high], [-1, high], [-1, low]])
    return ~Polygon(region).contains_points(points)


def far_face(results: Results, throw: Throw) -> np.ndarray:
    """Far face of the wall at the end, upwards: num_vertices x 2."""
    if throw.density is None:
        return np.array([[FACE + throw.thickness, 0], [FACE + throw.thickness, 1]])
    series = results.structures[0]
    frame = series.frame(len(series) - 1)
    start = frame.points - frame.fields["displacement"]
    far = np.flatnonzero(start[:, 0] > FACE + 0.75 * throw.thickness)
    return frame.points[far[np.argsort(start[far, 1])], :2]


def points_behind(results: Results, throw: Throw | None) -> int:
    """Points that are gone, or on the far side of the wall."""
    soil = results.frames_of_soil()
    last = soil.frame(len(soil) - 1).points[:, :2]
    through = 0 if throw is None else int(np.sum(beyond(far_face(results, throw), last)))
    return len(soil.frame(0).points) - len(last) + through


def outcome(attempt: Attempt, throw: Throw | None) -> Outcome:
    """throw: None for soil alone, which starts at rest."""
    if attempt.results is None:
        ended = "no end" if attempt.code is None else f"exit code {attempt.code}, nothing written"
        return Outcome(ended, named=False)
    results, summary = attempt.results, attempt.results.summary
    try:
        ended, named = verdict(summary), attempt.code in (0, 3)
    except ResultsError as error:
        ended, named = str(error), False
    mass, duration = column(results, "mass")[0], column(results, "time")[-1]
    speed = 0 if throw is None else throw.speed
    energy = 0.5 * mass * speed**2 + np.max(np.abs(column(results, "gravity_work")))
    momentum = mass * (speed + GRAVITY * duration)
    error = np.hypot(column(results, "momentum_error_x"), column(results, "momentum_error_y"))
    return Outcome(
        ended, named, summary["steps"], summary["cuts"], summary.get("coupling_iterations", {}).get("max", 0),
        largest_rise(total_energy(results)) / energy if energy else 0.0,
        float(np.max(column(results, "contact_created"))) / energy if energy else 0.0,
        float(np.max(error)) / momentum if momentum else 0.0, points_behind(results, throw))
