# SPDX-License-Identifier: BSD-3-Clause
"""Soil that is thrown at a wall across a closed box: the runs of the sweep that have contact."""

import json
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.stats import qmc

H, SIDE = 0.01, 0.1  # [m] of a cell, of the block of soil
FACE = 0.15  # [m] x of the wall's face towards the soil
GAP = 0.1 * H  # between soil and wall at the start
FORMS = {"gimp": "quad4", "bspline": "quad4", "linear": "quad4", "triangles": "tri3"}  # and their cells
POINTS = {"quad4": (1, 4, 9, 16), "tri3": (1, 3, 6, 16)}
STEPS, SECONDS = 300, 0.25  # of a run at most
SEED = 20


@dataclass(frozen=True)
class Throw:
    """One run. density, young, thickness are the wall's; without density it is rigid, and the soil alone."""

    form: str = "gimp"
    density: float | None = 1100  #: [kg/m^3]
    young: float = 1e6  #: [Pa]
    thickness: float = H  #: [m]
    friction: float = 0.36
    dt: float = 5e-4  #: [s]
    penalty: float = 10  #: penalty_factor
    points: int = 1  #: index into POINTS
    shift: float = 0  #: of the grid to the lower left, by H
    speed: float = 2  #: [m/s]

    @property
    def end(self) -> float:
        """Time in which the block would go its own length, in 8 to STEPS steps [s]."""
        return float(np.clip(min(SIDE / self.speed, SECONDS), 8 * self.dt, STEPS * self.dt))


SOIL = {"law": "mohr_coulomb", "density": 2650, "young_modulus": 840e3, "poisson_ratio": 0.3,
        "friction_angle": 19.8}

# Values to which each factor alone is varied; the sample takes the same ranges.
LEVELS = {
    "density": (11, 110, 11000), "young": (1e4, 1e5, 1e7, 1e8, 1e9), "thickness": (1e-3, 2.5e-3, 5e-3, 2e-2),
    "friction": (0, 0.1, 1), "dt": (5e-5, 2e-4, 2e-3, 5e-3), "penalty": (0.1, 1, 100, 1000), "points": (0, 2, 3),
    "shift": (0.1, 0.25, 0.5, 0.75, 0.9), "speed": (0.1, 0.5, 6, 20),
}
LINEAR = ("friction", "shift")  # sampled evenly; points by their index, all others by their logarithm
PAIRS = (("density", "young"), ("speed", "dt"), ("thickness", "speed"), ("penalty", "dt"))
OF_ELASTIC = ("density", "young")  # what a rigid wall does not have


def one_at_a_time(base: Throw) -> dict[str, Throw]:
    factors = [name for name in LEVELS if base.density is not None or name not in OF_ELASTIC]
    return {f"{name}_{value:g}": replace(base, **{name: value}) for name in factors for value in LEVELS[name]}


def corners(base: Throw) -> dict[str, Throw]:
    """Throws with both ends of each pair of factors that depend on each other."""
    pairs = [pair for pair in PAIRS if base.density is not None or pair != OF_ELASTIC]
    return {f"{a}_{x:g}_{b}_{y:g}": replace(base, **{a: x, b: y}) for a, b in pairs
            for x in (LEVELS[a][0], LEVELS[a][-1]) for y in (LEVELS[b][0], LEVELS[b][-1])}


def value_of(name: str, share: float) -> float:
    """Value of a factor for a share in [0, 1) of its range."""
    low, high = LEVELS[name][0], LEVELS[name][-1]
    if name == "points":
        return int(4 * share)
    if name in LINEAR:
        return round(low + share * (high - low), 3)
    return float(f"{low * (high / low) ** share:.3g}")


def sample(base: Throw, count: int, seed: int) -> dict[str, Throw]:
    """Latin hypercube of all factors."""
    names = [name for name in LEVELS if base.density is not None or name not in OF_ELASTIC]
    shares = qmc.LatinHypercube(len(names), seed=seed).random(count)
    return {f"sample_{k}": replace(base, **{name: value_of(name, s) for name, s in zip(names, row)})
            for k, row in enumerate(shares)}


