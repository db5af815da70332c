# SPDX-License-Identifier: BSD-3-Clause
"""Largest values of a flow in each cell of the plan over the frames of a run: depth, speed, pressure, time of
arrival."""

from dataclasses import dataclass

import numpy as np

from plotting.deposit import Plan, heap_of, make_plan, extents_of, shares_of, volumes_of
from plotting.results import Frame, Results, ResultsError, Series


@dataclass(frozen=True)
class Peaks:
    """Fields over the cells of a plan, nan where no soil lies or came by.

    depth: of the mass at rest at the last frame [m]; the largest over all frames of: depth, speed of a point [m/s],
    mean over the volume over a cell of density times speed squared [Pa]; arrival: time of the first frame with soil
    [s].
    """

    plan: Plan
    time: float
    depth: np.ndarray
    max_depth: np.ndarray
    max_speed: np.ndarray
    max_dynamic_pressure: np.ndarray
    arrival: np.ndarray

    def fields(self) -> dict[str, np.ndarray]:
        return {name: getattr(self, name)
                for name in ("depth", "max_depth", "max_speed", "max_dynamic_pressure", "arrival")}


def densities(frame: Frame, results: Results, series: Series) -> np.ndarray:
    """Density at rest of the body of each point [kg/m^3]. @raises ResultsError  no settings of the bodies"""
    bodies = results.settings("mpm.json").get("bodies", [])
    if not bodies:
        raise ResultsError(f"{results.folder}: no resolved_config.json of the soil, which says how dense it is")
    each = np.array([body["material"]["density"] for body in bodies], dtype=float)
    if len(each) == 1:
        return np.full(len(frame.points), each[0])
    if "body" not in frame.fields:
        raise ResultsError(f"{series.path}: its points have no body")
    return each[frame.fields["body"].astype(int)]


def dynamic_pressure(frame: Frame, plan: Plan, results: Results, series: Series) -> np.ndarray:
    """Mean over the volume over each cell of density times speed squared [Pa]; 0 where there is none."""
    energy, volume = np.zeros(plan.shape), np.zeros(plan.shape)
    if not len(frame.points):
        return volume
    at_rest, present = volumes_of(frame, series)
    doubled = densities(frame, results, series) * at_rest * np.sum(frame.fields["velocity"] ** 2, axis=1)
    for part in shares_of(*extents_of(frame, plan.axes, series), plan):
        np.add.at(energy, part.cells, doubled[part.points] * part.share)
        np.add.at(volume, part.cells, present[part.points] * part.share)
    return energy / np.where(volume > 0, volume, 1)


def find_peaks(results: Results, corner: np.ndarray, cell: float, time: float | None = None) -> Peaks:
    """Peaks over the frames up to the one nearest to a time [s], None: all; of a run in 3D with gravity along z.

    corner: of any cell, in coordinates of the run [m].

    @raises ResultsError  no frames, too many cells, a time beyond them
    """
    series = results.frames_of_soil()
    last = len(series) - 1 if time is None else series.nearest_within(time)
    plan = make_plan(series, (0, 1), last, cell, corner)
    largest = {name: np.zeros(plan.shape) for name in ("depth", "speed", "pressure")}
    arrival = np.full(plan.shape, np.nan)
    for k in range(last + 1):
        frame = series.frame(k)
        heap = heap_of(frame, plan, series)
        for name, values in (("depth", heap.depth), ("speed", heap.speed),
                             ("pressure", dynamic_pressure(frame, plan, results, series))):
            np.maximum(largest[name], values, out=largest[name])
        arrival[np.isnan(arrival) & (heap.depth > 0)] = series.times[k]
    wet = ~np.isnan(arrival)
    return Peaks(plan, float(series.times[last]), np.where(heap.depth > 0, heap.depth, np.nan),
                 *(np.where(wet, largest[name], np.nan) for name in ("depth", "speed", "pressure")), arrival)
