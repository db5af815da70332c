# SPDX-License-Identifier: BSD-3-Clause
"""Stress of level layers at the start of a section, and where water stands in them."""

import numpy as np
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


def density_above(layer: Layer) -> float:
    """Density of the layer above water, without that in its pores [kg/m^3]."""
    return layer.material["density"] - (layer.porosity or 0.0) * WATER_DENSITY


def weight(layer: Layer, low: float, high: float, table: float | None) -> float:
    """Mass [kg/m^2] of the layer between two heights."""
    if layer.porosity is None or table is None:
        return layer.material["density"] * (high - low)
    wet = min(max(table, low), high)
    return layer.material["density"] * (wet - low) + density_above(layer) * (high - wet)


def initial_stress(plan: Plan, layer: Layer, heights: list[float]) -> dict:
    """Settings of a body of level layers: up to `surface` its own density weighs as much as what lies on it.

    heights: of the tops of the layers [m]. @raises TerrainError  it would lie below the water table
    """
    above = plan.layers[:next(k for k, each in enumerate(plan.layers) if each is layer)]
    top = heights[len(above)]
    load = sum(weight(each, heights[k + 1], heights[k], plan.table) for k, each in enumerate(above))
    wet = layer.porosity is not None and plan.table is not None
    below = min(max(plan.table, top) - top, load / layer.material["density"]) if wet else 0.0
    rest = load - below * layer.material["density"]
    surface = top + below + rest / (density_above(layer) if wet else layer.material["density"])
    stress = {"k0": layer.k0, "surface": surface}
    if not wet:
        return {"initial_stress": stress}
    if surface < plan.table:
        raise TerrainError(f"layers: found {layer.name} under lighter soil whose weight its own density would have up "
                           f"to {plan.table - surface:.3g} m below the water table, allowed: a lower table, or layers "
                           "of like density")
    return {"water": {"porosity": layer.porosity}, "initial_stress": stress | {"water_table": plan.table}}
