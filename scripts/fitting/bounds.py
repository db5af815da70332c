# SPDX-License-Identifier: BSD-3-Clause
"""Parameters that are sought, each between bounds."""

import math
from dataclasses import dataclass

from sampling.reader import PlanReader, is_number

CLEARLY_LOG = 10  # bounds that are so many times apart are searched by their logarithm


@dataclass(frozen=True)
class Sought:
    """A parameter: 0 <= z <= 1 runs from its low to its high value, evenly or by the logarithm."""

    name: str
    low: float
    high: float
    by_log: bool

    @property
    def width(self) -> float:
        """Width of the range of z: of the value, or of its natural logarithm."""
        return math.log(self.high / self.low) if self.by_log else self.high - self.low

    def value(self, z: float) -> float:
        return self.low * math.exp(z * self.width) if self.by_log else self.low + z * self.width

    def z_of(self, value: float) -> float:
        return math.log(value / self.low) / self.width if self.by_log else (value - self.low) / self.width


def read_sought(name: str, reader: PlanReader) -> Sought:
    """The keys "between" and "scale" of a parameter. @raises PlanError"""
    between = reader.values.get("between")
    if not isinstance(between, list) or len(between) != 2 or not all(map(is_number, between)):
        raise reader.fail("between", "[low, high]")
    low, high = map(float, between)
    if not low < high:
        raise reader.fail("between", "[low, high] with low < high")
    by_log = low > 0 and high / low >= CLEARLY_LOG
    if "scale" in reader.values:
        by_log = reader.word("scale", ("log", "linear")) == "log"
        if by_log and not low > 0:
            raise reader.fail("scale", "linear where low is not above 0")
    return Sought(name, low, high, by_log)
