# SPDX-License-Identifier: BSD-3-Clause
"""Scenes and results of Gabion in Python: read a scene, change settings, run it, follow it, read what came out.

    import gabion

    scene = gabion.Scene("configs/column_collapse")
    scene["mpm.json:/time/end"] = 0.05
    results = scene.run("results/short")
    results.probes["front"]                 # array over results.probes["time"]

docs/python.md has more. Settings and results are in SI units.
"""

from . import _root  # noqa: F401  (finds the programs and the readers)
from .errors import RunError, SettingError
from .job import Job, Progress, follow
from .results import Picture, Results, stack, to_pandas, to_xarray
from .scene import Scene

from plotting.results import Frame, ResultsError, Series, Table

ROOT = _root.ROOT  #: folder with the scripts and scenes

__all__ = ["Frame", "Job", "Picture", "Progress", "ROOT", "Results", "ResultsError", "RunError", "Scene", "Series",
           "SettingError", "Table", "follow", "stack", "to_pandas", "to_xarray"]
