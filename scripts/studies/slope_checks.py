# SPDX-License-Identifier: BSD-3-Clause
"""The slide over a barrier: sliding block, momentum, force at the end, crest by Euler and Bernoulli."""

import numpy as np

from plotting.contact import contact_series
from plotting.faces import facet_vectors
from plotting.results import Frame
from studies.balances import (
    Row, acceleration_by_force, arrival, force_on_wall, impulse, last_kept, ledger_rows, mean_acceleration, soil,
    times,
)
from studies.closed_forms import block_acceleration, cantilever_tip, plane_strain_stiffness
from studies.gate_checks import frames_since
from studies.measures import Curve, Measured

SCENE = "slope_barrier"
LAST = 1.0  # [s] that the end is the mean of


def sliding_rows(run: Measured, wall: str, friction: float) -> list[Row]:
    """Acceleration until soil arrives at a structure, on a plane along x."""
    gravity = run.results.settings("mpm.json")["gravity"]
    last = arrival(run)
    found = mean_acceleration(run, last)
    weight = -gravity[-1] * soil(run, "mass")[0] * times(run)[last]
    normal = "xyz"[len(gravity) - 1]
    borne = -impulse(force_on_wall(run, wall, normal), run, 0, last)
    shear = impulse(force_on_wall(run, wall), run, 0, last)
    fallen = float(soil(run, f"momentum_{normal}")[last])
    return [["acceleration until the soil arrives [m/s²]: rigid block",
             block_acceleration(gravity[0], -gravity[-1], friction), found],
            ["the same: from gravity and the force of the bed",
             acceleration_by_force(run, wall, gravity[0], last), found],
            ["normal force of the bed until then, over the weight: from the momentum of the soil that comes down",
             float(1 + fallen / weight), float(borne / weight)],
            ["tangential over normal force of the bed until then: friction", friction, float(shear / borne)]]


def momentum_row(run: Measured) -> Row:
    """Balance of momentum from the arrival until soil leaves the grid."""
    start, last = arrival(run), last_kept(run)
    time, momentum = times(run), soil(run, "momentum_x")
    weight = run.results.settings("mpm.json")["gravity"][0] * soil(run, "mass")[0]
    expected = (momentum[start] + weight * (time[last] - time[start])
                - impulse(force_on_wall(run, "bed") + run.force().values, run, start, last))
    return [f"momentum at {time[last]:.4g} s [kN s]: that at {time[start]:.4g} s, gravity, bed, barrier",
            1e-3 * float(expected), 1e-3 * float(momentum[last])]


def mass_before(frame: Frame, face: float, density: float) -> float:
    """Mass of the soil with x < face [kg]."""
    mass = density * frame.fields["volume"].ravel() / frame.fields["volume_ratio"].ravel()
    return float(np.sum(mass[frame.points[:, 0] < face]))


def facet_forces(frame: Frame) -> np.ndarray:
    """Force of the soil on each facet in the plane [N/m], num_facets x 2; soil is to the right of a line."""
    way = facet_vectors(frame.points[:, :2], frame.cells)
    length = np.linalg.norm(way, axis=1)
    into = np.column_stack([-way[:, 1], way[:, 0]])
    return frame.fields["pressure"].reshape(-1, 1) * into + frame.fields["shear"][:, :2] * length[:, None]


def force_rows(run: Measured) -> list[Row]:
    """Forces on the barrier at the end."""
    settings = run.results.settings("mpm.json")
    gravity, density = settings["gravity"], settings["bodies"][0]["material"]["density"]
    face = run.results.settings("fem.json")["mesh"]["box"]["low"][0]
    series = run.results.frames_of_soil()
    frames = frames_since(series, float(series.times[-1]) - LAST)
    mass = float(np.mean([mass_before(series.frame(k), face, density) for k in frames]))
    low = block_acceleration(gravity[0], -gravity[1], settings["rigid_walls"][0]["friction"]) * mass
    bed = contact_series(run.results)["bed"]
    before = [sum_before(bed.frame(k), face) for k in frames]
    taken, pushed = np.mean(before, axis=0)
    found = 1e-3 * run.force().mean_of_last(LAST)
    return [[f"force at the end [kN]: {1e-3 * mass:.4g} t in front of the barrier, with and without the bed's friction",
             f"{1e-3 * low:.4g} to {1e-3 * gravity[0] * mass:.4g}", found],
            ["tangential over normal force of the bed there: at most friction",
             f"up to {settings['rigid_walls'][0]['friction']:g}", float(-taken / pushed)]]


def sum_before(frame: Frame, face: float) -> np.ndarray:
    """Force of the soil on a bed at x < face [N/m], 2."""
    middle = frame.points[frame.cells].mean(axis=1)[:, 0]
    return facet_forces(frame)[middle < face].sum(axis=0)


def crest_row(run: Measured) -> Row:
    """Crest of the barrier, computed from the forces on its facets, and found."""
    settings = run.results.settings("fem.json")
    box = settings["mesh"]["box"]
    low, high = np.array(box["low"]), np.array(box["high"])
    stiffness = plane_strain_stiffness(settings["material"]["young_modulus"], settings["material"]["poisson_ratio"],
                                       high[0] - low[0])
    series = contact_series(run.results)["barrier"]
    frames = frames_since(series, float(series.times[-1]) - LAST)
    tips = [tip_of(series.frame(k), low, high, stiffness) for k in frames]
    table = run.table("probes.csv")
    crest = Curve(table["time"], table["structure.crest.ux"] - table["structure.crest.ux"][0])
    return ["crest at the end [mm]: Euler and Bernoulli", 1e3 * float(np.mean(tips)),
            1e3 * float(np.mean(crest.at(series.times[frames])))]


def tip_of(frame: Frame, low: np.ndarray, high: np.ndarray, stiffness: float) -> float:
    """Deflection of the crest of an upright wall from low to high [m]; bent upright forces turn about its axis."""
    forces = facet_forces(frame)
    middle = frame.points[frame.cells].mean(axis=1)[:, :2]
    arm = middle[:, 0] - 0.5 * (low[0] + high[0])
    return cantilever_tip(middle[:, 1] - low[1], forces[:, 0], -arm * forces[:, 1], high[1] - low[1], stiffness)


def slope_rows(run: Measured) -> list[Row]:
    friction = run.results.settings("mpm.json")["rigid_walls"][0]["friction"]
    return [*sliding_rows(run, "bed", friction), momentum_row(run), *force_rows(run), crest_row(run),
            *ledger_rows(run, 1e3, "kJ")]
