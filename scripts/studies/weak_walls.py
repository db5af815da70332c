# SPDX-License-Identifier: BSD-3-Clause
"""Soil thrown at walls that yield, crack and lose cells: end, iterations and energy of each run."""

import json
from dataclasses import dataclass, replace

import numpy as np

from plotting.results import Results, ResultsError
from studies.outcome import GRAVITY, MAX_GAIN, column, largest_rise, total_energy, verdict
from studies.runner import Attempt, Runner, folder_of
from studies.throw import FACE, H, Throw, settings_of

SCENE = "granular_obstacle"
TOP = 0.16 + H  # [m] y of the wall's upper end
BASE = Throw(thickness=2 * H)
STEPS = (5e-5, 2e-4, 5e-4, 2e-3, 5e-3)  # [s]
USED = ("plastic_work", "damage_work", "failed_energy")  # beside kinetic and elastic energy


def metal(yield_stress: float = 1e6, **more) -> dict:
    return {"law": "von_mises", "density": 1100, "young_modulus": 1e8, "poisson_ratio": 0.3,
            "yield_stress": yield_stress, "hardening_modulus": 1e6, "formulation": "enhanced", **more}


def concrete(fracture_energy: float) -> dict:
    """A cell leaves where its crack is so wide that it carries nothing to speak of."""
    strength = 1e6
    return {"law": "concrete", "density": 2400, "young_modulus": 1e9, "poisson_ratio": 0.2,
            "tensile_strength": strength, "fracture_energy": fracture_energy, "compressive_strength": 10 * strength,
            "crushing_energy": 1e4, "failure_crack_width": 5 * fracture_energy / strength}


@dataclass(frozen=True)
class Wall:
    """material: of its cells; prestress: along it, tension positive [Pa]."""

    material: dict
    prestress: float = 0


FAMILIES = {
    "yield stress": {f"{s:g}": Wall(metal(s)) for s in (1e5, 1e6, 1e7)},
    "cells that fail": {f"{p:g}": Wall(metal(3e5, failure_plastic_strain=p)) for p in (0.01, 0.1, 0.5)},
    "fracture energy": {f"{g:g}": Wall(concrete(g)) for g in (3, 30, 300)},
    "prestress": {f"{p:g}": Wall(metal(), p) for p in (-5e5, 1e5, 9e5)},
}


def settings(wall: Wall, dt: float) -> list[str]:
    nodes = np.linspace(FACE, FACE + BASE.thickness, 3)
    fem = {
        "material": wall.material, "initial_equilibrium": True,
        "supports": [{"group": "bottom"}, {"group": "top", "components": ["x"]}],
        "tractions": [{"group": "top", "traction": [0, wall.prestress]}],
        "probes": [{"name": f"top_{k}", "point": [x, TOP]} for k, x in enumerate(nodes)],
    }
    return [*settings_of(replace(BASE, dt=dt)), *(f"fem.json:/{key}={json.dumps(value)}" for key, value in fem.items())]


def runs() -> list[tuple[str, str, Wall, float]]:
    """Family, name, wall and step of each."""
    return [(family, f"{name}_dt_{dt:g}", wall, dt)
            for family, walls in FAMILIES.items() for name, wall in walls.items() for dt in STEPS]


def work_of_prestress(results: Results, wall: Wall) -> np.ndarray:
    """On the upper end, whose nodes move linearly between each other [J/m]."""
    table = results.table("probes.csv")
    ends = [table[f"structure.top_{k}.uy"] for k in range(3)]
    mean = (ends[0] + 2 * ends[1] + ends[2]) / 4
    return wall.prestress * BASE.thickness * (mean - mean[0])


