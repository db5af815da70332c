# SPDX-License-Identifier: BSD-3-Clause
"""Plan of a calibration: material, parameters that are sought, tests with what the laboratory measured."""

import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from element.curves import LabTable, read_laboratory
from element.laboratory import COMPRESSION_TESTS, TESTS, TIME_TESTS, ElementError, Options, program_of
from element.program import read_json
from fitting.bounds import Sought, read_sought
from sampling.reader import PlanError, PlanReader, read_object

KEYS = ("material", "water", "scene", "body", "parameters", "tests", "samples", "polished", "seed", "robust")
NUMBERS = ("confine", "ocr", "strain", "stress", "hold", "back_pressure", "band_width", "duration")
TEST_KEYS = ("name", "lab", "test", "over", "undrained", "increments", *NUMBERS)


@dataclass(frozen=True)
class SoughtKey(Sought):
    """A parameter of the material. keys: where in it."""

    keys: tuple[str, ...]


@dataclass(frozen=True)
class LabTest:
    """A test with what was measured: `over` is the abscissa, the other columns are fitted."""

    name: str
    test: str
    program: dict
    band_width: float | None
    over: str
    measured: LabTable

    @property
    def fitted(self) -> list[str]:
        return [name for name in self.measured.columns if name != self.over]

    def scale(self, column: str) -> float:
        """Range of a measured column: misfits are shares of it."""
        return float(np.ptp(self.measured.columns[column]))


@dataclass(frozen=True)
class CalibrationPlan:
    blocks: dict[str, Any]  #: "material", "water"
    sought: tuple[SoughtKey, ...]
    tests: tuple[LabTest, ...]
    samples: int
    polished: int
    seed: int
    robust: bool

    def blocks_at(self, z: np.ndarray) -> dict[str, Any]:
        """The soil with these values."""
        blocks = copy.deepcopy(self.blocks)
        for each, share in zip(self.sought, z):
            place = blocks["material"]
            for key in each.keys[:-1]:
                place = place[key]
            place[each.keys[-1]] = each.value(share)
        return blocks


def read_calibration(path: Path) -> CalibrationPlan:
    """@raises PlanError, ElementError"""
    plan = PlanReader(read_object(path), str(path), KEYS)
    blocks = _blocks(plan, path.parent)
    named = plan.named("parameters", ("set", "between", "scale"))
    sought = tuple(_sought(name, each, blocks["material"]) for name, each in named.items())
    if not sought:
        raise plan.fail("parameters", "an object with at least one parameter")
    places = [each.keys for each in sought]
    if len(set(places)) != len(places):
        raise PlanError(f"{path}/parameters: found two that set the same, allowed: one")
    entries = plan.values.get("tests")
    if not isinstance(entries, list) or not entries:
        raise plan.fail("tests", "a list of at least one test")
    tests = tuple(_test(k, PlanReader(entry, f"{path}/tests/{k}", TEST_KEYS), path.parent)
                  for k, entry in enumerate(entries))
    if len({test.name for test in tests}) != len(tests):
        raise PlanError(f"{path}/tests: found two of one name, allowed: names of their own (\"name\")")
    count = sum(len(test.fitted) * len(test.measured.columns[test.over]) for test in tests)
    if count <= len(sought):
        raise PlanError(f"{path}/tests: found {count} measured values for {len(sought)} parameters, "
                        "allowed: more values")
    samples = _whole(plan, "samples", 20)
    polished = _whole(plan, "polished", min(3, samples))
    if polished > samples:
        raise plan.fail("polished", f"at most as many as samples, {samples}")
    return CalibrationPlan(blocks, sought, tests, samples, polished, _whole(plan, "seed", 1), _flag(plan, "robust"))


