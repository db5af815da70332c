# SPDX-License-Identifier: BSD-3-Clause
"""Objects of a JSON file, read strictly."""

import re
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from .raster import Raster, TerrainError, read_raster

NAME = "letters from A to z, digits, _ and -"  # of what a name of the programs consists


def without_blanks(text: str) -> str | None:
    """A name with _ for blanks; None: the programs do not take it."""
    name = "_".join(text.split())
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else None


class Reader:
    """An object of the file: each key is asked for by name, other ones are refused.

    @raises TerrainError  it is no object or has a key that is not one of `keys` (None: any)
    """

    def __init__(self, values: object, where: str, keys: tuple[str, ...] | None):
        if not isinstance(values, dict):
            raise TerrainError(f"{where}: found {values!r}, allowed: an object")
        for key in values:
            if keys is not None and key not in keys:
                near = get_close_matches(key.lower(), keys, 1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise TerrainError(f"{where}/{key}: unknown, allowed: {', '.join(keys)}{hint}")
        self.values, self.where = dict(values), where

    def fail(self, key: str, allowed: str) -> TerrainError:
        found = repr(self.values[key]) if key in self.values else "nothing"
        return TerrainError(f"{self.where}/{key}: found {found}, allowed: {allowed}")

    def number(self, key: str, at_least_zero: bool = False) -> float:
        value = self.values.get(key)
        real = isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value)
        if not real or not (value > 0 or (at_least_zero and value == 0)):
            raise self.fail(key, "a number >= 0" if at_least_zero else "a number > 0")
        return float(value)

    def real(self, key: str, allowed: str) -> float:
        """A number of any sign."""
        value = self.values.get(key)
        if not isinstance(value, (int, float)) or isinstance(value, bool) or not np.isfinite(value):
            raise self.fail(key, allowed)
        return float(value)

    def rows(self, key: str, at_least: int) -> np.ndarray:
        try:
            rows = np.array(self.values.get(key), dtype=float)
        except (TypeError, ValueError) as error:
            raise self.fail(key, f"at least {at_least} rows [x, y]") from error
        if rows.ndim != 2 or rows.shape[1] != 2 or len(rows) < at_least or not np.isfinite(rows).all():
            raise self.fail(key, f"at least {at_least} rows [x, y]")
        return rows

    def place(self, key: str) -> np.ndarray:
        try:
            place = np.array(self.values.get(key), dtype=float)
        except (TypeError, ValueError) as error:
            raise self.fail(key, "[x, y]") from error
        if place.shape != (2,) or not np.isfinite(place).all():
            raise self.fail(key, "[x, y]")
        return place

    def text(self, key: str, allowed: str) -> str:
        value = self.values.get(key)
        if not isinstance(value, str) or not value:
            raise self.fail(key, allowed)
        return value

    def name(self, key: str = "name") -> str:
        """A name as the programs take it, and as a file may have it; blanks become _."""
        name = without_blanks(self.text(key, NAME))
        if name is None:
            raise self.fail(key, NAME)
        return name

    def raster(self, key: str, folder: Path) -> Raster:
        name = self.text(key, "the name of a raster")
        try:
            return read_raster(folder / name)
        except TerrainError as error:
            raise TerrainError(f"{self.where}/{key}: {error}") from error

    def children(self, key: str, keys: tuple[str, ...] | None) -> "list[Reader]":
        """Readers of the objects of a list; none where the key is missing."""
        values = self.values.get(key, [])
        if not isinstance(values, list):
            raise self.fail(key, "a list of objects")
        return [Reader(value, f"{self.where}/{key}/{k}", keys) for k, value in enumerate(values)]

    def child(self, key: str, keys: tuple[str, ...] | None) -> "Reader":
        return Reader(self.values.get(key), f"{self.where}/{key}", keys)
