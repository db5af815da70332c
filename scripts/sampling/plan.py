# SPDX-License-Identifier: BSD-3-Clause
"""A plan: a scene, parameters, a design, and the answers to take from the runs (docs/studies.md)."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .answers import Answer, read_answer, read_column
from .design import Design, points_of, read_correlations, read_design
from .parameters import KEYS, Parameter, read_parameter, require_apart
from .reader import PlanError, PlanReader, is_number, read_object

sys.path.append(str(Path(__file__).resolve().parents[2]))
from gabion.errors import SettingError  # noqa: E402
from gabion.scene import Scene  # noqa: E402

COLUMNS = ("run", "point", "repeat", "label", "seed", "status")  # of the table of runs, beside parameters and answers
MOST_RUNS = 100_000
PLAN_KEYS = ("scene", "settings", "parameters", "correlations", "design", "repeats", "answers", "bands", "fragility",
             "ranks")
SOLVERS = ("mpm", "fem")  # that have ranks


@dataclass(frozen=True)
class Repeats:
    """Each point is run so many times, with the value of a setting times 1 + change k in run k of them: soil that hits
    something amplifies round-off, so that one run is a sample of what the settings give."""

    count: int
    path: str
    change: float


@dataclass(frozen=True)
class Fragility:
    """Probability that a demand exceeds a capacity, over an intensity: names of answers or parameters, or a number."""

    name: str
    demand: str
    capacity: str | float
    intensity: str


@dataclass(frozen=True)
class Case:
    """One run: number, point, which of its repeats, value of each parameter, settings of scripts/run."""

    number: int
    point: int
    repeat: int
    values: dict[str, Any]
    settings: list[str]


@dataclass(frozen=True)
class Plan:
    """bands: name -> table and column; ranks: of solvers, as of --ranks of scripts/run, empty: one each."""

    path: Path
    scene: Path
    settings: dict[str, Any]
    parameters: list[Parameter]
    design: Design
    correlations: np.ndarray
    repeats: Repeats | None
    answers: list[Answer]
    bands: dict[str, tuple[str, str]]
    fragilities: list[Fragility]
    ranks: dict[str, int]

    def points(self) -> list[dict[str, Any]]:
        return points_of(self.parameters, self.design, self.correlations)

    def cases(self) -> list[Case]:
        """All runs, in their order. @raises PlanError  a setting that the scene cannot have"""
        points = self.points()
        count = self.repeats.count if self.repeats else 1
        if len(points) * count > MOST_RUNS:
            raise PlanError(f"{self.design.where}: found {len(points) * count} runs, allowed: {MOST_RUNS} at most")
        return [Case(k * count + repeat, k, repeat, point, self._settings(point, repeat))
                for k, point in enumerate(points) for repeat in range(count)]

    def _settings(self, point: dict[str, Any], repeat: int) -> list[str]:
        scene = Scene(self.scene)
        for path, value in self.settings.items():
            set_in(scene, path, value, f"{self.path}:/settings")
        for parameter in self.parameters:
            for path, value in parameter.settings(point[parameter.name]).items():
                set_in(scene, path, value, parameter.where)
        if self.repeats and repeat:
            value = scene[self.repeats.path]
            set_in(scene, self.repeats.path, value * (1 + self.repeats.change * repeat), f"{self.path}:/repeats")
        return scene.options


def set_in(scene: Scene, path: str, value: Any, where: str) -> None:
    """@raises PlanError  a setting that the scene cannot have"""
    try:
        scene[path] = value
    except SettingError as error:
        raise PlanError(f"{where}: {error}") from error


def read_plan(path: Path) -> Plan:
    """@raises PlanError  with the place in the file, what was found and what is allowed"""
    top = PlanReader(read_object(path), f"{path}:", PLAN_KEYS)
    scene = path.parent / top.text("scene", "a folder, from that of the plan")
    try:
        Scene(scene)
    except SettingError as error:
        raise PlanError(f"{path}:/scene: {error}") from error
    settings = top.inner("settings", None).values if "settings" in top.values else {}
    parameters = [read_parameter(name, reader) for name, reader in top.named("parameters", KEYS).items()]
    if not parameters:
        raise top.fail("parameters", "an object with at least one")
    require_apart(parameters, settings)
    design = read_design(top.inner("design", ("method", "runs", "seed", "cross")), parameters)
    correlations = read_correlations(top, parameters, design)
    answers = [read_answer(name, reader)
               for name, reader in top.named("answers", ("table", "column", "take", "summary")).items()]
    bands = {name: read_column(reader) for name, reader in top.named("bands", ("table", "column")).items()}
    if not answers and not bands:
        raise top.fail("answers", "an object with at least one, or bands")
    names = [*(parameter.name for parameter in parameters), *(answer.name for answer in answers)]
    if len(set(names)) < len(names):
        raise PlanError(f"{path}:/answers: found the name of a parameter, allowed: other names")
    for name in names:
        if name in COLUMNS:
            kind = "answers" if any(name == answer.name for answer in answers) else "parameters"
            raise PlanError(f"{path}:/{kind}: found the name {name}, allowed: none of {', '.join(COLUMNS)}")
    fragilities = [_read_fragility(name, reader, parameters, answers)
                   for name, reader in top.named("fragility", ("demand", "capacity", "intensity")).items()]
    plan = Plan(path, scene.resolve(), settings, parameters, design, correlations, _read_repeats(top), answers, bands,
                fragilities, read_ranks(top))
    _check_repeats(plan)
    return plan


def read_ranks(top: PlanReader) -> dict[str, int]:
    if "ranks" not in top.values:
        return {}
    reader = top.inner("ranks", SOLVERS)
    return {kind: reader.whole(kind, 1) for kind in reader.values}


def _read_repeats(top: PlanReader) -> Repeats | None:
    if "repeats" not in top.values:
        return None
    reader = top.inner("repeats", ("count", "set", "change"))
    return Repeats(reader.whole("count", 2), reader.text("set", "FILE:/key/key of a number"), reader.number("change"))


def _check_repeats(plan: Plan) -> None:
    """@raises PlanError  the setting that the repeats change is no number of the scene with the plan's settings"""
    if plan.repeats is None:
        return
    scene = Scene(plan.scene)
    where = f"{plan.path}:/repeats/set"
    try:
        scene.update(plan.settings)
        value = scene[plan.repeats.path]
    except SettingError as error:
        raise PlanError(f"{where}: {error}") from error
    if not is_number(value) or value == 0:
        raise PlanError(f"{where}: found {value!r} at {plan.repeats.path}, allowed: a number that is not 0")


def _read_fragility(name: str, reader: PlanReader, parameters: list[Parameter], answers: list[Answer]) -> Fragility:
    numbers = [parameter.name for parameter in parameters
               if parameter.levels is None or all(map(is_number, parameter.levels))]
    asked = [answer.name for answer in answers]
    demand = reader.word("demand", tuple(asked))
    intensity = reader.word("intensity", (*numbers, *asked))
    capacity = reader.values.get("capacity")
    if not is_number(capacity) and capacity not in (*numbers, *asked):
        raise reader.fail("capacity", f"a number, or one of {', '.join((*numbers, *asked))}")
    return Fragility(name, demand, capacity, intensity)
