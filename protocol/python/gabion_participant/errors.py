# SPDX-License-Identifier: BSD-3-Clause
"""Errors, by what the caller can do about them."""


class ParticipantError(Exception):
    """Base of the errors of this package. Each ends the run, except ConvergenceError."""


class ConvergenceError(ParticipantError):
    """The step has no solution; the accepted state is untouched. The coupler tries a smaller dt."""


class ProtocolError(ParticipantError):
    """The coupler was lost, refused this participant, ended the run, or spoke something else."""


class UsageError(ParticipantError):
    """A call in the wrong order, or with values that do not fit. The message says what is allowed."""


def printable(text: str) -> str:
    """A text that the coupler wrote, for a terminal or a log: what a terminal would obey instead of showing stands
    there as \\x1b; lines behind the first are indented."""
    return "".join("\n    " if c == "\n" else c if c.isprintable() or c == "\t" else
                   c.encode("unicode_escape").decode() for c in text)


def says_all(problem: BaseException) -> bool:
    """The errors of this package do in their text, but for the one that a solver raises."""
    return isinstance(problem, ParticipantError) and not isinstance(problem, ConvergenceError)


def text_of(problem: BaseException) -> str:
    """Text for the coupler: `KeyError: 'wall'`, or the text alone where it says all."""
    kind, text = type(problem).__name__, str(problem)
    if text and says_all(problem):
        return text
    return f"{kind}: {text}" if text else kind
