# SPDX-License-Identifier: BSD-3-Clause
"""Parts that the tests of scripts/element-test and scripts/calibrate share."""

import json
import sys
from pathlib import Path

import numpy as np
from script_case import ROOT, ScriptCase

from element.curves import curves_of
from element.laboratory import Options, program_of
from element.program import Soil, run_program

PROGRAMS = ROOT / "build" / "release" / "bin"
SAND = {"law": "mohr_coulomb", "density": 2000, "young_modulus": 2e7, "poisson_ratio": 0.3, "friction_angle": 33,
        "dilation_angle": 6, "cohesion": 8000}


def take_programs() -> None:
    """The folder of the programs is the last word of the command line."""
    global PROGRAMS
    if len(sys.argv) > 1 and Path(sys.argv[-1]).is_dir():
        PROGRAMS = Path(sys.argv.pop())


class ElementCase(ScriptCase):
    def curves(self, test: str, soil: dict = SAND, **options: object) -> dict[str, np.ndarray]:
        """Curves of a test, from the program itself."""
        chosen = Options(**options)
        run = run_program(self.folder, test, program_of(test, chosen), Soil(blocks={"material": soil}), PROGRAMS)
        self.assertEqual(run.code, 0, run.message)
        return curves_of(run.table, chosen.band_width)

    def write_json(self, path: str, values: dict) -> Path:
        return self.write(path, json.dumps(values))