@dataclass
class Outcome:
    """Numbers of a run that left nothing are 0."""

    ended: str  #: "end", or when and why it stopped
    named: bool  #: it came to its end, or has a reason
    steps: int = 0
    cuts: int = 0
    mean: float = 0  #: coupling iterations
    most: int = 0
    gained: float = 0  #: largest rise of the energy of soil and wall, over what there was
    made: float = 0  #: the same of what the wall has and used beyond the work on it
    plastic: float = 0  #: largest strain
    failed: int = 0  #: cells

    @property
    def faults(self) -> list[str]:
        found = [] if self.ended == "end" else [self.ended]
        found += [f"energy + {100 * self.gained:.2g} %"] * (self.gained > MAX_GAIN)
        return found + [f"made by the wall {100 * self.made:.2g} %"] * (self.made > MAX_GAIN)


def outcome(attempt: Attempt, wall: Wall) -> Outcome:
    if attempt.results is None:
        return Outcome("no end" if attempt.code is None else f"exit code {attempt.code}, nothing written", False)
    results, summary = attempt.results, attempt.results.summary
    try:
        ended, named = verdict(summary), attempt.code in (0, 3)
    except ResultsError as error:
        ended, named = str(error), False
    table = results.table("probes.csv")
    mass = column(results, "mass")[0]
    energy = 0.5 * mass * BASE.speed**2 + np.max(np.abs(column(results, "gravity_work")))
    energy += mass * GRAVITY * H  # a run that stops at once has fallen nowhere
    names = ["kinetic_energy", "elastic_energy", *USED]
    held = sum(table[f"structure.{name}"] for name in names if f"structure.{name}" in table)
    rise = largest_rise(total_energy(results) - work_of_prestress(results, wall))
    iterations = summary.get("coupling_iterations", {})
    strain, failed = (np.max(table[name]) if name in table else 0
                      for name in ("structure.plastic_strain", "structure.failed_cells"))
    return Outcome(
        ended, named, summary["steps"], summary["cuts"], iterations.get("mean", 0), iterations.get("max", 0),
        rise / energy, largest_rise(held - table["structure.external_work"]) / energy, float(strain), int(failed))


HEAD = ["family", "runs", "to the end", "without reason", "cut steps", "mean iterations", "most iterations",
        "energy gained [%]", "made by the wall [%]", "largest plastic strain", "failed cells"]


def family_row(family: str, outcomes: list[Outcome]) -> list:
    def largest(name: str) -> float:
        return float(max(getattr(one, name) for one in outcomes))

    return [family, len(outcomes), sum(one.ended == "end" for one in outcomes),
            sum(not one.named for one in outcomes), sum(one.cuts for one in outcomes),
            float(np.mean([one.mean for one in outcomes])), int(largest("most")), 100 * largest("gained"),
            100 * largest("made"), largest("plastic"), sum(one.failed for one in outcomes)]


def weak_walls(runner: Runner) -> None:
    """Walls that yield, crack and lose cells under thrown soil: each run ends and says why, and makes no energy."""
    everything = runs()
    attempts = runner.attempts([(folder_of(f"{family}_{name}"), SCENE, settings(wall, dt))
                                for family, name, wall, dt in everything])
    rows, faulty = {}, []
    for attempt, (family, name, wall, _) in zip(attempts, everything):
        one = outcome(attempt, wall)
        rows.setdefault(family, []).append(one)
        if one.faults:
            faulty.append([family, name, "; ".join(one.faults)])
    runner.report(HEAD, [family_row(family, listed) for family, listed in rows.items()])
    ended = sum(one.ended == "end" for listed in rows.values() for one in listed)
    runner.remark(f"{ended} of {len(everything)} runs came to their end")
    runner.remark("gained: largest rise of kinetic, elastic, contact's and gravity's energy together, less the work of "
                  f"the prestress, over the energy of throw and fall, limit {100 * MAX_GAIN:g} %; made by the wall: "
                  "the same of all energy that the wall has and used beyond the work on it")
    if faulty:
        runner.report(["family", "case", "what"], faulty, "not to the end, or beyond a limit")


STUDIES = {weak_walls.__name__: weak_walls}
