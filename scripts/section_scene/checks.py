# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of values in the plan of a section that are allowed but hardly meant: units and sizes."""

import numpy as np

from .columns import Mass
from .plan import Plan

# Key of a material: below and above which its value looks like another unit, and which.
SOILS = {"density": (500, 5000, "kg/m^3; 1.8 would be t/m^3, 18 kN/m^3"),
         "young_modulus": (1e4, 1e12, "Pa; 20 would be MPa"),
         "friction_angle": (2, 60, "degrees; 0.6 would be radians"),
         "cohesion": (100, 1e7, "Pa; 5 would be kPa")}
STEEP = np.tan(np.radians(60))


def of_material(where: str, material: dict) -> list[str]:
    lines = []
    for key, (low, high, unit) in SOILS.items():
        value = material.get(key, 0)
        if isinstance(value, (int, float)) and value and not low <= value <= high:
            lines.append(f"warning: {where}/material/{key}: found {value:g}, taken as {unit}; plausible: {low:g} to "
                         f"{high:g}")
    return lines


def of_sizes(plan: Plan) -> list[str]:
    lines = []
    left, right = plan.ends()
    if right - left > 2e4:
        lines.append(f"warning: ground: {right - left:g} m long; lengths are metres, not millimetres")
    steep = float(np.abs(plan.ground.slopes()).max())
    if steep > STEEP:
        lines.append(f"warning: ground: falls by {np.degrees(np.arctan(steep)):.0f} degrees at most, plausible: up to "
                     "60")
    if plan.friction > 1.5:
        lines.append(f"warning: friction: found {plan.friction:g}, a coefficient, the tangent of an angle; plausible: "
                     "up to 1.5")
    if plan.wall is not None and plan.wall.height > 50:
        lines.append(f"warning: wall/height: found {plan.wall.height:g} m, plausible: up to 50")
    return lines


def warnings_of(plan: Plan, masses: list[Mass]) -> list[str]:
    lines = of_sizes(plan)
    for k, layer in enumerate(plan.layers):
        lines += of_material(f"layers/{k}", layer.material)
    if plan.slide is not None:
        lines += of_material("slide", plan.slide.material)
    for mass in masses:
        cells = mass.deepest / plan.cell_size
        if cells < 2:
            lines.append(f"warning: {mass.name} is {cells:.2g} cells deep at most: soil shears within itself from two "
                         "cells on")
    return lines
