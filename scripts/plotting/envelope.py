# SPDX-License-Identifier: BSD-3-Clause
"""Smallest and largest value of each probe over all accepted steps, with its time."""

import csv
from pathlib import Path

import numpy as np

from plotting.results import Results


def envelope_rows(results: Results) -> list[list[str]]:
    """Rows [column, smallest, its time, largest, its time, last value] of probes.csv; the first time where a value
    comes again. Columns without any number are left out."""
    table = results.table("probes.csv")
    if table is None or not table.num_rows:
        return []
    rows = []
    times = table["time"]
    for column in table.names:
        values = table[column]
        if column == "time" or values.dtype.kind != "f" or not np.isfinite(values).any():
            continue
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        last = values[np.isfinite(values)][-1]
        rows.append([column,
                     *(f"{number:.10g}" for number in (values[low], times[low], values[high], times[high], last))])
    return rows


def write_envelope(results: Results, out: Path) -> Path | None:
    """Write OUT/envelope.csv. @returns its path, None without probes"""
    rows = envelope_rows(results)
    if not rows:
        return None
    path = out / "envelope.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["column", "smallest", "smallest_at", "largest", "largest_at", "last"])
        writer.writerows(rows)
    return path
