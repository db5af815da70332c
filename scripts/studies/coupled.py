# SPDX-License-Identifier: BSD-3-Clause
"""The studies of the scene granular_obstacle."""

import numpy as np

from plotting.results import ResultsError
from plotting.style import legend_beside, new_figure
from studies.measures import Measured, relative_rms
from studies.runner import Runner

SCENE = "granular_obstacle"
STEP_SIZES = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5]  # [s], finest last
REST = 0.1  # [s] at the end of a run that count as rest


def step_size(dt: float) -> list[str]:
    return [f"coupler.json:/time/dt={dt:g}", f"coupler.json:/time/dt_min={dt / 64:g}"]


def speed(runner: Runner) -> None:
    """Wall time of a step of granular_obstacle, in free flow and in contact, and where it goes."""
    table = runner.run("run", SCENE, []).table("steps.csv")
    contact = table["skipped"] == "none"
    parts = {
        "soil [ms]": table["soil.busy_seconds"],
        "structure [ms]": table["structure.busy_seconds"],
        "messages [ms]": table["soil.message_seconds"] + table["structure.message_seconds"],
        "acceleration [ms]": table["acceleration_seconds"],
    }
    rows = []
    for name, which in (("free flow", ~contact), ("contact", contact)):
        means = [1e3 * float(np.mean(seconds[which])) for seconds in (table["wall_seconds"], *parts.values())]
        rows.append([name, int(np.sum(which)), *means])
    runner.report(["", "steps", "a step [ms]", *parts], rows)


def error_vs_time(runner: Runner) -> None:
    """The answer of granular_obstacle over the step size: errors against the finest step, beside the run time."""
    runs = {dt: runner.run(f"dt_{dt:g}", SCENE, step_size(dt)) for dt in STEP_SIZES}
    reference = runs[STEP_SIZES[-1]]
    rows, errors = [], []
    for dt, run in runs.items():
        peak, _ = run.peak()
        row = [1e3 * dt, run.cuts(), 1e3 * peak, 1e3 * run.displacement().mean_of_last(REST),
               run.force().mean_of_last(REST)]
        if run is reference:
            rows.append([*row, "", "", run.seconds()])
            continue
        errors.append([relative_rms(run.displacement(), reference.displacement()),
                       relative_rms(run.impulse(), reference.impulse()), run.seconds()])
        rows.append([*row, *errors[-1]])
    head = ["dt [ms]", "cuts", "peak of A [mm]", "rest of A [mm]", "force at rest [N/m]", "error of A",
            "error of impulse", "run time [s]"]
    runner.report(head, rows)
    runner.remark(f"errors: root mean square over the run, relative to dt = {1e3 * STEP_SIZES[-1]:g} ms; "
                  f"rest: mean of the last {REST} s")

    figure, (axes,) = new_figure(7.5, 4.5)
    of_a, of_impulse, seconds = np.array(errors).T
    axes.loglog(seconds, of_a, "o-", label="displacement of A")
    axes.loglog(seconds, of_impulse, "s-", label="impulse on the structure")
    for dt, row in zip(STEP_SIZES, errors):
        axes.annotate(f"dt = {dt:g} s", (row[2], max(row[:2])), textcoords="offset points",
                      xytext=(0, 8), ha="center", fontsize=9)
    axes.margins(x=0.15, y=0.2)
    axes.set_xlabel("run time [s]")
    axes.set_ylabel(f"relative error (RMS) against dt = {STEP_SIZES[-1]:g} s")
    legend_beside(axes)
    runner.save(figure, "error_vs_time.png")


ACCELERATIONS = {
    "constant": ["coupler.json:/coupling/acceleration/method=constant"],
    "Aitken": ["coupler.json:/coupling/acceleration/method=aitken"],
    "IQN-ILS": ["coupler.json:/coupling/acceleration/method=iqn_ils"],
    "MVQN": ["coupler.json:/coupling/acceleration/method=mvqn"],
}


def acceleration(runner: Runner) -> None:
    """Coupling iterations and run time of the accelerations. A method that fails says so."""
    rows = []
    for name, settings in ACCELERATIONS.items():
        try:
            run = runner.run(name, SCENE, settings)
        except ResultsError as error:
            print(error)
            rows.append([name, "failed", "", "", ""])
            continue
        iterations = run.iterations_in_contact()
        rows.append([name, float(iterations.mean()), int(iterations.max()), run.cuts(), run.seconds()])
    head = ["acceleration", "mean iterations in contact", "largest", "cuts", "run time [s]"]
    runner.report(head, rows)


def mesh_convergence(runner: Runner) -> None:
    """A's displacement and the impulse for two grids and the monolithic model."""
    runs = {
        "h = 5 mm": runner.run("h_5mm", SCENE, []),
        "h = 2.5 mm": runner.run("h_2.5mm", f"{SCENE}_fine", []),
        "monolithic": runner.run("monolithic", f"{SCENE}_monolithic", []),
    }
    rows = []
    figure, (upper, lower) = new_figure(9, 6, 2)
    for name, run in runs.items():
        a = run.displacement()
        peak, peak_time = run.peak()
        impulse = _impulse_or_none(run)
        rows.append([name, 1e3 * peak, peak_time, 1e3 * a.mean_of_last(REST),
                     "" if impulse is None else float(impulse.values[-1]), run.seconds()])
        upper.plot(a.time, 1e3 * a.values, label=name)
        if impulse is not None:
            lower.plot(impulse.time, impulse.values, label=name)
    upper.set_ylabel("displacement of A [mm]")
    lower.set_ylabel("impulse [N s/m]")
    lower.set_xlabel("time [s]")
    legend_beside(upper)
    head = ["model", "peak of A [mm]", "at t [s]", "rest [mm]", "impulse [N s/m]", "run time [s]"]
    runner.report(head, rows)
    runner.save(figure, "mesh_convergence.png")


def _impulse_or_none(run: Measured):
    """A monolithic run has no interface, hence no force on it."""
    try:
        return run.impulse()
    except ResultsError:
        return None


STUDIES = {study.__name__: study for study in (speed, error_vs_time, acceleration, mesh_convergence)}
