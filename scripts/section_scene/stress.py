# SPDX-License-Identifier: BSD-3-Clause
"""Stress of level layers at the start of a section, and where water stands in them."""

import numpy as np
from sampling.reader import is_number
from scipy.special import lambertw
from terrain_scene.plan import GRAVITY
from terrain_scene.raster import TerrainError

from .columns import bounds_in, column_sides
from .plan import Layer, Plan

WATER_DENSITY = 1000.0  # [kg/m^3], that of the soil's `water` too


def table_below_ground(plan: Plan, origin: float) -> None:
    """origin: height that was subtracted from the heights [m]. @raises TerrainError  water stands above the ground or
    needs a porosity"""
    if plan.table is None:
        return
    lowest = float(plan.ground.z.min())
    if plan.table > lowest:
        raise TerrainError(f"water/table: found {plan.table + origin:.9g}, above the ground, whose lowest point is at "
                           f"{lowest + origin:.9g} m, allowed: at most that; a pool on the ground is not simulated")
    for k, layer in enumerate(plan.layers):
        if layer.porosity is None and layer.bottom.z.min() < plan.table:
            raise TerrainError(f"layers/{k}/porosity: found nothing, allowed: a number > 0 and < 1 for {layer.name}, "
                               "which lies below the water table; its density is then that of the saturated soil")
        if layer.porosity is not None and layer.porosity >= 1:
            raise TerrainError(f"layers/{k}/porosity: found {layer.porosity:g}, allowed: a number > 0 and < 1")


def level_heights(plan: Plan) -> list[float] | None:
    """Heights of the tops of the layers; None: one is not level where the layer is, or does not lie below the one
    before it."""
    zero = 1e-9 * plan.cell_size
    bounds = bounds_in(plan, column_sides(plan))
    heights = []
    for above, below in zip(bounds[:-1], bounds[1:]):
        within = above[(above - below).max(axis=1) > zero]
        if not len(within) or np.ptp(within) > zero:
            return None
        heights.append(float(within.flat[0]))
    return heights if heights and all(np.diff(heights) < 0) else None


def has_water(plan: Plan, layer: Layer) -> bool:
    """Whether the water table lies in the layer or above it."""
    return layer.porosity is not None and plan.table is not None and float(layer.bottom.z.min()) < plan.table


def density_above(plan: Plan, layer: Layer) -> float:
    """Density of the layer above the water table, without the water in its pores [kg/m^3]."""
    return layer.material["density"] - (layer.porosity * WATER_DENSITY if has_water(plan, layer) else 0.0)


def density_below(plan: Plan, layer: Layer) -> float:
    """Density of the layer below the water table, less that of the water, of which the skeleton bears nothing."""
    return layer.material["density"] - (WATER_DENSITY if has_water(plan, layer) else 0.0)


def weight(plan: Plan, layer: Layer, low: float, high: float) -> float:
    """Mass that the skeleton bears of the layer between two heights [kg/m^2]."""
    wet = min(max(plan.table, low), high) if has_water(plan, layer) else low
    return density_below(plan, layer) * (wet - low) + density_above(plan, layer) * (high - wet)


def softness(layer: Layer) -> float:
    """c of a load s + c s^2 under which the skeleton has the vertical Kirchhoff stress s and the Cauchy stress
    s exp(2 c s): it is compressed under its own weight [1/Pa]. 0 of laws of small strain and of those without these
    constants, or where one of them varies or is wrong: mpm_solver then judges the material and the stress."""
    material, k0 = layer.material, layer.k0
    modulus, ratio, angle = (material.get(key) for key in ("young_modulus", "poisson_ratio", "friction_angle"))
    constants = [modulus, ratio] + ([angle] if k0 == "jaky" else [])
    if material["law"] == "linear_elastic" or not all(is_number(each) for each in constants) or not modulus > 0:
        return 0.0
    if k0 == "jaky":
        k0 = 1 - np.sin(np.radians(angle))
    elif k0 == "elastic":
        k0 = ratio / (1 - ratio)
    return (1 - 2 * ratio) * (1 + 2 * k0) / (2 * modulus)


def stress_under(load: float, c: float) -> float:
    """Vertical Cauchy stress of the skeleton under a load [Pa]; c: its softness()."""
    s = 2 * load / (1 + np.sqrt(1 + 4 * c * load))
    return s * np.exp(2 * c * s)


def load_with(stress: float, c: float) -> float:
    """The load under which the skeleton has that stress [Pa]."""
    s = stress if c == 0 else float(lambertw(2 * c * stress).real) / (2 * c)
    return s + c * s**2


def load_on(plan: Plan, layers: list[Layer], heights: list[float], below: Layer) -> float:
    """Mass [kg/m^2] that lies on a layer if it shall have the stress that the layers on it end with."""
    load = 0.0
    for k, layer in enumerate(layers):
        load = GRAVITY * (load + weight(plan, layer, heights[k + 1], heights[k]))
        next_one = layers[k + 1] if k + 1 < len(layers) else below
        load = load_with(stress_under(load, softness(layer)), softness(next_one)) / GRAVITY
    return load


def initial_stress(plan: Plan, layer: Layer, heights: list[float]) -> dict:
    """Settings of a body of level layers: up to `surface` its own density weighs as much as what lies on it.

    heights: of the tops of the layers [m]. @raises TerrainError  it would lie below the water table
    """
    above = plan.layers[:next(k for k, each in enumerate(plan.layers) if each is layer)]
    top = heights[len(above)]
    load = load_on(plan, above, heights, layer)
    wet = has_water(plan, layer)
    below = min(max(plan.table, top) - top, load / density_below(plan, layer)) if wet else 0.0
    rest = load - below * density_below(plan, layer)
    surface = top + below + rest / density_above(plan, layer)
    stress = {"k0": layer.k0, "surface": surface}
    if not wet:
        return {"initial_stress": stress}
    if surface < plan.table:
        raise TerrainError(f"layers: found {layer.name} under lighter soil whose weight its own density would have up "
                           f"to {plan.table - surface:.3g} m below the water table, allowed: a lower table, or layers "
                           "of like density")
    return {"water": {"porosity": layer.porosity}, "initial_stress": stress | {"water_table": plan.table}}
