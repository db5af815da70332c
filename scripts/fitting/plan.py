# SPDX-License-Identifier: BSD-3-Clause
"""Plan of a fit: a scene, parameters between bounds, measured data (docs/studies.md)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from plotting.view import up_axis
from sampling.answers import Answer
from sampling.design import Design
from sampling.parameters import require_apart
from sampling.plan import COLUMNS, Case, Scene, SettingError, read_ranks, set_in
from sampling.reader import PlanError, PlanReader, is_number

from .bounds import Sought, read_sought
from .data import DataSet, OverPlan, OverTime
from .least_squares import Search
from .read_data import KEYS as DATA_KEYS
from .read_data import read_data

PLAN_KEYS = ("scene", "settings", "ranks", "fit")
FIT_KEYS = ("parameters", "data", "samples", "restarts", "seed", "step", "tolerance", "evaluations")
DIGITS = 10  # of values that a run is given: what round-off changes is no new run
MISFIT = "misfit"  # name of the column in the table of runs


@dataclass(frozen=True)
class FitParameter(Sought):
    """paths: FILE:/key/key of each setting that gets its value; where: in the plan; start: value, None: no own one."""

    paths: tuple[str, ...]
    where: str
    start: float | None

    @property
    def all_paths(self) -> set[str]:
        return {*self.paths}

    def given(self, z: float) -> float:
        """Value that a run is given."""
        return float(f"{min(max(self.value(z), self.low), self.high):.{DIGITS}g}")


@dataclass(frozen=True)
class FitPlan:
    """ranks: as of a plan of a study."""

    path: Path
    scene: Path
    settings: dict[str, Any]
    parameters: list[FitParameter]
    data: list[DataSet]
    how: Search
    ranks: dict[str, int]

    answers: ClassVar[list[Answer]] = [Answer(MISFIT)]  # as of the plan of a study
    bands: ClassVar[dict[str, tuple[str, str]]] = {}

    @property
    def design(self) -> Design:
        return Design("fit", f"{self.path}:/fit", seed=self.how.seed)

    def cases(self) -> list[Case]:
        """None before the fit asks for them."""
        return []

    def case(self, number: int, z: np.ndarray) -> Case:
        """A run at z. @raises PlanError  a setting that the scene cannot have"""
        values = {each.name: each.given(share) for each, share in zip(self.parameters, z)}
        return Case(number, number, 0, values, self.scene_at(values).options)

    def scene_at(self, values: dict[str, float]) -> Scene:
        scene = Scene(self.scene)
        for path, value in self.settings.items():
            set_in(scene, path, value, f"{self.path}:/settings")
        for each in self.parameters:
            for path in each.paths if each.name in values else ():
                set_in(scene, path, values[each.name], each.where)
        return scene


def read_fit(path: Path, content: dict) -> FitPlan:
    """@raises PlanError  with the place in the file, what was found and what is allowed"""
    top = PlanReader(content, f"{path}:", PLAN_KEYS)
    scene = path.parent / top.text("scene", "a folder, from that of the plan")
    settings = top.inner("settings", None).values if "settings" in top.values else {}
    fit = top.inner("fit", FIT_KEYS)
    asked = fit.named("data", DATA_KEYS)
    dimension = _dimension(scene, f"{path}:/scene", any("deposit" in each.values for each in asked.values()))
    parameters = [_read_parameter(name, each)
                  for name, each in fit.named("parameters", ("set", "between", "scale", "start")).items()]
    if not parameters:
        raise fit.fail("parameters", "an object with at least one")
    for each in parameters:
        if each.name in (*COLUMNS, MISFIT):
            raise PlanError(f"{each.where}: found the name {each.name}, allowed: none of "
                            f"{', '.join((*COLUMNS, MISFIT))}")
    require_apart(parameters, settings)
    data = [read_data(name, each, path.parent, dimension) for name, each in asked.items()]
    if not data:
        raise fit.fail("data", "an object with at least one data set")
    count = sum(len(each.values) for each in data)
    if count < len(parameters):
        raise PlanError(f"{path}:/fit/data: found {count} measured value{'s' * (count > 1)} for {len(parameters)} "
                        "parameters, allowed: at least as many values")
    how = _read_search(fit, parameters, count)
    plan = FitPlan(path, scene.resolve(), settings, parameters, data, how, read_ranks(top))
    _check_values(plan)
    _check_times(plan)
    _check_places(plan)
    return plan


def _dimension(scene: Path, where: str, wanted: bool) -> int:
    """Dimension of the soil; 0 where it is not wanted: a scene may have no soil. @raises PlanError  no such scene"""
    try:
        found = Scene(scene)
        return found["mpm.json:/dimension"] if wanted else 0
    except SettingError as error:
        raise PlanError(f"{where}: {error}") from error


def _read_parameter(name: str, reader: PlanReader) -> FitParameter:
    paths = reader.words("set")
    bounds = read_sought(name, reader)
    start = reader.values.get("start")
    if "start" in reader.values and not (is_number(start) and bounds.low <= start <= bounds.high):
        raise reader.fail("start", f"a number from {bounds.low:g} to {bounds.high:g}, as \"between\" says")
    return FitParameter(name, bounds.low, bounds.high, bounds.by_log, paths, reader.where, start)


def _read_search(fit: PlanReader, parameters: list[FitParameter], count: int) -> Search:
    """Settings of the search; the defaults suit runs whose answers scatter a little, and that take time. count: of
    measured values."""
    def whole(key: str, otherwise: int, least: int) -> int:
        return fit.whole(key, least) if key in fit.values else otherwise

    def number(key: str, otherwise: float, most: float) -> float:
        found = fit.number(key) if key in fit.values else otherwise
        if found > most:
            raise fit.fail(key, f"a number > 0, at most {most:g}")
        return found

    named = [each.start is not None for each in parameters]
    if any(named) and not all(named):
        missing = parameters[named.index(False)]
        raise PlanError(f"{missing.where}/start: found nothing, allowed: a start of every parameter or of none")
    start = np.array([each.z_of(each.start) for each in parameters]) if all(named) else None
    samples = whole("samples", 8, 1)
    restarts = whole("restarts", min(2, samples), 0 if start is not None else 1)
    if restarts > samples:
        raise fit.fail("restarts", f"at most as many as samples, {samples}")
    return Search(samples, restarts, whole("seed", 1, 0), None, number("step", 0.02, 0.25),
                  number("tolerance", 1e-3, 0.1), whole("evaluations", 40, 1), start, floor=count / 2)


def _check_values(plan: FitPlan) -> None:
    """@raises PlanError  bounds or settings that the scene cannot have"""
    for each in plan.parameters:
        for value in (each.low, each.high):
            plan.scene_at({each.name: value})


def _check_times(plan: FitPlan) -> None:
    """@raises PlanError  data outside the time of the runs, as far as the scene says how long they are"""
    files = plan.scene_at({}).settings
    end = next((files[name]["time"]["end"] for name in ("coupler.json", "mpm.json", "fem.json")
                if is_number(files.get(name, {}).get("time", {}).get("end"))), None)
    if end is None:
        return
    for each in plan.data:
        times = []
        if isinstance(each.source, OverTime):
            times = [float(each.at.min()), float(each.at.max())]
        elif isinstance(each.source, OverPlan) and each.source.time is not None:
            times = [each.source.time]
        for time in times:
            if not 0 <= time <= end * (1 + 1e-9):
                raise PlanError(f"{each.where}: found the time {time:g} s, allowed: 0 to {end:g} s, the time of the "
                                "runs")


def _check_places(plan: FitPlan) -> None:
    """@raises PlanError  data on the plan that the soil cannot reach: none of them over the grid, as far as that is a
    box that all runs have alike"""
    reach = _reach(plan.scene_at({}).settings.get("mpm.json", {}))
    varied = any(path.startswith(("mpm.json:/grid", "mpm.json:/origin")) for each in plan.parameters
                 for path in each.paths)
    if reach is None or varied:
        return
    low, high = reach
    for each in plan.data:
        if isinstance(each.source, OverPlan) and not np.any(np.all((low <= each.at) & (each.at <= high), axis=1)):
            ends = ", ".join(f"{a:.9g} to {b:.9g} m" for a, b in zip(low, high))
            raise PlanError(f"{each.where}: found no point of the data over the grid of the scene, {ends} in map "
                            "coordinates, allowed: at least one; do both have the same origin?")


def _reach(soil: dict) -> tuple[np.ndarray, np.ndarray] | None:
    """Corners of the grid on the plan in map coordinates [m]; None: it is no box, or none that a run would take."""
    dim, box = soil.get("dimension"), soil.get("grid", {}).get("box", {})
    ends = [box.get("low"), box.get("high"), soil.get("origin", [0] * 3)]
    if dim not in (2, 3) or not all(isinstance(end, list) and dim <= len(end) and all(map(is_number, end))
                                    for end in ends):
        return None
    up = up_axis(dim, soil.get("gravity"))
    low, high, origin = (np.array([value for axis, value in enumerate(end[:dim]) if axis != up]) for end in ends)
    return low + origin, high + origin
