# SPDX-License-Identifier: BSD-3-Clause


class SettingsError(Exception):
    """structure.json or the model file: names what was found and what is allowed."""


class OpenSeesError(Exception):
    """The process of the model has ended or said what is wrong."""
