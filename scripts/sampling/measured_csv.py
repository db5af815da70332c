# SPDX-License-Identifier: BSD-3-Clause
"""CSV files of measurements, in a laboratory or on a site: one reader for all of them."""

import csv
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Column(NamedTuple):
    """Place of a column in its rows, and its unit as the head names it; None: it names none."""

    number: int
    unit: str | None


class MeasuredCsv:
    """A CSV file whose head is NAME or NAME[UNIT] of each column; lines that start with # are remarks.

    It is UTF-8, with or without a byte order mark. Decimals have a point: a comma makes a field more than the head has.

    @param error  raised with what was found, where and what is allowed: no such file, too few rows, a row with more or
        fewer values than the head, a column twice
    @param where  what the texts of errors start with
    """

    def __init__(self, path: Path, error: type[Exception], where: str, min_rows: int = 1):
        self.path, self.error, self.where = path, error, where
        rows = list(csv.reader(self._lines(path)))
        if len(rows) <= min_rows:
            raise error(f"{where}: found {max(len(rows) - 1, 0)} rows, allowed: a head and at least "
                        f"{'one row' if min_rows == 1 else f'{min_rows} rows'}")
        head, *self.rows = rows
        for number, row in enumerate(self.rows, 1):
            if len(row) != len(head):
                raise error(f"{where}: row {number}: found {len(row)} value{'s' * (len(row) > 1)}, "
                            f"allowed: {len(head)}, as the head has; decimals have a point, no comma")
        self.columns: dict[str, Column] = {}
        for number, text in enumerate(head):
            found = re.fullmatch(r"\s*([^\[\]]+?)\s*(?:\[\s*([^\s\[\]]+)\s*\])?\s*", text)
            if not found:
                raise error(f"{where}: found the column {text!r}, allowed: NAME or NAME[UNIT]")
            if found[1] in self.columns:
                raise error(f"{where}: found the column {found[1]} twice, allowed: once")
            self.columns[found[1]] = Column(number, found[2])

    def column(self, name: str) -> Column:
        if name not in self.columns:
            raise self.error(f"{self.where}: found no column {name}, allowed: {', '.join(self.columns)}")
        return self.columns[name]

    def numbers(self, name: str) -> np.ndarray:
        """Values as they stand in the file. @raises error  no such column, or what is no finite number"""
        number = self.column(name).number
        return np.array([self._number(row[number], name, line) for line, row in enumerate(self.rows, 1)])

    def _lines(self, path: Path) -> list[str]:
        try:
            return [line for line in path.read_text(encoding="utf-8-sig").splitlines()
                    if line.strip() and not line.startswith("#")]
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "not UTF-8"
            raise self.error(f"{self.where}: {reason}, allowed: a CSV file") from error

    def _number(self, text: str, name: str, line: int) -> float:
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value) or "_" in text:  # Python takes 1_0 for 10
            raise self.error(f"{self.where}: row {line}: found {text!r} for {name}, allowed: a finite number, with a "
                             "point for decimals")
        return value
