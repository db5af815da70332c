# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the package."""


class SettingError(ValueError):
    """A path or a value that a scene cannot have; the text says where, what was found and what is allowed."""


class RunError(RuntimeError):
    """A run that did not come to its end; the text has the exit code and what the programs said last."""
