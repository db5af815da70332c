# SPDX-License-Identifier: BSD-3-Clause
"""The flexible gate against a beam in large deflection and the earth pressure at rest."""

from dataclasses import dataclass

import numpy as np

from plotting.results import Series
from studies.balances import Row, ledger_rows
from studies.closed_forms import (
    bent_axis, cross, earth_pressure_at_rest, earth_pressure_at_soft_contact, plane_strain_stiffness,
)
from studies.measures import Measured

SCENE = "flexible_gate"
RIGID = "fem.json:/material/young_modulus=1e12"
LAID = [RIGID, 'mpm.json:/bodies/0/initial_stress={"k0": "elastic", "surface": 0.2}', "coupler.json:/time/end=0.2"]
RAMPED = [RIGID, 'mpm.json:/gravity_ramp={"duration": 0.4, "shape": "smooth"}', "coupler.json:/time/end=0.5"]
FINE = ["fem.json:/mesh/box/cells=[8, 176]"]
PENALTY_FACTOR = 10  # of `facets`, the default
PRESSED, LAYERS = 0.1, 1000  # [s] that the force is the mean of; of the sand
LAST = 0.16  # [s] that the end is the mean of


@dataclass
class Loaded:
    """A beam of rows of nodes across its axis, the first row clamped; means of some frames.

    stations: num_rows, along the straight axis [m]; axis: num_rows x 2, bent, relative to the clamp [m];
    forces: num_rows x 2 [N/m]; moments: num_rows, about the axis [N].
    """

    stations: np.ndarray
    axis: np.ndarray
    forces: np.ndarray
    moments: np.ndarray


def frames_since(series: Series, start: float) -> list[int]:
    return [k for k, time in enumerate(series.times) if time >= start - 1e-9]


def loaded_beam(series: Series, start: float) -> Loaded:
    """A beam along y that is clamped at its top, from the mean of the frames since `start` [s]."""
    frames = [series.frame(k) for k in frames_since(series, start)]
    points = np.mean([frame.points[:, :2] for frame in frames], axis=0)
    moved = np.mean([frame.fields["displacement"][:, :2] for frame in frames], axis=0)
    forces = np.mean([frame.fields["external_force"][:, :2] for frame in frames], axis=0)
    height, row = np.unique((points - moved)[:, 1].round(6), return_inverse=True)
    row = len(height) - 1 - row.ravel()  # from the clamp on

    def over_rows(values: np.ndarray) -> np.ndarray:
        return np.bincount(row, values, len(height))

    count = over_rows(np.ones(len(points)))
    axis = np.column_stack([over_rows(points[:, k]) / count for k in (0, 1)])
    sums = np.column_stack([over_rows(forces[:, k]) for k in (0, 1)])
    return Loaded(height[-1] - height[::-1], axis - axis[0], sums, over_rows(cross(points - axis[row], forces)))


def foot_rows(run: Measured) -> list[Row]:
    """The foot of the gate, on its axis, relative to where it is at the start."""
    settings = run.results.settings("fem.json")
    material, box = settings["material"], settings["mesh"]["box"]
    stiffness = plane_strain_stiffness(material["young_modulus"], material["poisson_ratio"],
                                       box["high"][0] - box["low"][0])
    beam = loaded_beam(run.results.structures[0], float(run.results.structures[0].times[-1]) - LAST)
    expected = bent_axis(beam.stations, beam.forces, beam.moments, stiffness, np.array([0.0, -1.0]))[-1]
    length = beam.stations[-1]
    cells = " x ".join(map(str, box["cells"]))
    found = beam.axis[-1]
    return [[f"foot at rest, out [mm], {cells} elements: beam", 1e3 * float(expected[0]), 1e3 * float(found[0])],
            [f"foot at rest, up [mm], {cells} elements: beam", 1e3 * float(length + expected[1]),
             1e3 * float(length + found[1])]]


def pressure_rows(laid: Measured, ramped: Measured) -> list[Row]:
    """Force on a gate that does not move: of sand with its stress from the start, and of sand that gets its weight."""
    settings = laid.results.settings("mpm.json")
    material, box = settings["bodies"][0]["material"], settings["bodies"][0]["mesh"]["box"]
    young, poisson = material["young_modulus"], material["poisson_ratio"]
    width, height = np.subtract(box["high"], box["low"])
    rest = earth_pressure_at_rest(material["density"], -settings["gravity"][1], height, poisson)
    wave = young * (1 - poisson) / (1 + poisson) / (1 - 2 * poisson)
    grid = settings["grid"]["box"]
    cell = (grid["high"][0] - grid["low"][0]) / grid["cells"][0]
    depths = (np.arange(LAYERS) + 0.5) / LAYERS
    soft = earth_pressure_at_soft_contact(2 * rest / height * depths, young, poisson, width,
                                          np.sqrt(PENALTY_FACTOR * wave) / cell)
    return [["force on a rigid gate, `initial_stress` in the sand [N]: earth pressure at rest", rest,
             laid.force().mean_of_last(PRESSED)],
            ["the same, sand free of stress, gravity grows gradually: that, minus the pressure lost as the contact "
             "yields",
             float(height * np.mean(soft)), ramped.force().mean_of_last(PRESSED)]]


def gate_rows(run: Measured, fine: Measured, laid: Measured, ramped: Measured) -> list[Row]:
    return [*foot_rows(run), *foot_rows(fine), *pressure_rows(laid, ramped), *ledger_rows(run, 1, "J")]
