# SPDX-License-Identifier: BSD-3-Clause
"""The soil on several MPI ranks: time, memory, what they send each other; and how that would go on with many."""

import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from running.mpi import find_launcher
from studies.instructions import FORMS, SOLVER, has_run, solve
from studies.runner import Runner, folder_of
from studies.size import read, refined

RANKS = (1, 2, 4, 8)
COUNTER = SOLVER.parent / "libgabion_mpi_counter.so"  # counts what ranks send
REPEATS = 3  # of 1 and 2 ranks in turn: the fastest of each counts
STEPS = 10


@dataclass
class Soil:
    """A column of sand, as instructions.scene has it, in finer cells."""

    form: str
    times: int  #: cells along an edge by those of instructions.scene
    dt: float  #: [s]
    late: float  #: when its steps are measured the second time [s]
    wanted: float  #: one rank's time over that of two, on a quiet machine


SOILS = {
    "plane, 20,000 points": Soil("quad4, gimp, F-bar", 2, 5e-4, 0.12, 1.4),
    "plane, 80,000 points": Soil("quad4, gimp, F-bar", 4, 4e-4, 0.12, 1.7),
    "space, 64,000 points": Soil("hex8, gimp, F-bar", 2, 1.5e-3, 0.12, 1.7),
}
WANTED_MEMORY = 0.6  # of a rank over that of the run on one

# Constants of the model: what a message and a byte cost, and a collective call by the logarithm of the ranks.
LATENCY = 2e-6  # [s]
BANDWIDTH = 10e9  # [B/s]
FACTORS = (1, 100)  # sizes that the model is asked for, by those measured
MANY = (8, 64, 512)


@dataclass
class Count:
    """Counts of one run: the largest over the ranks, but for totals."""

    points: int
    steps: int
    newton: int  #: iterations
    linear: int  #: iterations
    seconds: float  #: of all steps
    memory: float  #: of the largest rank [B]
    cpu: float = math.inf  #: of the first rank, start and output included [s]
    share: float = 1  #: points of the fullest rank by their mean
    neighbours: int = 0
    messages: float = 0
    message_bytes: float = 0
    collectives: float = 0
    waiting: float = 0  #: share of the time of all ranks

    @property
    def computing(self) -> float:
        """Time of an iteration of one rank alone, on a loaded machine not its wall time [s]."""
        return min(self.seconds, self.cpu) / self.newton


def settings_of(soil: Soil, end: float) -> dict:
    settings = refined(FORMS[soil.form], soil.times)
    settings["time"] = {"end": end, "dt": soil.dt, "dt_min": soil.dt / 256}
    settings["checkpoint"] = {}
    return settings


THREADS = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OMPI_MCA_mpi_yield_when_idle": "1"}


def mpirun(ranks: int) -> list[str]:
    """Words of a launch. @raises LauncherError  there is no mpirun of Open MPI"""
    return [*find_launcher().words, "-n", str(ranks)]


def launch(folder: Path, settings: dict, ranks: int, restart: Path | None = None) -> Path:
    """Run on so many ranks, from the last checkpoint of other results if given; returns the results."""
    command = [*mpirun(ranks), "-x", f"LD_PRELOAD={COUNTER}", SOLVER, "--log-level", "warn",
               *([] if restart is None else ["--restart", restart])]
    solve(folder, settings, command, THREADS)
    return folder / "out"


def results(runner: Runner, folder: Path, settings: dict, ranks: int, restart: Path | None = None) -> Path:
    """Results of an earlier run where they may be taken, else of a new one."""
    if runner.reuse and has_run(folder, settings):
        return folder / "out"
    print(f"{folder.name}: running", flush=True)
    return launch(folder, settings, ranks, restart)


def count_of(out: Path) -> Count:
    summary, steps = read(out)
    soil = summary["solver"]
    seconds = float(np.sum(steps["wall_seconds"]))
    count = Count(soil["points"], steps.num_rows, soil["newton_iterations"], soil["linear_iterations"], seconds,
                  soil["peak_memory"]["largest_rank"], summary["cpu_seconds"])
    if "ranks" in soil:
        of_ranks, traffic = soil["ranks"], soil["mpi"]
        count.share, count.neighbours = of_ranks["largest_share"], of_ranks["neighbours"]
        for name in ("messages", "message_bytes", "collectives"):
            setattr(count, name, traffic[name]["largest_rank"])
        count.waiting = traffic["waiting_seconds"]["all_ranks"] / (of_ranks["number"] * seconds)
    return count


