# SPDX-License-Identifier: BSD-3-Clause
"""Numbers by which runs are compared."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from plotting.history import displacement_columns, probe_points
from plotting.results import Results, ResultsError, is_completed


@dataclass
class Curve:
    """Values over time; both num_samples."""

    time: np.ndarray
    values: np.ndarray

    def at(self, time: np.ndarray) -> np.ndarray:
        """Values at other times, linear between samples."""
        return np.interp(time, self.time, self.values)

    def mean_of_last(self, duration: float) -> float:
        """Mean over the last `duration` [s], weighted by time (trapezoidal rule)."""
        start = self.time[-1] - duration
        if start < self.time[0]:
            raise ResultsError(f"the run is shorter than {duration} s")
        time = np.concatenate([[start], self.time[self.time > start]])
        return float(np.trapezoid(self.at(time), time) / duration if hasattr(np, "trapezoid")
                     else trapezoid(self.at(time), time) / duration)


def relative_rms(curve: Curve, reference: Curve) -> float:
    """Root mean square of the difference over that of the reference, at the reference's times.

    Both curves must end at the same time: a run that stopped early is no small error.
    """
    if not np.isclose(curve.time[-1], reference.time[-1], rtol=1e-9):
        raise ResultsError(f"curves end at {curve.time[-1]:g} s and {reference.time[-1]:g} s")
    size = np.sqrt(np.mean(reference.values**2))
    if size == 0:
        raise ResultsError("the reference curve is zero everywhere")
    return float(np.sqrt(np.mean((curve.at(reference.time) - reference.values) ** 2)) / size)


class Measured:
    """Answers of one run to the studies."""

    def __init__(self, results: Results, point: str = "A"):
        self.results = results
        self.point = point
        self.summary = results.summary
        if not is_completed(self.summary):
            raise ResultsError(f"{results.folder}: the run did not come to its end")

    def table(self, file: str):
        """@raises ResultsError  not there, or empty"""
        table = self.results.table(file)
        if table is None or not table.num_rows:
            raise ResultsError(f"{self.results.folder}: no {file}, or no row in it")
        return table

    def displacement(self) -> Curve:
        """Horizontal displacement of the point [m]."""
        table = self.table("probes.csv")
        for name in probe_points(table):
            if name.rpartition(".")[2] == self.point:
                return Curve(table["time"], table[displacement_columns(table, name)[0]])
        raise ResultsError(f"{table.path}: no displacement of a point {self.point}")

    def peak(self) -> tuple[float, float]:
        """Largest horizontal displacement of the point [m], and when [s]."""
        a = self.displacement()
        at = int(np.argmax(np.abs(a.values)))
        return float(a.values[at]), float(a.time[at])

    def force(self) -> Curve:
        """Horizontal force of the soil on the structure [N/m]."""
        table = self.table("steps.csv")
        return Curve(table["time"], table["fx"])

    def impulse(self) -> Curve:
        """Integral of the force over time [N s/m]: each step's force holds through the step."""
        force = self.force()
        return Curve(force.time, np.cumsum(force.values * self.table("steps.csv")["dt"]))

    def seconds(self) -> float:
        """Wall time of the run [s]."""
        return float(self.summary["wall_seconds"]["total"])

    def cpu_seconds(self) -> float:
        """CPU time of a run without coupler, of its first rank [s]."""
        if "cpu_seconds" not in self.summary:
            raise ResultsError(f"{self.results.folder}: no cpu_seconds in the summary")
        return float(self.summary["cpu_seconds"])

    def solver_seconds(self, what: str = "cpu_seconds") -> float:
        """CPU time of all solvers of a coupled run, of all ranks [s]. what: "output_cpu_seconds" for that of frames and
        checkpoints."""
        return sum(of[what]["all_ranks"] for of in self.summary["participants"].values())

    def newton_per_step(self) -> float:
        """Newton iterations of the accepted tries by the number of steps, in a run without coupler."""
        return self.summary["newton_iterations"] / self.summary["steps"]

    def iterations_in_contact(self) -> np.ndarray:
        """Coupling iterations of the steps in which soil and structure could be in contact."""
        table = self.table("steps.csv")
        return table["iterations"][table["skipped"] == "none"]

    def cuts(self) -> int:
        """Steps that were repeated with a smaller dt."""
        return int(self.summary["cuts"])
