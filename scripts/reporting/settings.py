# SPDX-License-Identifier: BSD-3-Clause
"""Settings of a run as its programs read them, and a selection for the reader."""

from pathlib import Path
from typing import Any

from plotting.results import Results

MATERIAL = ("density", "young_modulus", "poisson_ratio", "friction_angle", "dilation_angle", "cohesion")


def settings_files(results: Results) -> dict[str, dict]:
    """Name of a file of the scene -> its settings with all defaults. Of further solvers with their folder."""
    return results.resolved


def overview(files: dict[str, dict]) -> list[tuple[str, str]]:
    """Label and text of each row; what the files do not say is left out."""
    rows: list[tuple[str, str]] = []
    for name, settings in files.items():
        kind = Path(name).name
        if "time" in settings:
            rows.append(("time", _listed(settings["time"], " s")))
        if kind == "coupler.json":
            rows += _coupling(settings)
        elif kind == "mpm.json":
            rows += _soil(settings)
        elif kind == "fem.json":
            rows.append((f"structure {Path(name).parent.name}".strip(), _structure(settings)))
    return rows


def mesh_files(settings: Any) -> list[str]:
    """Files that the settings name, at any depth."""
    if isinstance(settings, dict):
        own = [value for key, value in settings.items() if key == "file" and isinstance(value, str)]
        return own + [name for value in settings.values() for name in mesh_files(value)]
    if isinstance(settings, list):
        return [name for value in settings for name in mesh_files(value)]
    return []


def _listed(values: dict, unit: str = "") -> str:
    return ", ".join(f"{key} {value:g}{unit}" if isinstance(value, (int, float)) and not isinstance(value, bool)
                     else f"{key} {value}" for key, value in values.items() if not isinstance(value, (dict, list)))


def _coupling(settings: dict) -> list[tuple[str, str]]:
    coupling = settings.get("coupling", {})
    parts = [f"{coupling.get('scheme', '')}, at most {coupling.get('max_iterations', '?')} iterations",
             f"acceleration {coupling.get('acceleration', {}).get('method', 'none')}",
             f"mapping {coupling.get('mapping', {}).get('method', '')}"]
    rows = [("coupling", "; ".join(part.strip() for part in parts))]
    for quantity, limits in coupling.get("convergence", {}).items():
        if isinstance(limits, dict):
            rows.append((f"limit of the {quantity}", _listed(limits)))
    pairs = [f"{each.get('name')}: {each.get('soil')} and {each.get('structure')}"
             for each in settings.get("interfaces", [])]
    return [*rows, ("interfaces", "; ".join(pairs))]


def _soil(settings: dict) -> list[tuple[str, str]]:
    grid = _mesh(settings.get("grid", {})) + f", basis {settings.get('basis', '?')}"
    rows = [("background grid", grid.lstrip(", "))]
    for body in settings.get("bodies", []):
        what = _material(body.get("material", {})) + _mesh(body.get("mesh", {}))
        rows.append((f"soil “{body.get('name', '')}”", f"{what}, {body.get('points_per_cell', '?')} points a cell"))
    for each in settings.get("interfaces", []):
        rest = {key: value for key, value in each.items() if key != "name"}
        rows.append((f"contact “{each.get('name', '')}”", _listed(rest)))
    return rows


def _structure(settings: dict) -> str:
    """Its materials, each with its group, and its mesh or matrices."""
    if "matrices" in settings:
        return f"matrices {settings['matrices'].get('stiffness', '?')}"
    several = settings.get("materials", [])
    what = "; ".join(f"“{each.get('group', '?')}” {_material(each)}" for each in several)
    return (what or _material(settings.get("material", {}))) + _mesh(settings.get("mesh", {}))


def _material(material: dict) -> str:
    chosen = {key.replace("_", " "): _varying(material[key]) for key in MATERIAL if key in material}
    below = ", and layers below" if material.get("layers") else ""
    return f"{material.get('law', '?').replace('_', ' ')}: {_listed(chosen)}{below}"


def _varying(value: Any) -> Any:
    """A constant that varies in space, in words."""
    if not isinstance(value, dict):
        return value
    words = {"by_depth": "by depth", "raster": "by a raster", "field": "by a field", "random": "at random"}
    return "varies " + " and ".join(text for key, text in words.items() if key in value)


def _mesh(mesh: dict) -> str:
    box = mesh.get("box")
    if box:
        cells = " × ".join(map(str, box.get("cells", [])))
        return f", box {box.get('low')} to {box.get('high')} m of {cells} {box.get('type')}"
    return f", mesh {mesh['file']}" if "file" in mesh else ""
