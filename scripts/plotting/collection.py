# SPDX-License-Identifier: BSD-3-Clause
"""One file that ParaView opens with soil and structures together: what their own files list, side by side in time."""

import copy
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from plotting.results import Results, Series

NAME = "scene.xdmf"


def write_collection(results: Results) -> Path | None:
    """DIR/scene.xdmf: at each time of the first series a collection of one grid a series, each its nearest frame.

    None where there is one series or none: its own file says as much.
    """
    series = [s for s in (results.soil, *results.structures) if s]
    if len(series) < 2:
        return None
    root = ElementTree.Element("Xdmf", Version="3.0")
    steps = ElementTree.SubElement(ElementTree.SubElement(root, "Domain"), "Grid", Name="scene", GridType="Collection",
                                   CollectionType="Temporal")
    for time in series[0].times:
        step = ElementTree.SubElement(steps, "Grid", Name="parts", GridType="Collection", CollectionType="Spatial")
        ElementTree.SubElement(step, "Time", Value=repr(float(time)))
        for each in series:
            step.append(_grid_beside(results.folder, each, each.nearest(time)))
    ElementTree.indent(root)
    path = results.folder / NAME
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
    return path


def _grid_beside(folder: Path, series: Series, index: int) -> ElementTree.Element:
    """A frame's grid with its files named as seen from `folder`, and without its own time."""
    grid = copy.deepcopy(series.grid(index))
    part = series.path.parent.relative_to(folder)
    grid.set("Name", part.name)
    grid.remove(grid.find("Time"))
    for item in grid.iter("DataItem"):
        item.text = f"{part}/{item.text.strip()}"
    return grid