def _blocks(plan: PlanReader, folder: Path) -> dict[str, Any]:
    if plan.one_of(("material", "scene")) == "material":
        if "body" in plan.values:
            raise plan.fail("body", "only with \"scene\"")
        return {key: plan.inner(key, None).values for key in ("material", "water") if key in plan.values}
    if "water" in plan.values:
        raise plan.fail("water", "only with \"material\"; a scene has its own")
    file = folder / plan.text("scene", "the folder of a scene") / "mpm.json"
    bodies = read_json(file).get("bodies", [])
    chosen = [body for body in bodies if plan.values.get("body") in (None, body.get("name"))]
    if len(chosen) != 1:
        raise plan.fail("body", f"one of {', '.join(str(body.get('name')) for body in bodies)}")
    return {key: chosen[0][key] for key in ("material", "water") if key in chosen[0]}


def _sought(name: str, reader: PlanReader, material: dict) -> SoughtKey:
    pointer = reader.text("set", "a key of the material, such as /friction_angle")
    keys = tuple(pointer.split("/")[1:])
    place: Any = material
    for key in keys[:-1]:
        place = place.get(key) if isinstance(place, dict) else None
    if not pointer.startswith("/") or not keys or not isinstance(place, dict):
        raise reader.fail("set", "a key of the material, such as /friction_angle or /softening/slip; the object that "
                                 "holds it has to be there")
    bounds = read_sought(name, reader)
    return SoughtKey(name, bounds.low, bounds.high, bounds.by_log, keys)


def _test(k: int, reader: PlanReader, folder: Path) -> LabTest:
    kind = reader.word("test", tuple(TESTS))
    measured = read_laboratory(folder / reader.text("lab", "the name of a CSV"))
    usual = _usual_abscissa(kind)
    over = reader.word("over", tuple(measured.columns)) if "over" in reader.values else usual
    if over not in measured.columns or len(measured.columns) < 2:
        raise ElementError(f"{measured.path}: found {', '.join(measured.columns)}, allowed: {over} "
                           "(or another \"over\") and at least one column beside it")
    _require_ascending(measured, over)
    given = {key: reader.real(key) for key in NUMBERS if key in reader.values}
    end = float(np.max(measured.columns[over]))
    if over in ("eps_a", "gamma"):
        given.setdefault("strain", end)
    elif over == "slip" and "band_width" in given:
        given.setdefault("strain", end / given["band_width"])
    elif over == "sigma_a" and kind in COMPRESSION_TESTS:
        given.setdefault("stress", end)
    options = Options(**given, undrained=_flag(reader, "undrained") or None,
                      increments=_whole(reader, "increments", 0) or None)
    test = LabTest(reader.values.get("name", f"{kind}_{k}"), kind, program_of(kind, options, f"{reader.where}/"),
                   options.band_width, over, measured)
    if not isinstance(test.name, str) or not test.name.replace("_", "").replace("-", "").isalnum():
        raise reader.fail("name", "letters, digits, _ and -")
    for column in test.fitted:
        if not test.scale(column) > 0:
            raise ElementError(f"{measured.path}: found the same {column} in all rows, allowed: a curve")
    return test


def _require_ascending(measured: LabTable, over: str) -> None:
    """@raises ElementError  a row whose abscissa does not lie above that of the row before"""
    at = measured.columns[over]
    for row in np.flatnonzero(np.diff(at) <= 0)[:1] + 1:
        raise ElementError(f"{measured.path}: row {row + 1}: found {over} {at[row]:.9g} after {at[row - 1]:.9g} (SI "
                           f"units), allowed: {over} that ascends from row to row; another loading is a table of its "
                           "own")


def _usual_abscissa(kind: str) -> str:
    if kind in COMPRESSION_TESTS:
        return "sigma_a"
    if kind in TIME_TESTS:
        return "t"
    return {"direct_shear": "slip", "simple_shear": "gamma"}.get(kind, "eps_a")


def _whole(reader: PlanReader, key: str, otherwise: int) -> int:
    return reader.whole(key, 1) if key in reader.values else otherwise


def _flag(reader: PlanReader, key: str) -> bool:
    value = reader.values.get(key, False)
    if not isinstance(value, bool):
        raise reader.fail(key, "true or false")
    return value
