# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the laboratory as stages of element.json.

y is the axis of the sample, upright, x and z are radial; in shear tests the top moves along x. Compression is
positive. Stresses that are given are effective where the pores drain: the back pressure is added to them.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

CONSOLIDATION = "consolidation"
CONSOLIDATION_INCREMENTS, INCREMENTS = 20, 200


class ElementError(Exception):
    """A test that cannot be put together or read; the text says what was found and what is allowed."""


@dataclass(frozen=True)
class Options:
    """Data of a test. None: not given."""

    confine: float | None = None  #: effective stress after consolidation [Pa]
    ocr: float | None = None  #: over-consolidation ratio after it
    strain: float | None = None  #: axial strain or angle of shear at the end, or amplitude of the cycles
    stress: float | None = None  #: effective axial stress at the end, of creep: deviator [Pa]
    unload: float | None = None  #: effective axial stress after unloading [Pa]
    cycles: int | None = None
    hold: float | None = None  #: time in which nothing is changed [s]
    undrained: bool | None = None
    back_pressure: float | None = None  #: [Pa]
    band_width: float | None = None  #: height over which the sample shears [m]
    duration: float | None = None  #: of each stage that loads [s]
    increments: int | None = None  #: of each stage after consolidation

    @property
    def back(self) -> float:
        return self.back_pressure or 0.0


def _stage(name: str, options: Options, **keys: object) -> dict:
    stage = {"name": name, "increments": INCREMENTS if options.increments is None else options.increments, **keys}
    if options.undrained:
        stage["drainage"] = "undrained"
    if options.duration is not None:
        stage["duration"] = options.duration
    return stage


def _consolidation(options: Options, *components: str) -> dict:
    stage = {"name": CONSOLIDATION, "increments": CONSOLIDATION_INCREMENTS,
             "stress": dict.fromkeys(components, options.confine + options.back),
             "ocr": 1 if options.ocr is None else options.ocr}
    return stage | ({} if options.duration is None else {"duration": options.duration})


def _turns(options: Options) -> list[tuple[str, float]]:
    """Names and strains of the stages that are led by strain."""
    if options.cycles is None:
        return [("shear", options.strain)]
    turns = [value for _ in range(options.cycles) for value in (options.strain, -options.strain)]
    return [(f"turn_{k}", value) for k, value in enumerate([*turns, 0.0], 1)]


def _sheared(options: Options, consolidation: dict, component: str, **keys: object) -> list[dict]:
    stages = [_stage(name, options, strain={component: value}, **keys) for name, value in _turns(options)]
    stages[0]["zero_strain"] = True
    return [consolidation, *stages]


def isotropic(options: Options) -> list[dict]:
    """Equal stress in all directions."""
    return _loaded(options, ("xx", "yy", "zz"))


def oedometer(options: Options) -> list[dict]:
    """Axial stress, no radial strain."""
    return _loaded(options, ("yy",))


def _loaded(options: Options, components: tuple[str, ...]) -> list[dict]:
    ends = [("load", options.stress)] + ([] if options.unload is None else [("unload", options.unload)])
    return [_stage(name, options, stress=dict.fromkeys(components, end + options.back)) for name, end in ends]


def triaxial(options: Options) -> list[dict]:
    """Axial strain under a constant cell pressure; undrained with --undrained."""
    cell = dict.fromkeys(("xx", "zz"), options.confine + options.back)
    return _sheared(options, _consolidation(options, "xx", "yy", "zz"), "yy", stress=cell)


def plane_strain(options: Options) -> list[dict]:
    """Axial strain under a constant pressure along x, no strain along z after consolidation."""
    return _sheared(options, _consolidation(options, "xx", "yy", "zz"), "yy",
                    stress={"xx": options.confine + options.back})


def constant_p(options: Options) -> list[dict]:
    """Axial strain under a constant mean stress."""
    return _sheared(options, _consolidation(options, "xx", "yy", "zz"), "yy",
                    mean_stress=options.confine + options.back, moved_by=["xx", "zz"])


