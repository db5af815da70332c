# SPDX-License-Identifier: BSD-3-Clause
"""What happens in four coupled scenes: times, speeds, forces, where the soil comes to lie. In the plane per metre."""

import numpy as np

from studies.balances import arrival, front_speed, soil, times
from studies.measures import Measured

LONG = 0.1  # [s] that a blow ends within
BARRIER_BACK = np.array([[49, 7], [52, 20], [50, 33]]) + [1, 0]  # of slide_on_terrain, corners x, y [m]
Quantity = list  # what with its unit, value


def blow(run: Measured) -> list[Quantity]:
    """The first force on the structures: when it begins, its largest value, how long it is above half of that."""
    start, force = arrival(run), run.force()
    first = (force.time > times(run)[start]) & (force.time <= times(run)[start] + LONG)
    largest = float(force.values[first].max())
    above = float(run.table("steps.csv")["dt"][first][force.values[first] > largest / 2].sum())
    return [["soil arrives [s]", float(times(run)[start])],
            [f"speed of its front in the {LONG:g} s before [m/s]", front_speed(run, start, LONG)],
            [f"largest force in {LONG:g} s from then on [kN]", 1e-3 * largest],
            ["it is above half of that for [ms]", 1e3 * above]]


def gate_course(run: Measured) -> list[Quantity]:
    table = run.table("probes.csv")
    return [["foot at the end, up [mm]", 1e3 * float(table["structure.foot.uy"][-1])],
            ["gravity gives [J]", float(soil(run, "gravity_work")[-1])],
            ["dissipated in the sand [J]", float(soil(run, "plastic_dissipation")[-1])],
            ["by friction on the gate [J]", float(soil(run, "contact_friction")[-1])],
            ["stored in the gate [J]", float(table["structure.elastic_energy"][-1])]]


def slope_course(run: Measured) -> list[Quantity]:
    """@note points of the soil have equal masses"""
    back = run.results.settings("fem.json")["mesh"]["box"]["high"][0]
    last = run.results.frames_of_soil()
    x = last.frame(len(last) - 1).points[:, 0]
    beyond = float(np.mean(x > back) * soil(run, "mass")[-1] + soil(run, "removed_mass")[-1])
    piling = (run.force().time > 2) & (run.force().time <= 3)
    return [*blow(run), ["mean force of 2 to 3 s [kN]", 1e-3 * float(run.force().values[piling].mean())],
            ["soil over the barrier at the end [%]", 100 * beyond / float(soil(run, "mass")[0])]]


def terrain_course(run: Measured) -> list[Quantity]:
    """@note the blow ends long after LONG: the gully fills"""
    last = run.results.frames_of_soil()
    frame = last.frame(len(last) - 1)
    x, y = frame.points[:, 0], frame.points[:, 1]
    mass = frame.fields["volume"].ravel() / frame.fields["volume_ratio"].ravel()  # over the density
    behind = x > np.interp(y, BARRIER_BACK[:, 1], BARRIER_BACK[:, 0])
    return [*blow(run)[:2],
            ["half of the soil is slower at the end than [m/s]",
             float(np.median(np.linalg.norm(frame.fields["velocity"], axis=1)))],
            ["soil over the crest or round the ends [%]", 100 * float(mass[behind].sum() / mass.sum())],
            ["substeps of a step, at most", run.summary["participants"]["soil"]["explicit"]["most_in_a_step"]]]


def course(gate: Measured, slope: Measured, posts: Measured, terrain: Measured) -> list[list]:
    """Rows scene, what, value; the scene stands in its first one."""
    of_scenes = {"flexible_gate": gate_course(gate), "slope_barrier": slope_course(slope), "two_posts": blow(posts),
                 "slide_on_terrain": terrain_course(terrain)}
    return [[scene if k == 0 else "", *quantity] for scene, found in of_scenes.items()
            for k, quantity in enumerate(found)]
