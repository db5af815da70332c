# SPDX-License-Identifier: BSD-3-Clause
"""A block of soil thrown at a rigid wall, implicit and explicit."""

import json

import numpy as np

from plotting.style import legend_beside, new_figure
from studies.measures import Curve, Measured, relative_rms
from studies.runner import Runner, folder_of
from studies.throw import Throw, settings_of

SCENE = "column_collapse"  # gives the frame only
SPEED, END, FINER = 10, 0.03, 4  # [m/s], [s], cells of the throws by those here
STEP_SIZES = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5, 1.25e-5]  # [s], finest last
EXPLICIT = 'mpm.json:/time_integration={"scheme": "explicit"}'


def settings(dt: float) -> list[str]:
    """The throw on cells of 2.5 mm with 6,400 points."""
    time = {"end": END, "dt": dt, "dt_min": dt / 256}
    return [*settings_of(Throw(density=None, speed=SPEED)),
            "mpm.json:/grid/box/cells=" + json.dumps([24 * FINER, 16 * FINER]),
            "mpm.json:/bodies/0/mesh/box/cells=" + json.dumps([10 * FINER, 10 * FINER]),
            "mpm.json:/time=" + json.dumps(time), "mpm.json:/output/interval=" + json.dumps(END)]


def momentum(run: Measured) -> Curve:
    """Momentum of the soil along x [kg m/s]."""
    table = run.table("probes.csv")
    return Curve(table["time"], table["momentum_x"])


def created(run: Measured) -> float:
    """Energy that was made, by that of the start."""
    table = run.table("probes.csv")
    return float(table["created_energy"][-1] / table["kinetic_energy"][0])


def impact(runner: Runner) -> None:
    """Soil of 10 m/s thrown at a rigid wall, implicit and explicit: error beside run time."""
    runs = {kind: {dt: runner.run(folder_of(f"{kind} {1e3 * dt:g} ms"), SCENE, [*settings(dt), *extra])
                   for dt in STEP_SIZES}
            for kind, extra in (("implicit", []), ("explicit", [EXPLICIT]))}
    reference = runs["implicit"][STEP_SIZES[-1]]
    figure, (axes,) = new_figure(8, 4.5)
    rows = []
    for kind, of_kind in runs.items():
        points = []
        for dt, run in of_kind.items():
            error = None if run is reference else relative_rms(momentum(run), momentum(reference))
            substeps = run.summary["solver"]["explicit"]["substeps"]
            rows.append([f"{kind}, dt {1e3 * dt:g} ms", run.table("steps.csv").num_rows, substeps or "",
                         run.cuts(), float(momentum(run).values[-1]), created(run), run.cpu_seconds(),
                         "" if error is None else error])
            if error is not None:
                points.append((run.cpu_seconds(), error))
        axes.loglog(*np.array(points).T, "o-" if kind == "implicit" else "^-", label=kind)
    head = ["", "steps", "substeps", "cuts", "momentum at the end [kg/s]", "created energy", "CPU time [s]",
            "error of momentum"]
    runner.report(head, rows)
    runner.remark("6,400 points in cells of 2.5 mm, wave speed 20.7 m/s; errors: root mean square over the run, "
                  f"relative to implicit, dt {1e3 * STEP_SIZES[-1]:g} ms; created energy over the energy at the start")
    axes.set_xlabel("CPU time [s]")
    axes.set_ylabel("relative error (RMS) of momentum")
    legend_beside(axes)
    runner.save(figure, "impact.png")


STUDIES = {impact.__name__: impact}
