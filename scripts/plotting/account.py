# SPDX-License-Identifier: BSD-3-Clause
"""Sums over the rows of a run as they come: how its steps ended, their cost, and its balances."""

import re
from collections import Counter
from dataclasses import dataclass, field

Row = dict[str, str]
CUT = re.compile(r"step (\d+) at (\S+) s: dt cut (?:from \S+ )?to \S+ s: (.*)")
NUMBER = re.compile(r"(?<![\w\"])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")
FINE = ("converged", "inactive", "explicit")  # of steps.csv: status
# Columns of probes.csv, behind the name of the participant, that are kept.
LEDGER = re.compile(r"(?:^|\.)(mass|gravity_work|boundary_work|external_work|kinetic_energy|elastic_energy"
                    r"|damping_work|plastic_work|damage_work|brake_work|failed_energy"
                    r"|energy_balance|created_energy|contact_created|momentum_(?:error_)?[xyz])$")


def number(row: Row, name: str) -> float:
    """0 where the table has no such column or nothing in it."""
    return float(row.get(name) or 0)


@dataclass
class Steps:
    """Sums over the rows of steps.csv. Times in s."""

    count: int = 0
    time: float = 0.0
    statuses: Counter = field(default_factory=Counter)
    first_unconverged: Row | None = None
    in_contact: int = 0
    iterations_in_contact: int = 0
    most_iterations: int = 0
    newton_iterations: int = 0  # of a run without coupler
    most_newton: int = 0
    cut: int = 0  # cuts of accepted steps
    first_cut: Row | None = None
    numbers: list[str] = field(default_factory=list)  # of the steps, as wall and parts
    wall: list[float] = field(default_factory=list)
    awaited: list[str] = field(default_factory=list)  # the participants' computing, and "messages"
    parts: list[tuple[float, ...]] = field(default_factory=list)  # time for each of `awaited`
    soil_work: float = 0.0
    most_soil_work: float = 0.0  # largest |soil_work| so far
    made_work: float = 0.0  # sum of work_sum

    def add(self, row: Row) -> None:
        self.count, self.time = self.count + 1, number(row, "time")
        status = row.get("status", "")
        self.statuses[status] += 1
        if status and status not in FINE and self.first_unconverged is None:
            self.first_unconverged = row
        iterations = int(number(row, "iterations"))
        if status != "inactive":
            self.in_contact += 1
            self.iterations_in_contact += iterations
        self.most_iterations = max(self.most_iterations, iterations)
        newton = int(number(row, "newton_iterations"))
        self.newton_iterations += newton
        self.most_newton = max(self.most_newton, newton)
        cuts = int(number(row, "cuts"))
        if cuts and self.first_cut is None:
            self.first_cut = row
        self.cut += cuts
        self.soil_work += number(row, "soil_work")
        self.most_soil_work = max(self.most_soil_work, abs(self.soil_work))
        self.made_work += number(row, "work_sum")
        self._add_seconds(row)

    def _add_seconds(self, row: Row) -> None:
        if not self.wall:
            names = [name.removesuffix(".busy_seconds") for name in row if name.endswith(".busy_seconds")]
            self.awaited = [*names, "messages"] if names else []
        self.numbers.append(row.get("step", ""))
        self.wall.append(number(row, "wall_seconds"))
        if self.awaited:
            names = self.awaited[:-1]
            messages = sum(number(row, f"{name}.message_seconds") for name in names)
            self.parts.append((*(number(row, f"{name}.busy_seconds") for name in names), messages))


@dataclass
class Ledger:
    """First, last, lowest and largest value of each column of probes.csv that balances are made of."""

    first: dict[str, float] = field(default_factory=dict)
    last: dict[str, float] = field(default_factory=dict)
    lowest: dict[str, float] = field(default_factory=dict)
    largest: dict[str, float] = field(default_factory=dict)

    def add(self, row: Row) -> None:
        if not self.first:
            self.first = {name: float(value) for name, value in row.items() if LEDGER.search(name) and value}
        for name in self.first:
            value = number(row, name)
            self.last[name] = value
            self.lowest[name] = min(self.lowest.get(name, value), value)
            self.largest[name] = max(self.largest.get(name, 0.0), abs(value))

    @property
    def per_metre(self) -> str:
        """Ending of units: in plane strain energy and momentum are per metre."""
        return "" if any(name.endswith("momentum_z") for name in self.first) else "/m"

    def owners(self, column: str) -> list[str]:
        """Prefixes of the participants that have this column: "soil.", or "" of a run without coupler."""
        return [name.removesuffix(column) for name in self.first if f".{name}".endswith(f".{column}")]

    def size(self, prefix: str, *columns: str) -> float:
        return max((self.largest.get(prefix + column, 0.0) for column in columns), default=0.0)


@dataclass
class Cuts:
    """Rejected tries of steps and their reasons, from the log; where there is none, from iterations.csv."""

    reasons: Counter = field(default_factory=Counter)
    examples: dict[str, str] = field(default_factory=dict)  # of each reason, in full
    verdicts: Counter = field(default_factory=Counter)  # of the last iteration of a try that did not end well
    _last: Row | None = None

    def add_line(self, line: str) -> None:
        found = CUT.search(line)
        if found:
            reason = NUMBER.sub("…", found[3].partition(";")[0].replace('participant "', '"')).strip()
            reason = re.sub(r", iteration …", "", re.sub(r"\(…(?:, …)+\)", "…", reason))
            self.reasons[reason] += 1
            self.examples.setdefault(reason, found[3])

    def add_iteration(self, row: Row) -> None:
        before, self._last = self._last, row
        if before and row["iteration"] == "0" and row["step"] == before["step"]:
            self.verdicts[before["status"]] += 1

    def why(self) -> list[tuple[str, int]]:
        """Reasons with their counts, the most frequent first."""
        if self.reasons:
            return self.reasons.most_common()
        words = Counter()
        for verdict, count in self.verdicts.items():
            solver = verdict in ("going_on", *FINE)  # the iteration was not the cause
            words["a solver found no solution" if solver else verdict.replace("_", " ")] += count
        return words.most_common()
