# SPDX-License-Identifier: BSD-3-Clause
"""Stresses and damage on the faces of structures over time, as 8-bit numbers."""

from typing import Any

import numpy as np

from plotting.results import Series
from plotting.stresses import cell_values
from reporting.rigid import text_of

MOST_FIELDS = 3


class SolidColours:
    """The fields that structures may be coloured by; each has one range over all structures and times.

    owners: of each structure the number of the cell of each of its faces.
    """

    def __init__(self, structures: list[Series], owners: list[np.ndarray]) -> None:
        self.structures = structures
        self.owners = owners
        labels = [label for structure in structures for label in cell_values(structure.frame(0))]
        self.labels = list(dict.fromkeys(labels))[:MOST_FIELDS]

    @property
    def bytes_of_frame(self) -> int:
        return len(self.labels) * sum(len(owners) for owners in self.owners)

    def pack(self, times: np.ndarray) -> tuple[list[dict[str, Any]], list[list[list[str | None]]]]:
        """Fields with label and range, and of each structure, frame and field a number from 0 to 255 a face; None: the
        structure lacks the field."""
        found = [[cell_values(structure.frame(structure.nearest(time))) for time in times]
                 for structure in self.structures]
        fields = [{"label": label, **self._range([values[label] for frames in found for values in frames
                                                  if label in values])} for label in self.labels]
        packed = [[[self._shares(values.get(field["label"]), field, owners) for field in fields] for values in frames]
                  for frames, owners in zip(found, self.owners)]
        return fields, packed

    @staticmethod
    def _range(values: list[np.ndarray]) -> dict[str, float]:
        low = min(0.0, min(float(np.nanmin(each)) for each in values))
        high = max(float(np.nanmax(each)) for each in values)
        return {"low": low, "high": high if high > low else low + 1}

    @staticmethod
    def _shares(values: np.ndarray | None, field: dict[str, Any], owners: np.ndarray) -> str | None:
        if values is None:
            return None
        shares = (np.nan_to_num(values[owners]) - field["low"]) / (field["high"] - field["low"])
        return text_of(np.round(255 * shares).astype("u1"))
