# SPDX-License-Identifier: BSD-3-Clause
"""The data sets of a plan."""

from pathlib import Path

import numpy as np

from sampling.answers import read_answer, read_column
from sampling.reader import PlanError, PlanReader, is_number
from terrain_scene.raster import TerrainError, read_raster

from .data import FIELDS, DataSet, MeasuredTable, OneNumber, OverPlan, OverTime, Source

ANSWER = ("table", "column", "take", "summary")
TABLE = ("file", "over", "value", "deviation")
KEYS = (*TABLE, *ANSWER, "deposit", "time", "cell")


def read_data(name: str, reader: PlanReader, folder: Path, dimension: int) -> DataSet:
    """folder: that of the plan; dimension: of the scene. @raises PlanError"""
    kind = reader.one_of(("column", "summary", "deposit"))
    if "file" not in reader.values:
        if kind == "deposit":
            raise reader.fail("file", "a CSV file, or a raster of depths")
        return _number(name, reader)
    if kind == "summary":
        raise reader.fail("summary", "no file beside it; \"value\" is the number that was measured")
    if kind == "column":
        reader = PlanReader(reader.values, reader.where, (*TABLE, "table", "column"))
        return _from_table(name, reader, folder, OverTime(*read_column(reader)))
    reader = PlanReader(reader.values, reader.where, (*TABLE, "deposit", "time", "cell"))
    source = OverPlan(reader.word("deposit", FIELDS), reader.real("time") if "time" in reader.values else None,
                      reader.number("cell") if "cell" in reader.values else None)
    if not reader.text("file", "the name of a CSV file or a raster").lower().endswith(".csv"):
        return _from_raster(name, reader, folder, source, dimension)
    return _from_table(name, reader, folder, source, "xy"[:dimension - 1])


def _number(name: str, reader: PlanReader) -> DataSet:
    """One number, written into the plan."""
    reader = PlanReader(reader.values, reader.where, ("value", "deviation", *ANSWER))
    value, deviation = reader.real("value"), reader.number("deviation")
    asked = {key: each for key, each in reader.values.items() if key in ANSWER}
    answer = read_answer(name, PlanReader(asked, reader.where, ANSWER))
    return DataSet(name, reader.where, (), np.zeros((1, 0)), np.array([value]), np.array([deviation]),
                   OneNumber(answer))


def _from_table(name: str, reader: PlanReader, folder: Path, source: Source, axes: str = "") -> DataSet:
    """axes: of the plan, for a deposit."""
    table = MeasuredTable(folder / reader.text("file", "the name of a CSV file"), f"{reader.where}/file")
    column = reader.text("value", "the name of the column that was measured")
    over = reader.words("over") if "over" in reader.values else tuple(axes) or ("time",)
    if len(over) != max(1, len(axes)) or len({*over, column}) <= len(over):
        raise reader.fail("over", f"{max(1, len(axes))} column{'s' if len(axes) > 1 else ''} other than {column}")
    values = table.numbers(column)
    for each in over:
        allowed = "length" if axes else "time"
        if table.quantity(each) not in ("", allowed):
            raise PlanError(f"{reader.where}/over: found {each} in a unit of {table.quantity(each)}, allowed: one of "
                            f"{allowed}")
    at = np.column_stack([table.numbers(each) for each in over])
    _require_once(at, over, table, reader.where)
    return DataSet(name, reader.where, over, at, values, _deviation(reader, table, column), source)


def _from_raster(name: str, reader: PlanReader, folder: Path, source: OverPlan, dimension: int) -> DataSet:
    """A raster, of which each cell with data is a value."""
    if dimension != 3:
        raise reader.fail("file", "a CSV file: the plan of a two-dimensional scene is a line")
    for key in ("over", "value"):
        if key in reader.values:
            raise reader.fail(key, "nothing beside a raster")
    try:
        raster = read_raster(folder / reader.values["file"])
    except TerrainError as error:
        raise PlanError(f"{reader.where}/file: {error}") from error
    rows, columns = np.nonzero(np.isfinite(raster.values))
    if not len(rows):
        raise PlanError(f"{reader.where}/file: {raster.path}: found no cell with data, allowed: at least one")
    at = np.column_stack([raster.x + columns * raster.spacing, raster.y + rows * raster.spacing])
    return DataSet(name, reader.where, ("x", "y"), at, raster.values[rows, columns],
                   np.full(len(rows), reader.number("deviation")), source)


def _deviation(reader: PlanReader, table: MeasuredTable, column: str) -> np.ndarray:
    """Standard deviations, a number in the unit of the column or a column of their own."""
    given = reader.values.get("deviation")
    if is_number(given) and given > 0:
        return np.full(len(table.rows), given * table.factor(column))
    if not isinstance(given, str):
        raise reader.fail("deviation", f"a number > 0 in the unit of {column}, or the name of a column")
    if table.quantity(given) != table.quantity(column):
        raise PlanError(f"{reader.where}/deviation: found {given} with the unit of "
                        f"{table.quantity(given) or 'none'}, allowed: one of {table.quantity(column) or 'none'}, as "
                        f"{column} has")
    found = table.numbers(given)
    wrong = np.flatnonzero(found <= 0)
    if len(wrong):
        raise PlanError(f"{reader.where}/deviation: {table.path}: row {wrong[0] + 1}: found "
                        f"{found[wrong[0]] / table.factor(given):g}, allowed: a number > 0")
    return found


def _require_once(at: np.ndarray, over: tuple[str, ...], table: MeasuredTable, where: str) -> None:
    """Refuse a place or time that comes twice, which would count twice."""
    _, first, count = np.unique(at, axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        twice = at[first[np.argmax(count > 1)]]
        place = ", ".join(f"{name} {value:.9g}" for name, value in zip(over, twice))
        row = np.flatnonzero((at == twice).all(axis=1))[1] + 1
        raise PlanError(f"{where}/file: {table.path}: row {row}: found {place} (SI units) twice, allowed: once; what "
                        "was measured again is a data set of its own")
