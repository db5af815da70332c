# SPDX-License-Identifier: BSD-3-Clause
"""Misfits of a scene against measured data, by runs that are kept."""

from pathlib import Path

import numpy as np

from plotting.results import Results
from sampling.study import Outcome, Study

from .least_squares import FitError
from .plan import MISFIT, FitPlan

REFUSED = (2, 3)  # exit codes: settings that are refused together, a step that cannot be solved


class FitStudy(Study):
    """The runs of a fit in a folder, as those of a study; which runs there are follows from the fit. A repeated command
    asks for these runs again and finds them there."""

    def __init__(self, plan: FitPlan, folder: Path, at_once: int | None):
        super().__init__(plan, folder, at_once)
        self.last_refusal = ""
        self._at: dict[tuple[float, ...], Outcome] = {}
        self._predicted: dict[int, list[np.ndarray]] = {}  # by number of the run

    def forget_failed(self) -> None:
        for note in self.runner.folder.glob("*.run.json"):
            label = note.name.removesuffix(".run.json")
            if not Results(self.runner.folder / label).completed:
                self.runner.forget(label)

    def misfits(self, points: list[np.ndarray]) -> list[np.ndarray | None]:
        """Misfits in standard deviations at each point; None: the run came to no end with these values.

        @raises FitError  a run failed for another reason than its values
        """
        begun: list[Outcome] = []
        for z in points:
            if self._key(z) not in self._at:
                case = self.plan.case(len(self.outcomes), z)
                outcome = Outcome(case, self._label(case))
                self._at[self._key(z)] = outcome
                self.outcomes.append(outcome)
                begun.append(outcome)
        if begun:
            self.run(begun)
        for outcome in begun:
            said = f"run {outcome.case.number} ({outcome.label}) {outcome.status}"
            if outcome.code in REFUSED:
                self.last_refusal = said
            elif not outcome.completed:
                raise FitError(said)
        return [self._misfit(self.run_at(z)) for z in points]

    def run_at(self, z: np.ndarray) -> Outcome:
        """Note a run that was asked for."""
        return self._at[self._key(z)]

    def predicted(self, z: np.ndarray) -> list[np.ndarray]:
        """Values of a completed run in the place of each data set."""
        return self._predicted[self.run_at(z).case.number]

    def results(self, z: np.ndarray) -> Results:
        return Results(self.runner.folder / self.run_at(z).label)

    def _key(self, z: np.ndarray) -> tuple[float, ...]:
        return tuple(each.given(share) for each, share in zip(self.plan.parameters, z))

    def _misfit(self, outcome: Outcome) -> np.ndarray | None:
        found = self._predicted.get(outcome.case.number)
        if found is None:
            return None
        return np.concatenate([(values - each.values) / each.deviation for values, each in zip(found, self.plan.data)])

    def _take(self, outcome: Outcome, results: Results) -> None:
        self._predicted[outcome.case.number] = [each.predicted(results) for each in self.plan.data]
        outcome.answers = {MISFIT: float(np.sqrt(np.mean(self._misfit(outcome) ** 2)))}
