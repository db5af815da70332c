# SPDX-License-Identifier: BSD-3-Clause
"""How far runs of granular_obstacle differ whose soil differs by a last digit, and when."""

import numpy as np

from plotting.style import legend_beside, new_figure
from studies.contact import STEPS, explicit
from studies.coupled import ANSWER_NAMES, REST, SCENE, answer_of
from studies.ensemble import over_places, with_other_modulus
from studies.measures import Curve, Measured
from studies.runner import Runner

CHANGES = [1e-12, 1e-9, 1e-6, 1e-4]  # of the modulus from member to member
TIMES = [0.02, 0.06, 0.1, 0.11, 0.12, 0.13, 0.14, 0.16, 0.2, 0.3, 0.5]  # [s]
MEMBERS = 4


def kinetic_energy(run: Measured) -> Curve:
    """Kinetic energy of the soil [J/m]."""
    table = run.table("probes.csv")
    return Curve(table["time"], table["soil.kinetic_energy"])


def parting(runs: list[Measured], curve_of) -> Curve:
    """Root mean square over the members of the difference from the first, by the largest value of it."""
    first, *others = map(curve_of, runs)
    squares = [(other.at(first.time) - first.values) ** 2 for other in others]
    return Curve(first.time, np.sqrt(np.mean(squares, axis=0)) / np.max(np.abs(first.values)))


def deviations(name: str, runs: list[Measured]) -> list:
    return [name, len(runs), *(100 * float(np.std(values, ddof=1) / abs(np.mean(values)))
                               for values in zip(*map(answer_of, runs)))]


def scatter(runner: Runner) -> None:
    """How far runs of granular_obstacle differ whose soil differs by a last digit."""
    dt = STEPS["5"]
    of_change = {change: with_other_modulus(runner, f"modulus {change:g}", SCENE, explicit(dt), MEMBERS, change)
                 for change in CHANGES}
    of_place = over_places(runner, "place", SCENE, explicit(dt), 2 * MEMBERS, 5e-3)
    head = ["", "runs", *(f"{name} [%]" for name in ANSWER_NAMES)]
    runner.report(head, [deviations(f"modulus by {change:g}", runs) for change, runs in of_change.items()]
                  + [deviations("place of the wall in its cell", of_place)],
                  "standard deviation of one run, by what differs between runs")
    figure, (axes,) = new_figure(9, 4.5)
    rows = []
    for change, runs in of_change.items():
        energy = parting(runs, kinetic_energy)
        rows.append([f"{change:g}", *map(float, energy.at(np.array(TIMES)))])
        axes.semilogy(energy.time, energy.values, label=f"{change:g}")
    runner.report(["change", *(f"{t:g} s" for t in TIMES)], rows, "difference of the soil's kinetic energy")
    runner.remark("difference: root mean square of the differences from the first run, over the largest kinetic "
                  f"energy; residual displacement and force at rest: mean of the last {REST} s; explicit steps of "
                  f"{1e3 * dt:g} ms")
    axes.set_ylim(1e-15, 1)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("difference of the kinetic energy")
    legend_beside(axes)
    runner.save(figure, "scatter.png")


STUDIES = {"scatter": scatter}
