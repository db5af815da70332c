# SPDX-License-Identifier: BSD-3-Clause
"""Soil that got past a surface: over, under or around it, by the frames."""

from dataclasses import dataclass

import numpy as np

from plotting.deposit import volumes_of
from plotting.results import Frame, Results, Series
from plotting.view import up_axis

from .incoming import push_of
from .surfaces import all_loads, loaded_surfaces


@dataclass(frozen=True)
class Past:
    """Volume at rest of soil beyond a surface at the time of each frame [m^3], 2D [m^2], more than at the first one.

    direction: horizontal, in which the soil pushed; behind: the part of the volume within the width of the surface
    across that, 3D only; whole: all soil of the first frame.
    """

    surface: str
    direction: np.ndarray
    times: np.ndarray
    volume: np.ndarray
    behind: np.ndarray | None
    whole: float


def volume_past(frame: Frame, soil: Series, surface: Frame, direction: np.ndarray,
                across: np.ndarray | None) -> tuple[float, float]:
    """Volume beyond the last node of a surface along a direction, and the part of it within its width."""
    if not len(frame.points):
        return 0.0, 0.0
    dim = len(direction)
    volume = volumes_of(frame, soil)[0]
    nodes, points = surface.points[np.unique(surface.cells)][:, :dim], frame.points[:, :dim]
    beyond = points @ direction > (nodes @ direction).max()
    if across is None:
        return float(volume[beyond].sum()), 0.0
    span = nodes @ across
    within = beyond & (points @ across >= span.min()) & (points @ across <= span.max())
    return float(volume[beyond].sum()), float(volume[within].sum())


def soil_past(results: Results) -> list[Past]:
    """Soil past each surface that was pushed horizontally. @raises ResultsError  frames that cannot be read"""
    soil, surfaces = results.soil, loaded_surfaces(results)
    if soil is None:
        return []
    pushed = {loads.name: push_of(loads, results.gravity) for loads in all_loads(results) if loads.name in surfaces}
    pushed = {name: direction for name, direction in pushed.items() if direction is not None}
    up = np.eye(3)[up_axis(results.dim, results.gravity)]
    across = {name: np.cross(up, direction) if results.dim == 3 else None for name, direction in pushed.items()}
    volumes: dict[str, list[tuple[float, float]]] = {name: [] for name in pushed}
    whole = 0.0
    for k in range(len(soil) if pushed else 0):
        frame = soil.frame(k)
        if k == 0:
            whole = float(volumes_of(frame, soil)[0].sum()) if len(frame.points) else 0.0
        for name, direction in pushed.items():
            surface = surfaces[name].frame(surfaces[name].nearest(frame.time))
            volumes[name].append(volume_past(frame, soil, surface, direction, across[name]))
    found = []
    for name, each in volumes.items():
        values = np.array(each) - each[0]
        behind = None if across[name] is None else values[:, 1]
        found.append(Past(name, pushed[name], soil.times, values[:, 0], behind, whole))
    return found if whole > 0 else []
