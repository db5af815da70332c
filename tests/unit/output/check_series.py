# SPDX-License-Identifier: BSD-3-Clause
"""Read a series as other programs do: the XML tree, and each array it names through h5py."""
import math
import os
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy

folder = sys.argv[1]


def arrays(grid):
    """Arrays of one frame by the name of the attribute (or Topology, Geometry)."""
    found = {}
    for element in grid:
        item = element.find("DataItem")
        if item is None:
            continue
        file_name, dataset = item.text.strip().split(":")
        with h5py.File(os.path.join(folder, file_name), "r") as file:
            values = file[dataset][()]
        assert values.shape == tuple(int(n) for n in item.get("Dimensions").split()), item.text
        assert values.dtype.itemsize == int(item.get("Precision")), item.text
        assert values.dtype.kind == {"Int": "i", "Float": "f"}[item.get("NumberType")], item.text
        found[element.get("Name", element.tag)] = values
    return found


def frames(name):
    root = ElementTree.parse(os.path.join(folder, name + ".xdmf")).getroot()
    collection = root.find("Domain/Grid")
    assert collection.get("CollectionType") == "Temporal"
    return collection.findall("Grid")


points = frames("points")
assert [float(grid.find("Time").get("Value")) for grid in points] == [0.0, 0.25, 0.5]
for frame, grid in enumerate(points):
    values = arrays(grid)
    n = 10 + frame
    assert (values["Topology"] == numpy.arange(n)).all()
    assert values["Geometry"].shape == (n, 3) and (values["Geometry"][:, 2] == 0).all()
    assert (values["Geometry"][:, 1] == math.sqrt(2.0) * frame).all()
    assert (values["pressure"] == numpy.arange(n) + 100.0 * frame).all()
    assert (values["velocity"] == values["Geometry"].astype("f4")).all()
    assert (values["stress"] == [1, 4, 0, 2, 0, 3]).all()

mesh = arrays(frames("mesh")[0])
assert (mesh["Topology"] == [[0, 1, 4, 3], [1, 2, 5, 4]]).all()
assert (mesh["damage"] == [5, 6]).all()
assert sorted(os.listdir(folder)) == [
    "mesh.xdmf", "mesh_000000.h5", "points.xdmf",
    "points_000000.h5", "points_000001.h5", "points_000002.h5"]