def simple_shear(options: Options) -> list[dict]:
    """Angle of shear under a constant upright stress, no other strains, after consolidation in an oedometer."""
    return _sheared(options, _consolidation(options, "yy"), "xy", stress={"yy": options.confine + options.back})


def direct_shear(options: Options) -> list[dict]:
    """Simple shear of the band between the halves of a box, --band-width high; the table has its slip."""
    return simple_shear(options)


def creep(options: Options) -> list[dict]:
    """Axial stress beyond the cell pressure, then held."""
    cell = options.confine + options.back
    ends = {"xx": cell, "yy": cell + options.stress, "zz": cell}
    load = _stage("load", options, stress=ends, zero_strain=True)
    return [_consolidation(options, "xx", "yy", "zz"), load, load | _hold(options)]


def relaxation(options: Options) -> list[dict]:
    """Axial strain under a constant cell pressure, then held."""
    stages = triaxial(options)
    return [*stages, stages[-1] | _hold(options)]


def _hold(options: Options) -> dict:
    return {"name": "hold", "duration": options.hold, "zero_strain": False}


_ANY = ("back_pressure", "band_width", "duration", "increments")
#: test -> function, options that it needs, others that it may have
TESTS: dict[str, tuple[Callable[[Options], list[dict]], tuple[str, ...], tuple[str, ...]]] = {
    "isotropic": (isotropic, ("stress",), ("unload",)),
    "oedometer": (oedometer, ("stress",), ("unload",)),
    "triaxial": (triaxial, ("confine", "strain"), ("ocr", "undrained", "cycles")),
    "plane_strain": (plane_strain, ("confine", "strain"), ("ocr", "undrained", "cycles")),
    "constant_p": (constant_p, ("confine", "strain"), ("ocr", "cycles")),
    "simple_shear": (simple_shear, ("confine", "strain"), ("ocr", "undrained", "cycles")),
    "direct_shear": (direct_shear, ("confine", "strain", "band_width"), ("ocr", "cycles")),
    "creep": (creep, ("confine", "stress", "hold"), ("ocr", "undrained")),
    "relaxation": (relaxation, ("confine", "strain", "hold"), ("ocr", "undrained")),
}
SHEAR_TESTS = ("simple_shear", "direct_shear")
COMPRESSION_TESTS = ("isotropic", "oedometer")
TIME_TESTS = ("creep", "relaxation")


def program_of(test: str, options: Options, where: str = "--") -> dict:
    """element.json without a material.

    where: begins the names of options in messages
    @raises ElementError  an unknown test, an option that it needs or does not have
    """
    if test not in TESTS:
        raise ElementError(f"{where}test: found {test!r}, allowed: {', '.join(TESTS)}")
    make, needed, more = TESTS[test]
    for field in fields(Options):
        given, name = getattr(options, field.name) is not None, where + _written(field.name, where)
        if field.name in needed and not given:
            raise ElementError(f"{name}: found nothing, which the test {test} needs: "
                               f"{', '.join(where + _written(each, where) for each in needed)}")
        if given and field.name not in (*needed, *more, *_ANY):
            raise ElementError(f"{name}: found with the test {test}, which has no use for it, allowed: "
                               f"{', '.join(where + _written(each, where) for each in (*needed, *more, *_ANY))}")
    if options.cycles is not None and options.cycles < 1:
        raise ElementError(f"{where}cycles: found {options.cycles}, allowed: a whole number >= 1")
    program: dict = {"stages": make(options)}
    if options.back:
        program["back_pressure"] = options.back
    if options.band_width is not None:
        program["band_width"] = options.band_width
    if test in SHEAR_TESTS:
        program["rotation"] = "simple_shear"
    return program


def _written(name: str, where: str) -> str:
    return name.replace("_", "-") if where == "--" else name
