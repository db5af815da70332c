# SPDX-License-Identifier: BSD-3-Clause
"""A fit from its plan to its tables and picture."""

import json
import math
from pathlib import Path

import numpy as np

from plotting.style import save
from studies.runner import write_table

from .figures import draw_fit
from .least_squares import Fit, Judge, Minimum, Slopes, evaluate, search, slopes_at
from .model import FitStudy
from .plan import FitParameter

JUDGE = Judge("these data", known=True)
NO_MORE = 1 / math.sqrt(12)  # of z: standard deviation of what is anywhere between the bounds alike
BENT = 1.0  # second difference over the first one from which a derivative says nothing
APART = 0.05  # of z, from which two minima are different ones
AS_GOOD = 3.84  # more squared deviations at which a value is still inside an interval of 95 %
POOR = 2.0  # mean misfit in standard deviations from which the scene does not follow the data


def fit_scene(study: FitStudy) -> Fit:
    """Find the parameters and write what was found into the folder. All that is doubtful is a remark of the fit.

    @raises FitError  no sample has an answer, or a run failed for another reason than its values
    """
    plan = study.plan
    try:
        ends = search(plan.parameters, study, plan.how)
        best = ends[0]
        (misfits,) = study.misfits([best.z])
        slopes = slopes_at(plan.parameters, study, best.z, plan.how.step)
    finally:
        write_table(study.folder / "runs.csv", *study.table())
    fit = evaluate(plan.parameters, misfits, slopes, best.z, JUDGE)
    fit.remarks += [*_remarks_of_parameters(plan.parameters, fit, slopes), *_remarks_of_ends(study, fit, ends),
                    *_remarks_of_runs(study, misfits)]
    _write(study, fit, ends)
    return fit


def _remarks_of_parameters(parameters: list[FitParameter], fit: Fit, slopes: Slopes) -> list[str]:
    found = []
    for each, bend in zip(parameters, slopes.bend):
        sd_z = fit.sd[each.name] / each.width
        known = any(remark.startswith(f"{each.name}: not identified") for remark in fit.remarks)
        if sd_z > NO_MORE and not known:
            found.append(f"{each.name}: not identified by these data: they say no more than its bounds")
        elif bend > BENT and not known:
            found.append(f"{each.name}: not identified by these data: a step up and a step down change the runs alike "
                         "(scatter, or no slope here); a larger \"step\" may tell")
    return found


def _remarks_of_ends(study: FitStudy, fit: Fit, ends: list[Minimum]) -> list[str]:
    """Remarks on the starts: one that did not end, or ended elsewhere with an equally small misfit."""
    found = []
    parameters = study.plan.parameters
    if not ends[0].converged:
        found.append(f"no minimum in {study.plan.how.evaluations} evaluations of a start; more \"evaluations\", or "
                     "fewer parameters")
    freedom = max(1, len(fit.misfits) - len(parameters))
    variance = max(1.0, 2 * ends[0].cost / freedom)
    sd_z = np.array([fit.sd[each.name] / each.width for each in parameters])
    for end in ends[1:]:
        away = np.abs(end.z - ends[0].z) > np.maximum(APART, 3 * sd_z)
        if away.any() and 2 * (end.cost - ends[0].cost) < AS_GOOD * variance:
            names = [each.name for each, far in zip(parameters, away) if far]
            place = ", ".join(f"{each.name} {each.given(z):.4g}" for each, z in zip(parameters, end.z))
            found.append(f"{', '.join(names)}: not identified by these data: another start ends at {place} with a "
                         "misfit as good")
    return found


def _remarks_of_runs(study: FitStudy, misfits: np.ndarray) -> list[str]:
    found = []
    if len(misfits) == len(study.plan.parameters):
        found.append("as many values as parameters: whether the scene follows them cannot be seen")
    size = float(np.sqrt(np.mean(misfits**2)))
    if size > POOR:
        found.append(f"the scene does not follow these data: the misfit is {size:.3g} standard deviations")
    failed = [outcome for outcome in study.outcomes if not outcome.completed]
    return [*found, *(f"run {outcome.case.number} ({outcome.label}) {outcome.status}; the fit went round its values"
                      for outcome in failed)]


def _write(study: FitStudy, fit: Fit, ends: list[Minimum]) -> None:
    plan = study.plan
    names = [each.name for each in plan.parameters]
    study.report("parameters", ["parameter", "value", "standard deviation", "95 % from", "to", "lowest", "highest"],
                 [[each.name, fit.values[each.name], f"{fit.sd[each.name]:.3g}{' of ln' if each.by_log else ''}",
                   *fit.interval[each.name], each.low, each.high] for each in plan.parameters])
    study.report("correlation", ["", *names],
                 [[name, *map(float, row)] for name, row in zip(names, fit.correlation)])
    predicted = study.predicted(fit.z)
    parts = np.split(fit.misfits, np.cumsum([len(each.values) for each in plan.data])[:-1])
    study.report("misfits", ["data", "values", "rms misfit", "in standard deviations", "largest"],
                 [[each.name, len(each.values), float(np.sqrt(np.mean((found - each.values) ** 2))),
                   float(np.sqrt(np.mean(part**2))), float(np.max(np.abs(part)))]
                  for each, found, part in zip(plan.data, predicted, parts)])
    rows = [[each.name, " ".join(f"{value:.9g}" for value in at), value, fitted, deviation, misfit]
            for each, found, part in zip(plan.data, predicted, parts)
            for at, value, fitted, deviation, misfit in zip(each.at, *map(np.ndarray.tolist, (
                each.values, found, each.deviation, part)))]
    write_table(study.folder / "residuals.csv",
                ["data", "at", "measured", "fitted", "standard deviation", "misfit"], rows)
    _write_record(study, fit, ends)
    print(save(draw_fit(plan.data, study.results(fit.z), predicted), study.folder / "fit.png"))


def _write_record(study: FitStudy, fit: Fit, ends: list[Minimum]) -> None:
    plan = study.plan
    parameters = {each.name: {"value": fit.values[each.name], "by_log": each.by_log, "sd": _finite(fit.sd[each.name]),
                              "interval_95": [_finite(end) for end in fit.interval[each.name]]}
                  for each in plan.parameters}
    starts = [{"values": {each.name: each.given(z) for each, z in zip(plan.parameters, end.z)}, "cost": end.cost,
               "converged": end.converged} for end in ends]
    best = study.run_at(fit.z)
    record = {"parameters": parameters, "correlation": fit.correlation.tolist(), "starts": starts,
              "run": best.label, "settings": best.case.settings, "runs": len(study.outcomes), "warnings": fit.remarks}
    (study.folder / "fit.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
