# SPDX-License-Identifier: BSD-3-Clause
"""The flow that comes towards a surface, by a gauge in front of it, and the impact coefficient with it."""

from dataclasses import dataclass

import numpy as np

from plotting.results import Frame, Results
from plotting.view import up_axis

from .surfaces import Loads, all_loads, loaded_surfaces


@dataclass(frozen=True)
class Gauge:
    """A gauge of mpm.json. normal: along which flow counts positive; across: horizontal unit vector in the gauge, in 3D
    only; span: of its corners along that [m]."""

    name: str
    middle: np.ndarray
    normal: np.ndarray
    across: np.ndarray | None
    span: tuple[float, float]


@dataclass(frozen=True)
class Flow:
    """Values of a gauge when rho v^2 h was largest [kg/m^3, m/s, m, s]. direction: unit vector of the flow."""

    gauge: Gauge
    time: float
    density: float
    speed: float
    depth: float
    direction: np.ndarray

    @property
    def thrust(self) -> float:
        """rho v^2 h [N/m]."""
        return self.density * self.speed**2 * self.depth


@dataclass(frozen=True)
class Impact:
    """alpha = F . n / (rho v^2 h b) over time; force: F . n [N], in 2D [N/m]; width: b, 1 in 2D [m]."""

    surface: str
    time: np.ndarray
    force: np.ndarray
    flow: Flow
    width: float

    @property
    def coefficient(self) -> np.ndarray:
        return self.force / (self.flow.thrust * self.width)


def gauges_of(results: Results) -> list[Gauge]:
    """Gauges in the order of the settings."""
    found = []
    for each in results.settings("mpm.json").get("gauges", []):
        corners = np.array(each["corners"], dtype=float)
        if corners.shape == (2, 2):
            x, y = corners[1] - corners[0]
            normal, across, span = np.array([y, -x]), None, (0.0, 0.0)
            middle = corners.mean(axis=0)
        else:
            foot, upward = corners[1] - corners[0], corners[2] - corners[0]
            normal = np.cross(foot, upward)
            across = np.cross(upward, normal)
            across /= np.linalg.norm(across)
            places = np.array([*corners, corners[1] + upward]) @ across
            span, middle = (float(places.min()), float(places.max())), corners[0] + (foot + upward) / 2
        found.append(Gauge(each["name"], middle, normal / np.linalg.norm(normal), across, span))
    return found


def flow_at(results: Results, gauge: Gauge) -> Flow | None:
    """The flow through a gauge at its strongest; None: no soil moved there, or the tables have no such gauge."""
    table = results.table("probes.csv")
    ends = ("section_flux", "normal_speed", "area", "depth")
    prefixes = [] if table is None else [name.removesuffix(".section_flux") for name in table.names
                                         if f".{name}".endswith(f".{gauge.name}.section_flux")]
    if len(prefixes) != 1 or not all(f"{prefixes[0]}.{end}" in table for end in ends):
        return None
    flux, speed, area, depth = (table[f"{prefixes[0]}.{end}"] for end in ends)
    moved = np.isfinite(flux * speed) & (area > 0) & (speed != 0)
    if not moved.any():
        return None
    density = np.where(moved, flux / np.where(moved, speed * area, 1), 0)
    k = int(np.argmax(np.where(moved, density * speed**2 * depth, -1)))
    return Flow(gauge, float(table["time"][k]), float(density[k]), float(abs(speed[k])), float(depth[k]),
                np.sign(speed[k]) * gauge.normal)


def width_of(frame: Frame, across: np.ndarray | None) -> tuple[float, float]:
    """Where a surface begins and ends across the flow [m]."""
    if across is None:
        return 0.0, 0.0
    places = frame.points[np.unique(frame.cells)] @ across
    return float(places.min()), float(places.max())


def impact_on(results: Results, loads: Loads, frame: Frame) -> Impact | str:
    """Impact coefficient of a surface, by the nearest gauge in front of it; a text: why there is none.

    frame: the surface before the impact.
    """
    nodes = frame.points[np.unique(frame.cells)][:, :results.dim]
    gauges = gauges_of(results)
    if not gauges:
        return "not given: no gauge measures the flow towards it; `gauges` of mpm.json in front of it do"
    found: list[tuple[float, Flow]] = []
    for gauge in gauges:
        flow = flow_at(results, gauge)
        if flow is None:
            continue
        ahead = float(((nodes - gauge.middle) @ flow.direction).min())
        low, high = width_of(frame, gauge.across)
        is_beside = gauge.across is not None and (high < gauge.span[0] or low > gauge.span[1])
        if ahead > 0 and not is_beside:
            found.append((ahead, flow))
    if not found:
        names = ", ".join(gauge.name for gauge in gauges)
        return f"not given: soil moved towards it through none of the gauges ({names})"
    flow = min(found, key=lambda each: each[0])[1]
    low, high = width_of(frame, flow.gauge.across)
    return Impact(loads.name, loads.time, loads.force @ flow.direction, flow,
                  high - low if flow.gauge.across is not None else 1.0)


def impacts(results: Results) -> list[tuple[str, Impact | str]]:
    """Name of each surface that soil pressed on -> its impact."""
    surfaces, found = loaded_surfaces(results), []
    for loads in all_loads(results):
        if loads.name in surfaces and np.any(loads.force != 0):
            found.append((loads.name, impact_on(results, loads, surfaces[loads.name].frame(0))))
    return found


def froude(flow: Flow, gravity: list[float] | None) -> float | None:
    """v over the root of g h; None without gravity."""
    size = float(np.linalg.norm(gravity)) if gravity else 0.0
    return flow.speed / np.sqrt(size * flow.depth) if size > 0 and flow.depth > 0 else None


def push_of(loads: Loads, gravity: list[float] | None) -> np.ndarray | None:
    """Horizontal direction in which the soil pushed a surface, that of the impulse; None: it did not."""
    level = np.arange(loads.force.shape[1]) != up_axis(loads.force.shape[1], gravity)
    impulse = np.nansum(loads.force * np.diff(loads.time, prepend=0.0)[:, None], axis=0) * level
    size = float(np.linalg.norm(impulse))
    return impulse / size if size > 0 else None
