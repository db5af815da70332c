# SPDX-License-Identifier: BSD-3-Clause
"""Run a plan into a folder, again and again until all runs are there, and write their evaluation."""

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from measured import text_of, version
from plotting.results import Results
from studies.identity import STUDY
from studies.measures import Curve
from studies.runner import CORES, Attempt, Runner, Start, print_table, write_table

from .answers import curve_of
from .plan import COLUMNS, Case, Plan
from .reader import PlanError

RUNS = "runs"


@dataclass
class Outcome:
    """Outcome of a case. status: completed, or why not; answers: NaN where there is none."""

    case: Case
    label: str
    status: str = "not run"
    code: int | None = None  #: exit code; None: not run, or no end
    answers: dict[str, float] = field(default_factory=dict)
    curves: dict[str, Curve] = field(default_factory=dict)

    @property
    def completed(self) -> bool:
        return self.status == "completed"


class Study:
    """The runs of a plan in a folder: FOLDER/runs/LABEL, with its settings in LABEL.run.json.

    The label follows from all that a run reads, so results are never those of other settings. A run that is there is
    not repeated, also where the plan has changed since.
    """

    def __init__(self, plan: Plan, folder: Path, at_once: int | None):
        self.plan, self.folder = plan, folder
        words = ("--ranks", ",".join(f"{kind}={count}" for kind, count in plan.ranks.items())) if plan.ranks else ()
        at_once = at_once or max(1, CORES // max(1, sum(plan.ranks.values())))
        self.runner = Runner(folder / RUNS, True, [], Start(at_once, None, words))
        self.outcomes = [Outcome(case, self._label(case)) for case in plan.cases()]

    def _label(self, case: Case) -> str:
        return self.runner.identity(str(self.plan.scene), case.settings)[:12]

    def claim(self) -> None:
        """Make the folder, and keep the plan in it. @raises PlanError  it holds other files than those of a study"""
        self.folder.mkdir(parents=True, exist_ok=True)
        others = [path.name for path in self.folder.iterdir() if not path.name.startswith(".gabion_lock")]
        if others and STUDY not in others:
            raise PlanError(f"{self.folder}: found {', '.join(sorted(others)[:3])}, allowed: a new or empty folder, or "
                            f"that of a study, which has a {STUDY}")
        about = {"plan": json.loads(self.plan.path.read_text(encoding="utf-8")), "scene": str(self.plan.scene),
                 "seed": self.plan.design.seed, "version": version()}
        if self.outcomes:  # those of a fit follow from one another
            about["runs"] = len(self.outcomes)
        text = json.dumps(about, indent=1) + "\n"
        mark = self.folder / STUDY
        if not mark.exists() or mark.read_text(encoding="utf-8") != text:
            mark.write_text(text, encoding="utf-8")

    def forget_failed(self) -> None:
        """Let runs that came to a step that cannot be solved be run again."""
        for outcome in self.outcomes:
            output = self.runner.folder / outcome.label
            if output.is_dir() and not Results(output).completed:
                self.runner.forget(outcome.label)

    def same_before(self, number: int) -> int | None:
        """The first run with the same settings as this one; None: it is the first."""
        first = next(outcome.case.number for outcome in self.outcomes if outcome.label == self.outcomes[number].label)
        return first if first < number else None

    def run(self, chosen: list[Outcome]) -> None:
        """Run the cases that are missing. A run that fails is reported, and the others go on.

        @raises ResultsError  a completed run lacks what the plan asks for: no further run begins
        """
        of_label: dict[str, list[Outcome]] = {}
        for outcome in chosen:
            of_label.setdefault(outcome.label, []).append(outcome)
        done = 0

        def ended(label: str, attempt: Attempt) -> None:
            nonlocal done
            done += 1
            for outcome in of_label[label]:
                self._read(outcome, attempt)
            first = of_label[label][0]
            print(f"{done} of {len(of_label)}: run {first.case.number} ({label}): {first.status}", flush=True)

        scene = str(self.plan.scene)
        self.runner.attempts([(label, scene, same[0].case.settings) for label, same in of_label.items()], ended)

    def _read(self, outcome: Outcome, attempt: Attempt) -> None:
        """@raises ResultsError  a completed run without what the plan asks for"""
        outcome.code = None if attempt.reason else attempt.code
        if attempt.code == 0:
            self._take(outcome, attempt.results)
            outcome.status = "completed"
            return
        outcome.status = f"failed: {self._reason(outcome.label, attempt)}"
        outcome.answers = {answer.name: math.nan for answer in self.plan.answers}

    def _take(self, outcome: Outcome, results: Results) -> None:
        """The answers that the plan asks for. @raises ResultsError  they are not there"""
        outcome.answers = {answer.name: answer.of(results) for answer in self.plan.answers}
        outcome.curves = {name: curve_of(results, *place) for name, place in self.plan.bands.items()}

    def _reason(self, label: str, attempt: Attempt) -> str:
        if attempt.reason:
            return attempt.reason
        if attempt.results is not None and (attempt.results.summary or {}).get("reason"):
            return " ".join(attempt.results.summary["reason"].split())
        log = self.runner.folder / f"{label}.log"
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines() if log.exists() else []
        errors = [line.partition("error: ")[2] for line in lines if "error: " in line]
        return f"exit code {attempt.code}: {errors[-1] if errors else 'see ' + str(log)}"

    def table(self) -> tuple[list[str], list[list[Any]]]:
        """A row a run: its number, point, repeat, label, seed of the design, status, parameters, answers."""
        parameters = [parameter.name for parameter in self.plan.parameters]
        answers = [answer.name for answer in self.plan.answers]
        head = [*COLUMNS, *parameters, *answers]
        rows = []
        for outcome in self.outcomes:
            case = outcome.case
            given = [value if isinstance(value, (int, float, str)) else json.dumps(value)
                     for value in map(case.values.get, parameters)]
            found = [outcome.answers.get(name, math.nan) for name in answers]
            rows.append([case.number, case.point, case.repeat, outcome.label, self.plan.design.seed, outcome.status,
                         *given, *("" if math.isnan(value) else value for value in found)])
        return head, rows

    def values(self, name: str) -> np.ndarray:
        """Values of a parameter or an answer in all runs, NaN where there is none; [num_runs]."""
        return np.array([float(outcome.case.values.get(name, outcome.answers.get(name, math.nan)))
                         for outcome in self.outcomes])

    def report(self, name: str, head: list[str], rows: list[list[Any]]) -> None:
        """Print a table and write it as NAME.csv."""
        print(f"\n{name}")
        print_table(head, [[text_of(value) for value in row] for row in rows])
        write_table(self.folder / f"{name}.csv", head, rows)
