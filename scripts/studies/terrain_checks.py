# SPDX-License-Identifier: BSD-3-Clause
"""The slide on terrain: columns on their fall lines, momentum, mass through the gauges, reaction of the wall."""

import numpy as np

from studies.balances import Row, force_on_wall, impulse, ledger_rows, mean_acceleration, soil, times
from studies.closed_forms import fall_line_acceleration
from studies.measures import Curve, Measured
from studies.runner import ROOT
from terrain_scene.plan import GRAVITY, read_plan
from terrain_scene.scene import sample_slope

SCENE = "slide_on_terrain"
FIRST, LAST = 1.0, 1.2  # [s] that the acceleration and the end are the mean of
GAUGES = ("gully", "toe")
# Head of a column, column of the gauge, its unit.
LARGEST = (("depth [m]", "depth", 1), ("mean speed [m/s]", "normal_speed", 1), ("flux [t/s]", "section_flux", 1e3),
           ("dynamic pressure [kPa]", "dynamic_pressure", 1e3), ("passed [t]", "passed_mass", 1e3))


def acceleration_row(run: Measured) -> Row:
    """Along x; the columns of the mass where they lie at the start."""
    plan = read_plan(ROOT / "configs" / SCENE / "plan.json")
    slope = sample_slope(plan)[1]
    frame = run.results.frames_of_soil().frame(0)
    x, y = frame.points[:, 0], frame.points[:, 1]
    half = 0.5 * slope.spacing
    # The column of a point is a cell of the lattice.
    x, y = (slope.spacing * (np.floor(place / slope.spacing) + 0.5) for place in (x, y))
    gradient = np.column_stack([slope.at(x + half, y) - slope.at(x - half, y),
                                slope.at(x, y + half) - slope.at(x, y - half)]) / slope.spacing
    each = fall_line_acceleration(gradient, GRAVITY, plan.friction)[:, 0]
    last = int(np.argmin(np.abs(times(run) - FIRST)))
    return ["acceleration along x in the first second [m/s²]: columns, each down its fall line",
            float(np.average(each, weights=frame.fields["volume"].ravel())), mean_acceleration(run, last)]


def momentum_row(run: Measured) -> Row:
    momentum = soil(run, "momentum_x") + soil(run, "removed_momentum_x")
    force = force_on_wall(run, "terrain") + run.force().values
    return [f"momentum along x and impulse of slope and barrier, {1e-6 * momentum.max():.4g} MN s at most [N s]", 0,
            float(momentum[-1]) + impulse(force, run, 0, len(force))]


def gauge_row(run: Measured, gauge: str) -> Row:
    """Depth-averaged flux, summed over the steps, beside points that crossed."""
    flux = soil(run, f"{gauge}.section_flux")
    counted = impulse(0.5 * (flux[1:] + flux[:-1]), run, 0, len(flux) - 1)
    return [f"mass that passed `{gauge}` [t]: sum of its sections' flux, points that crossed it", 1e-3 * counted,
            1e-3 * float(soil(run, f"{gauge}.passed_mass")[-1])]


def largest_row(run: Measured, gauge: str) -> list:
    """Largest values of a gauge with their times."""
    row: list = [f"`{gauge}`"]
    for _, column, unit in LARGEST:
        values = soil(run, f"{gauge}.{column}")
        at = int(np.argmax(values))
        row.append(float(values[at]) / unit)
        if column != "passed_mass":
            row.append(float(times(run)[at]))
    return row


def gauge_head() -> list[str]:
    head = ["gauge"]
    for name, column, _ in LARGEST:
        head += [name] if column == "passed_mass" else [name, "at [s]"]
    return head


def reaction_row(run: Measured) -> Row:
    """Mean over the end; the momentum of the wall takes the rest."""
    table = run.table("probes.csv")
    momentum = Curve(times(run), table["structure.momentum_x"])
    end = float(momentum.time[-1])
    taken = float(momentum.at(end) - momentum.at(end - LAST)) / LAST
    return ["reaction of the foot along x at the end [MN]: force of the soil and momentum of the wall",
            1e-6 * (run.force().mean_of_last(LAST) - taken),
            -1e-6 * Curve(times(run), table["structure.reaction_foot_x"]).mean_of_last(LAST)]


def terrain_rows(run: Measured) -> list[Row]:
    return [acceleration_row(run), momentum_row(run), *(gauge_row(run, gauge) for gauge in GAUGES),
            reaction_row(run), *ledger_rows(run, 1e6, "MJ")]
