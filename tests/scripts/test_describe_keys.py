#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""docs/keys is what the programs print, and its schemas accept the scenes and refuse wrong files.

    test_describe_keys.py PROGRAMS      folder of the built programs
"""

import copy
import json
import sys
import unittest
from pathlib import Path
from typing import Any

from script_case import ROOT, ScriptCase

try:
    import jsonschema
except ImportError:  # Debian's python3-jsonschema
    jsonschema = None

PROGRAMS = Path(sys.argv.pop(1))
NAMES = ("coupler", "mpm", "fem")


def schema_of(name: str) -> dict:
    return json.loads((ROOT / "docs" / "keys" / f"{name}.schema.json").read_text(encoding="utf-8"))


def scene_file(name: str) -> dict:
    return json.loads((ROOT / "configs" / "granular_obstacle" / f"{name}.json").read_text(encoding="utf-8"))


def with_value(file: dict, pointer: str, value: Any) -> dict:
    """A copy with one value set, or taken out where it is `...`."""
    result = copy.deepcopy(file)
    *path, last = [int(key) if key.isdigit() else key for key in pointer.split("/")]
    place: Any = result
    for key in path:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return result


class Docs(ScriptCase):
    def test_docs_are_what_the_programs_print(self) -> None:
        result = self.script("describe_keys", "--programs", PROGRAMS, "--check")
        self.assertEqual(result.returncode, 0, result.stderr)


@unittest.skipIf(jsonschema is None, "python3-jsonschema is not installed")
class Schemas(ScriptCase):
    def test_schemas_are_schemas(self) -> None:
        for name in NAMES:
            jsonschema.Draft7Validator.check_schema(schema_of(name))

    def test_all_scenes_are_accepted(self) -> None:
        count = 0
        for name in NAMES:
            validator = jsonschema.Draft7Validator(schema_of(name))
            for path in sorted(ROOT.glob(f"configs/*/{name}.json")):
                errors = [error.message for error in validator.iter_errors(json.loads(path.read_text()))]
                self.assertEqual(errors, [], path)
                count += 1
        self.assertGreaterEqual(count, 11)

    def expect(self, valid: bool, name: str, pointer: str, value: Any) -> None:
        validator = jsonschema.Draft7Validator(schema_of(name))
        with self.subTest(file=name, pointer=pointer, value=value):
            self.assertEqual(validator.is_valid(with_value(scene_file(name), pointer, value)), valid)

    def test_wrong_types_ranges_words_and_keys_are_refused(self) -> None:
        for name, pointer, value in (
            ("coupler", "time/dt", "1e-3"), ("coupler", "time/dt", 0), ("coupler", "time/dt", ...),
            ("coupler", "coupling/predictor", 3), ("coupler", "coupling/predictor", 1.5),
            ("coupler", "coupling/predictr", 1), ("coupler", "coupling/scheme", "parallel"),
            ("coupler", "coupling/convergence", ...), ("coupler", "coupling/acceleration/filter", 1),
            ("coupler", "coupling/acceleration/filter", {"kind": "qr1_absolute"}),
            ("coupler", "coupling/acceleration/filter", {"kind": "none", "limit": 0.1}),
            ("coupler", "coupling/acceleration", {"method": "aitken", "history": 3}),
            ("coupler", "coupling/mapping/kernel", "thin_plate"), ("coupler", "interfaces", []),
            ("mpm", "dimension", 4), ("mpm", "gravity", [0]), ("mpm", "gravity", -9.81),
            ("mpm", "bodies/0/material/law", "mud"), ("mpm", "bodies/0/material/match", "extension"),
            ("mpm", "bodies/0/material/friction_angle", 90), ("mpm", "bodies/0/name", "a b"),
            ("mpm", "grid/file", "grid.msh"),
            ("mpm", "walls/0/motion", {}), ("mpm", "transfer/pic_share", 1.1),
            ("mpm", "interfaces/0/surface/polyline", [[0, 0]]),
            ("mpm", "interfaces/0/penalty", 1e8), ("mpm", "interfaces/0/mode", "slip"),
            ("mpm", "step_control", {"advective": 0}), ("mpm", "newton/max_iterations", 0),
            ("fem", "material/law", "mohr_coulomb"), ("fem", "supports/0/components", ["w"]),
            ("fem", "supports/0/components", []), ("fem", "analysis", "static dynamic"),
            ("fem", "time_integration", {"scheme": "newmark", "alpha": -0.1}),
            ("fem", "loads", [{"force": [1, 0]}]),
            ("fem", "loads", [{"group": "a", "point": [0, 0], "force": [1, 0]}]),
        ):
            self.expect(False, name, pointer, value)

    def test_alternatives_are_accepted(self) -> None:
        clay = {"law": "tresca", "density": 1, "young_modulus": 1, "poisson_ratio": 0.3, "cohesion": 1}
        for name, pointer, value in (
            ("coupler", "$schema", "../../docs/keys/coupler.schema.json"),
            ("coupler", "coupling/acceleration/filter", 0.5),
            ("coupler", "coupling/acceleration/filter", {"kind": "qr1_absolute", "limit": 3}),
            ("coupler", "coupling", {"scheme": "explicit", "mapping": {"tolerance": 1}}),
            ("coupler", "coupling/mapping", {"tolerance": 1, "method": "radial_basis", "support": 1}),
            ("coupler", "checkpoint", {}), ("mpm", "bodies/0/material", clay),
            ("mpm", "bodies/0/initial_stress", {"k0": "jaky", "surface": 1}),
            ("mpm", "bodies/0/initial_stress", {"k0": 0.5, "surface": 1}),
            ("mpm", "step_control", {"advective": None}),
            ("mpm", "walls/0/motion", {"table": [[0, 0, 0], [1, 1, 0]]}),
            ("fem", "time_integration", {"scheme": "bossak", "alpha": -0.1}),
            ("fem", "loads", [{"point": [0, 0], "force": [1, 0], "table": [[0, 1]]}]),
        ):
            self.expect(True, name, pointer, value)


if __name__ == "__main__":
    unittest.main()
