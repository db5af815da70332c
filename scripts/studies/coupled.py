# SPDX-License-Identifier: BSD-3-Clause
"""The studies of the scene granular_obstacle."""

import numpy as np

from plotting.results import ResultsError
from plotting.style import legend_beside, new_figure, save
from studies.measures import Measured, relative_rms
from studies.runner import Runner, report

SCENE = "granular_obstacle"
STEP_SIZES = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5]  # [s], finest last
REST = 0.1  # [s] at the end of a run that count as rest


def step_size(dt: float) -> list[str]:
    return [f"coupler.json:/time/dt={dt:g}", f"coupler.json:/time/dt_min={dt / 64:g}"]


def error_vs_time(runner: Runner) -> None:
    """Error of A's displacement and of the impulse against the finest step, beside the run time."""
    runs = {dt: runner.run(f"dt_{dt:g}", SCENE, step_size(dt)) for dt in STEP_SIZES}
    reference = runs[STEP_SIZES[-1]]
    rows = []
    for dt in STEP_SIZES[:-1]:
        rows.append([
            dt,
            relative_rms(runs[dt].displacement(), reference.displacement()),
            relative_rms(runs[dt].impulse(), reference.impulse()),
            runs[dt].seconds(),
        ])
    report(runner.folder, ["dt [s]", "error of A", "error of impulse", "run time [s]"], rows)
    print(f"reference: dt = {STEP_SIZES[-1]:g} s, {reference.seconds():.1f} s")

    figure, (axes,) = new_figure(7.5, 4.5)
    _, of_a, of_impulse, seconds = np.array(rows).T
    axes.loglog(seconds, of_a, "o-", label="displacement of A")
    axes.loglog(seconds, of_impulse, "s-", label="impulse on the structure")
    for row in rows:
        axes.annotate(f"dt = {row[0]:g} s", (row[3], max(row[1:3])), textcoords="offset points",
                      xytext=(0, 8), ha="center", fontsize=9)
    axes.margins(x=0.15, y=0.2)
    axes.set_xlabel("run time [s]")
    axes.set_ylabel(f"relative error (RMS) against dt = {STEP_SIZES[-1]:g} s")
    legend_beside(axes)
    print(save(figure, runner.folder / "error_vs_time.png"))


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
    report(runner.folder, head, rows)


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
        peak = int(np.argmax(np.abs(a.values)))
        impulse = _impulse_or_none(run)
        rows.append([name, 1e3 * float(a.values[peak]), float(a.time[peak]), 1e3 * a.mean_of_last(REST),
                     "" if impulse is None else float(impulse.values[-1]), run.seconds()])
        upper.plot(a.time, 1e3 * a.values, label=name)
        if impulse is not None:
            lower.plot(impulse.time, impulse.values, label=name)
    upper.set_ylabel("displacement of A [mm]")
    lower.set_ylabel("impulse [N s/m]")
    lower.set_xlabel("time [s]")
    legend_beside(upper)
    head = ["model", "peak of A [mm]", "at t [s]", "rest [mm]", "impulse [N s/m]", "run time [s]"]
    report(runner.folder, head, rows)
    print(save(figure, runner.folder / "mesh_convergence.png"))


def _impulse_or_none(run: Measured):
    """A monolithic run has no interface, hence no force on it."""
    try:
        return run.impulse()
    except ResultsError:
        return None


def dt_consistency(runner: Runner) -> None:
    """Displacement and force at rest, which must not depend on the step size."""
    rows = []
    for dt in (2e-4, 1e-4, 5e-5):
        run = runner.run(f"dt_{dt:g}", SCENE, step_size(dt))
        rows.append([dt, 1e3 * run.displacement().mean_of_last(REST), run.force().mean_of_last(REST)])
    last = rows[-1]
    rows = [[*row, row[1] / last[1] - 1, row[2] / last[2] - 1] for row in rows]
    head = ["dt [s]", "rest of A [mm]", "force at rest [N/m]", "A against finest", "force against finest"]
    report(runner.folder, head, rows)


STUDIES = {study.__name__: study for study in (error_vs_time, acceleration, mesh_convergence, dt_consistency)}