HEAD = ["ranks", "time of one rank over this", "Newton a step", "linear a Newton", "memory over that of one rank",
        "largest part by mean",
        "neighbours", "messages an iteration", "messages a step", "kB an iteration", "kB a step",
        "collectives an iteration",
        "waiting"]


def row(ranks: int, count: Count, one: Count) -> list:
    """Row of the table. Messages and bytes are those of the rank with the most."""
    newton, steps = count.newton, count.steps
    kilobytes = count.message_bytes / 1e3
    return [ranks, one.seconds / count.seconds, newton / steps, count.linear / newton, count.memory / one.memory,
            count.share, count.neighbours, count.messages / newton, count.messages / steps, kilobytes / newton,
            kilobytes / steps, count.collectives / newton, f"{100 * count.waiting:.0f} %"]


def faces(ranks: int, dimension: int) -> float:
    """Mean number of sides that a part shares with others, in a cube of equal cubes; of 2^dimension parts:
    dimension."""
    return 2 * dimension * (1 - ranks ** (-1 / dimension))


def most_neighbours(ranks: int, dimension: int) -> float:
    """Largest number of neighbours of a part in a cube of equal cubes, corners counted."""
    return min(ranks, 3**dimension) - 1


def modelled(one: Count, many: Count, ranks: tuple[int, int], dimension: int, factor: float) -> list[float]:
    """Seconds of an iteration: computing, messages, bytes, collectives.

    many: of a run on ranks[0]; asked for: ranks[1], with points that are `factor` times as many.
    """
    measured, asked = ranks
    computing = one.computing * factor / asked * many.share
    messages = many.messages / many.newton * most_neighbours(asked, dimension) / max(many.neighbours, 1)
    side = (factor * measured / asked) ** ((dimension - 1) / dimension)
    size = many.message_bytes / many.newton * side * faces(asked, dimension) / faces(measured, dimension)
    collectives = many.collectives / many.newton * math.log2(asked)
    return [computing, messages * LATENCY, size / BANDWIDTH, collectives * LATENCY]


MODEL_HEAD = ["soil", "points", "ranks", "an iteration [ms]", "computing", "messages", "bytes", "collectives",
              "faster than one",
              "efficiency"]


def model_rows(name: str, one: Count, many: Count) -> list[list]:
    dimension = 2 if name.startswith("plane") else 3
    rows = []
    for factor in FACTORS:
        for ranks in MANY:
            parts = modelled(one, many, (RANKS[-1], ranks), dimension, factor)
            alone, total = factor * one.computing, sum(parts)
            rows.append([name.partition(",")[0], round(factor * one.points), ranks, 1e3 * total,
                         *(f"{100 * part / total:.0f} %" for part in parts), alone / total,
                         f"{100 * alone / total / ranks:.0f} %"])
    return rows


def measure(runner: Runner, name: str, soil: Soil, when: str, restart: Path | None) -> dict[int, Count]:
    """Counts by the number of ranks."""
    end = (0 if restart is None else soil.late) + STEPS * soil.dt
    counts: dict[int, Count] = {}
    for repeat in range(REPEATS):
        for ranks in RANKS if repeat == 0 else RANKS[:2]:
            folder = runner.folder / f"{folder_of(name)}_{folder_of(when)}_{ranks}_{repeat}"
            found = count_of(results(runner, folder, settings_of(soil, end), ranks, restart))
            counts[ranks] = min(found, counts.get(ranks, found), key=lambda count: count.seconds)
    return counts


def ranks(runner: Runner) -> None:
    """The soil on 1, 2, 4 and 8 MPI ranks: time, memory, messages; a model of 64 and 512 ranks."""
    models, met = [], []
    for name, soil in SOILS.items():
        collapse = results(runner, runner.folder / f"{folder_of(name)}_collapse", settings_of(soil, soil.late), 1)
        for when, restart in (("at the start", None), (f"at {soil.late:g} s", collapse)):
            counts = measure(runner, name, soil, when, restart)
            rows = [row(number, count, counts[1]) for number, count in counts.items()]
            runner.report(HEAD, rows, f"{name}, {when}")
            gain, memory = rows[1][1], rows[1][4]
            met.append(f"{name}, {when}: {gain:.2f} ({soil.wanted}) and {memory:.2f} ({WANTED_MEMORY})")
        models += model_rows(name, counts[1], counts[RANKS[-1]])
    runner.remark("speed-up by two ranks, and memory of one of them over that of one rank alone, in brackets the "
                  f"goals: {'; '.join(met)}")
    runner.report(MODEL_HEAD, models, "model")


STUDIES = {"ranks": ranks}
