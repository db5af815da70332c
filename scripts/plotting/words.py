# SPDX-License-Identifier: BSD-3-Clause
"""Numbers and times as words."""


def duration(seconds: float) -> str:
    """Time as in the progress line of the programs."""
    if seconds < 119.5:
        return f"{seconds:.0f} s"
    if seconds >= 48 * 3600:
        return f"{seconds / 86400:.0f} days"
    if seconds >= 3599.5:
        return f"{seconds / 3600:.1f} h"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60} s"


def count(number: int, word: str, plural: str = "") -> str:
    return f"{number} {word if number == 1 else plural or word + 's'}"


def percent(share: float) -> str:
    """Two digits, whatever the size; what is smaller than 1e-9 is round-off."""
    if abs(share) < 1e-9:
        return "0 %"
    return f"{100 * share:.2g} %" if abs(share) < 0.1 else f"{100 * share:.0f} %"


def seconds(value: float) -> str:
    """Length of a step in words: 12 ms, 1.3 s."""
    return f"{1e3 * value:.3g} ms" if value < 1 else f"{value:.3g} s"