def throws(count: int) -> dict[str, dict[str, Throw]]:
    """Family -> name -> run; count: runs of each sample, one a form, half as many at the rigid wall."""
    result = {}
    for wall, density in (("elastic", Throw.density), ("rigid", None)):
        forms = [Throw(form=form, density=density) for form in FORMS]
        bases = {f"base_{base.form}": base for base in forms}
        result[f"{wall} wall, one factor"] = {**bases, **one_at_a_time(forms[0])}
        for base in (forms[0], forms[-1])[: 1 if density is None else 2]:
            result[f"{wall} wall, pairs, {base.form}"] = corners(base)
        for k, base in enumerate(forms):
            share = count if density is not None else count // 2
            result[f"{wall} wall, sample, {base.form}"] = sample(base, share, SEED + k)
    return result


def described(throw: Throw) -> str:
    """Factors that differ from the base, as text."""
    base = Throw(form=throw.form, density=None if throw.density is None else Throw.density)
    changed = {field.name: getattr(throw, field.name) for field in fields(Throw)
               if getattr(throw, field.name) != getattr(base, field.name)}
    if "points" in changed:
        changed["points"] = POINTS[FORMS[throw.form]][throw.points]
    return ", ".join(f"{name} {value:g}" for name, value in changed.items())


def box(low: tuple, high: tuple, cells: tuple, cell: str) -> dict:
    return {"box": {"low": low, "high": high, "cells": cells, "type": cell}}


def settings_of(throw: Throw) -> list[str]:
    """Everything that counts; the scene gives the frame only."""
    cell = FORMS[throw.form]
    low = -throw.shift * H
    # The wall ends beyond the grid: nothing gets round it.
    wall = box((FACE, -H), (FACE + throw.thickness, 0.16 + H), (2, 36), "quad4")
    left = FACE - GAP - SIDE
    time = {"end": throw.end, "dt": throw.dt, "dt_min": throw.dt / 256}
    surface = {"name": "wall", "surface": {"mesh": wall, "groups": ["left", "right"]}, "friction": throw.friction,
               "penalty_factor": throw.penalty}
    mpm = {
        "grid": box((low, low), (0.24 + low, 0.16 + low), (24, 16), cell),
        "basis": throw.form if cell == "quad4" else "linear",
        "locking": {}, "gravity": [0, -9.81],
        "walls": [{"group": side, "condition": "slip"} for side in ("left", "right", "bottom", "top")],
        "bodies": [{"name": "soil", "mesh": box((left, 0.02), (left + SIDE, 0.02 + SIDE), (10, 10), cell),
                    "points_per_cell": POINTS[cell][throw.points], "velocity": [throw.speed, 0], "material": SOIL}],
    }
    if throw.density is None:
        return _set("mpm", {**mpm, "rigid_walls": [surface], "time": time, "output": {"interval": throw.end}})
    fem = {
        "mesh": wall, "gravity": [0, 0], "initial_equilibrium": False, "time_integration": {},
        "material": {"law": "neo_hookean", "density": throw.density, "young_modulus": throw.young,
                     "poisson_ratio": 0.3},
        "supports": [{"group": "bottom"}, {"group": "top"}], "probes": [],
        "interfaces": [{"name": "wall", "groups": ["left", "right"]}],
    }
    limits = {"displacement": {"relative": 1e-5, "floor": 1e-9}, "force": {"relative": 1e-4, "floor": 1e-3}}
    coupler = {"time": time, "output": {"interval": throw.end},
               "coupling": {"convergence": limits, "mapping": {"tolerance": 1e-6}}}
    return [*_set("mpm", {**mpm, "interfaces": [surface]}), *_set("fem", fem), *_set("coupler", coupler)]


def _set(file: str, values: dict) -> list[str]:
    return [f"{file}.json:/{key}={json.dumps(value)}" for key, value in values.items()]
