# SPDX-License-Identifier: BSD-3-Clause
"""Point-substeps and point-iterations of the soil a second of one core."""

import json
import statistics
from pathlib import Path

from plotting.results import ResultsError
from studies.instructions import FORMS, SOLVER, has_run, scene, solve
from studies.ranks import THREADS
from studies.runner import ROOT, Runner, folder_of
from studies.size import read

REPEATS = 3  # the median counts
#: Steps of the shorter and of the longer run, by dimension: their difference has no start in it.
STEPS = {"explicit": {2: (20, 220), 3: (10, 50)}, "implicit": {2: (5, 105), 3: (2, 22)}}
BED = 2  # cells below the soil, where it lies on facets
FRICTION = 0.5
ALL_FORMS = {**FORMS, "quad4, bspline, F-bar": ("bspline", "fbar", "quad4"), "hex8, gimp": ("gimp", "none", "hex8"),
             "hex8, bspline, F-bar": ("bspline", "fbar", "hex8")}
SLIDE = ROOT / "configs" / "slide_on_terrain"
SLIDE_STEPS = {"explicit": (5, 25), "implicit": (1, 5)}
HEAD = ["soil", "points", "explicit, free", "explicit, on facets", "implicit, free", "implicit, on facets"]
# Wyser et al. (2021), Geosci. Model Dev. 14, 7749-7774, ep2-3De v1.0: explicit steps in space of an elastoplastic soil.
PUBLISHED = [["ep2-3De v1.0, one core of an i9-10900K", 0.152], ["ep2-3De v1.0, one V100", 58.0]]


def write_bed(path: Path, size: tuple[float, float], height: float, facet: float) -> None:
    """A level surface of triangles in squares of `facet`, as PLY."""
    columns, rows = (round(length / facet) for length in size)
    places = [f"{i * facet} {j * facet} {height}" for j in range(rows + 1) for i in range(columns + 1)]
    triangles = []
    for j in range(rows):
        for i in range(columns):
            a, b = j * (columns + 1) + i, (j + 1) * (columns + 1) + i
            triangles += [f"3 {a} {a + 1} {b + 1}", f"3 {a} {b + 1} {b}"]
    head = ["ply", "format ascii 1.0", f"element vertex {len(places)}",
            *(f"property float {axis}" for axis in "xyz"), f"element face {len(triangles)}",
            "property list uchar int vertex_indices", "end_header"]
    path.write_text("\n".join([*head, *places, *triangles]) + "\n", encoding="utf-8")


def on_facets(settings: dict, bed: Path) -> dict:
    """The column of instructions.scene on a bed of facets of half a cell in place of the wall of the grid below it."""
    grid, box = settings["grid"]["box"], settings["bodies"][0]["mesh"]["box"]
    cell = grid["high"][0] / grid["cells"][0]
    height = BED * cell
    for corner in ("low", "high"):
        box[corner] = [*box[corner][:-1], box[corner][-1] + height]
    grid["high"] = [*grid["high"][:-1], grid["high"][-1] + height]
    grid["cells"] = [*grid["cells"][:-1], grid["cells"][-1] + BED]
    settings["walls"] = [wall for wall in settings["walls"] if wall["group"] != "bottom"]
    width = grid["high"][0]
    if settings["dimension"] == 2:
        surface = {"polyline": [[width, height], [0, height]], "spacing": cell / 2}
    else:
        bed.parent.mkdir(parents=True, exist_ok=True)
        write_bed(bed, (width, grid["high"][1]), height, cell / 2)
        surface = {"triangles": str(bed), "normals": "up"}
    settings["rigid_walls"] = [{"name": "bed", "surface": surface, "friction": FRICTION}]
    return settings


def slide(scheme: str) -> dict:
    """The soil of slide_on_terrain with its terrain, without the barrier."""
    settings = json.loads((SLIDE / "mpm.json").read_text(encoding="utf-8"))
    settings.pop("interfaces", None)
    settings["bodies"][0]["mesh"]["file"] = str(SLIDE / settings["bodies"][0]["mesh"]["file"])
    surface = settings["rigid_walls"][0]["surface"]
    surface["triangles"] = str(SLIDE / surface["triangles"])
    dt = json.loads((SLIDE / "coupler.json").read_text(encoding="utf-8"))["time"]["dt"]
    settings["time"] = {"end": 1, "dt": dt, "dt_min": dt / 1024}
    settings["output"] = {"interval": 100}
    return with_scheme(settings, scheme)


def with_scheme(settings: dict, scheme: str) -> dict:
    settings["time_integration"] = {"scheme": "explicit" if scheme == "explicit" else "bossak"}
    return settings


def work_of(runner: Runner, folder: Path, settings: dict, steps: int) -> tuple[int, int, float]:
    """Points, substeps or Newton iterations, and seconds of CPU of a run of so many steps."""
    settings["time"]["end"] = steps * settings["time"]["dt"]
    if not (runner.reuse and has_run(folder, settings)):
        solve(folder, settings, [SOLVER, "--log-level", "warn"], THREADS)
    summary, _ = read(folder / "out")
    soil = summary["solver"]
    explicit = settings["time_integration"]["scheme"] == "explicit"
    repeats = soil["explicit"]["substeps"] if explicit else soil["newton_iterations"]
    return soil["points"], repeats, summary["cpu_seconds"]


def rate(runner: Runner, name: str, settings: dict, steps: tuple[int, int]) -> tuple[int, float]:
    """Points, and millions of them times substeps or iterations a second of CPU: median of REPEATS."""
    print(f"{name}: running", flush=True)
    rates = []
    for repeat in range(REPEATS):
        few, many = (work_of(runner, runner.folder / f"{folder_of(name)}_{count}_{repeat}", settings, count)
                     for count in steps)
        if not (many[1] > few[1] and many[2] > few[2]):
            raise ResultsError(f"{name}: the longer run took no more work or time than the shorter one: machine too "
                               "busy")
        rates.append(many[0] * (many[1] - few[1]) / (many[2] - few[2]) / 1e6)
    return many[0], statistics.median(rates)


def column_row(runner: Runner, name: str, form: tuple[str, str, str]) -> list:
    points, rates = 0, []
    for scheme, steps in STEPS.items():
        for place in ("free", "on facets"):
            settings = with_scheme(scene(*form), scheme)
            if place == "on facets":
                settings = on_facets(settings, runner.folder / "bed.ply")
            points, found = rate(runner, f"{name}, {scheme}, {place}", settings, steps[settings["dimension"]])
            rates.append(found)
    return [name, points, *rates]


def slide_row(runner: Runner) -> list:
    """Row of the shipped scene, which is always on its terrain."""
    found = {scheme: rate(runner, f"slide_on_terrain, {scheme}", slide(scheme), steps)
             for scheme, steps in SLIDE_STEPS.items()}
    return ["slide_on_terrain: hex8, gimp, F-bar", found["explicit"][0], "", found["explicit"][1], "",
            found["implicit"][1]]


def throughput(runner: Runner) -> None:
    """Millions of point-substeps and point-iterations a second of one core, free and on facets."""
    rows = [column_row(runner, name, form) for name, form in ALL_FORMS.items()]
    runner.report(HEAD, [*rows, slide_row(runner)])
    runner.report(["code", "million point-substeps a second"], PUBLISHED, "published, explicit steps in space")
    runner.remark("published figures: Wyser et al. (2021), Geosci. Model Dev. 14, 7749-7774; other machines and "
                  "another soil")


STUDIES = {throughput.__name__: throughput}
