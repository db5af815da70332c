# SPDX-License-Identifier: BSD-3-Clause
"""Fields by which the cells of a structure are coloured: stresses, plastic strain, damage and cracks."""

import numpy as np

from plotting.results import Frame

# Field of the frames -> how it is called beside the colours.
AS_STORED = {
    "failed": "failed (1: gone)",
    "plastic_strain": "plastic strain",
    "crack_width": "crack width [m]",
    "tensile_damage": "tensile damage",
    "compressive_damage": "compressive damage",
}
VON_MISES, TENSION = "equivalent stress (von Mises) [Pa]", "largest tension [Pa]"


def tensors(stress: np.ndarray) -> np.ndarray:
    """Columns xx, xy, xz, yy, yz, zz -> num_cells x 3 x 3 [Pa]."""
    xx, xy, xz, yy, yz, zz = stress.T
    return np.stack([np.stack([xx, xy, xz], -1), np.stack([xy, yy, yz], -1), np.stack([xz, yz, zz], -1)], -2)


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Equivalent stress sqrt(3/2 s:s) with the deviator s (von Mises 1913) [Pa]; stress: num_cells x 6 [Pa]."""
    whole = tensors(stress)
    deviator = whole - np.trace(whole, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2)))


def cell_values(frame: Frame) -> dict[str, np.ndarray]:
    """Label -> a value of each cell. Of structures that crack the largest principal stress too; empty: the frame has
    no such field."""
    found = {}
    fields = {name: frame.fields[name] for name in frame.on_cells}
    if "stress" in fields:
        found[VON_MISES] = von_mises(fields["stress"])
        if "tensile_damage" in fields:
            found[TENSION] = np.linalg.eigvalsh(tensors(fields["stress"]))[:, -1]
    return found | {label: fields[name] for name, label in AS_STORED.items() if name in fields}
