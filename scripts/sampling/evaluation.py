# SPDX-License-Identifier: BSD-3-Clause
"""Tables and pictures of a study whose runs are there."""

import math
from typing import Any

import numpy as np
from scipy import stats

from plotting.style import save
from studies.runner import write_table

from . import figures
from .plan import Fragility
from .reader import is_number
from .statistics import (CONFIDENCE, QUANTILES, Fit, Indices, band_of, fit_fragility, levels_of, sobol_indices,
                         standard_error)
from .study import Study

SHARE = f"{CONFIDENCE:.0%} confidence"


class Evaluation:
    """Writes the evaluation of the completed runs of a study; it reports what is left out and why.

    answers: of each name [num_points], means over the repeats of a point, NaN without a completed run.
    """

    def __init__(self, study: Study):
        self.study, self.plan = study, study.plan
        self.points = [outcome.case.values for outcome in study.outcomes if outcome.case.repeat == 0]
        self.of_point: list[list[int]] = [[] for _ in self.points]
        for outcome in study.outcomes:
            self.of_point[outcome.case.point].append(outcome.case.number)
        self.names = [answer.name for answer in self.plan.answers]
        self.values = {name: study.values(name) for name in self.names}
        self.answers = {name: np.array([_mean(values[runs]) for runs in self.of_point])
                        for name, values in self.values.items()}

    def write(self) -> None:
        write_table(self.study.folder / "runs.csv", *self.study.table())
        failed = [outcome for outcome in self.study.outcomes if not outcome.completed]
        if failed:
            all_runs = len(self.study.outcomes)
            say(f"{len(failed)} of {all_runs} runs are not completed; all that follows is of the others")
        if all(not outcome.completed for outcome in self.study.outcomes):
            return
        if self.names:
            self.write_answers()
        if self.names and self.plan.repeats:
            self.write_points()
        if self.names and self.plan.design.method == "sobol_indices":
            self.write_indices()
        elif self.names and self.plan.design.method != "factorial":
            self.write_correlations()
        for fragility in self.plan.fragilities:
            self.write_fragility(fragility)
        for name in self.plan.bands:
            self.write_band(name)

    def write_answers(self) -> None:
        """Each answer over all points, and over each parameter as a picture."""
        is_sample = self.plan.design.is_sample and not self.plan.design.cross
        rows = []
        for name, values in self.answers.items():
            there = values[np.isfinite(values)]
            if not len(there):
                continue
            deviation = float(np.std(there, ddof=1)) if len(there) > 1 else math.nan
            rows.append([name, len(there), float(np.mean(there)), standard_error(there) if is_sample else "", deviation,
                         float(there.min()), *map(float, np.quantile(there, QUANTILES)), float(there.max())])
        self.study.report("answers", ["answer", "points", "mean", "standard error", "deviation", "smallest",
                                      *(f"{share:.0%}" for share in QUANTILES), "largest"], rows)
        if self.plan.design.method == "latin_hypercube" and is_sample:
            say("the standard error is that of independent points; the points of a Latin hypercube give the mean of a "
                "monotonic answer better than that")
        columns = {name: [point[name] for point in self.points] for name in self.points[0]}
        self.picture(figures.draw_responses(columns, self.answers), "responses")

    def write_points(self) -> None:
        """Mean and standard error over the repeats of each point."""
        head = ["point", *self.points[0], *(text for name in self.names for text in (name, f"{name}: standard error"))]
        rows = []
        for k, (point, runs) in enumerate(zip(self.points, self.of_point)):
            found = [self.values[name][runs] for name in self.names]
            there = [values[np.isfinite(values)] for values in found]
            means = [value for values in there for value in (_mean(values), standard_error(values))]
            rows.append([k, *point.values(), *means])
        self.study.report("points", head, rows)

    def write_indices(self) -> None:
        names = list(self.points[0])
        found: dict[str, Indices] = {}
        rows = []
        for answer, values in self.answers.items():
            groups = values.reshape(-1, len(names) + 2)
            whole = groups[np.isfinite(groups).all(axis=1)]
            if len(whole) < len(groups):
                say(f"answer {answer}: {len(groups) - len(whole)} of {len(groups)} groups have a run that is not "
                    "completed, and are left out")
            if len(whole) < 2 or not np.isfinite(sobol_indices(whole).first).all():
                say(f"answer {answer}: no Sobol indices: it is the same in all runs, or fewer than two groups are "
                    "whole")
                continue
            found[answer] = indices = sobol_indices(whole)
            table = np.vstack([indices.first, indices.first_ends, indices.total, indices.total_ends]).T
            rows += [[answer, name, *map(float, row)] for name, row in zip(names, table)]
        if found:
            head = ["answer", "parameter", "first order", "from", "to", "total", "from", "to"]
            self.study.report("sobol_indices", head, rows)
            say(f"from, to: {SHARE}")
            self.picture(figures.draw_indices(names, found), "sobol_indices")

    def write_correlations(self) -> None:
        """Rank correlation of each answer with each parameter of numbers."""
        names = [name for name, value in self.points[0].items() if all(is_number(point[name]) for point in self.points)]
        rows = []
        for answer, values in self.answers.items():
            there = np.isfinite(values)
            if there.sum() > 2 and np.ptp(values[there]) > 0:
                given = [np.array([point[name] for point in self.points], dtype=float)[there] for name in names]
                rows.append([answer, *(float(stats.spearmanr(each, values[there])[0]) if np.ptp(each) > 0 else ""
                                       for each in given)])
        if names and rows:
            self.study.report("rank_correlations", ["answer", *names], rows)

    def write_fragility(self, fragility: Fragility) -> None:
        study, of = self.study, fragility
        demand, intensity = study.values(of.demand), study.values(of.intensity)
        named = isinstance(of.capacity, str)
        capacity = study.values(of.capacity) if named else np.full(len(demand), float(of.capacity))
        there = np.isfinite(demand) & np.isfinite(intensity) & np.isfinite(capacity)
        if not there.any():
            say(f"fragility {of.name}: no run has demand, capacity and intensity")
            return
        exceeded = demand[there] > capacity[there]
        levels = levels_of(intensity[there], exceeded)
        study.report(f"fragility_{of.name}", [of.intensity, "runs", "exceeded", "share", "from", "to"],
                     [[level.intensity, level.runs, level.exceeded, level.share, *level.ends] for level in levels])
        fit = fit_fragility(intensity[there], exceeded)
        if isinstance(fit, Fit):
            say(f"fragility {of.name}: lognormal with median {fit.median:.6g} and deviation of the logarithm "
                f"{fit.deviation:.4g}; from, to: {SHARE} of the share")
        else:
            say(f"fragility {of.name}: no curve: {fit}")
        label = f"{of.demand} > {of.capacity}"
        self.picture(figures.draw_fragility(levels, fit if isinstance(fit, Fit) else None, of.intensity, label),
                     f"fragility_{of.name}")

    def write_band(self, name: str) -> None:
        curves = [outcome.curves[name] for outcome in self.study.outcomes if name in outcome.curves]
        band = band_of(curves)
        if band.ends[0] < band.ends[1]:
            say(f"band {name}: the runs end at {band.ends[0]:g} to {band.ends[1]:g} s; it goes to the first of these")
        is_sample = self.plan.design.is_sample and not self.plan.repeats and not self.plan.design.cross
        error = band.error if is_sample else np.full(len(band.time), np.nan)
        rows = [[float(value) if np.isfinite(value) else "" for value in row]
                for row in zip(band.time, band.mean, error, *band.quantiles)]
        write_table(self.study.folder / f"band_{name}.csv",
                    ["time", "mean", "standard error", *(f"{share:.0%}" for share in QUANTILES)], rows)
        self.picture(figures.draw_band(name, band, curves), f"band_{name}")

    def picture(self, figure: Any, name: str) -> None:
        print(save(figure, self.study.folder / f"{name}.png"))


def _mean(values: np.ndarray) -> float:
    there = values[np.isfinite(values)]
    return float(np.mean(there)) if len(there) else math.nan


def say(text: str) -> None:
    print(text[0].upper() + text[1:] + ".")
