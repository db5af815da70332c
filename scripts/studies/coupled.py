# SPDX-License-Identifier: BSD-3-Clause
"""The studies of the scene granular_obstacle."""

import json

import numpy as np
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from plotting.results import ResultsError
from plotting.style import legend_beside, new_figure
from studies.measures import Measured, relative_rms
from studies.runner import Runner, folder_of

SCENE = "granular_obstacle"
STEP_SIZES = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5]  # [s], finest last
TIME_ERRORS = [8e-3, 4e-3, 2e-3, 1e-3]
LIMITS = ("time_error", "advective", "strain", "newton_target", "approach")


def without_limits(*kept: str) -> str:
    """Steps of fixed size but for these LIMITS."""
    return "mpm.json:/step_control=" + json.dumps({limit: None for limit in LIMITS if limit not in kept})


FIXED_STEPS = without_limits()
EXPLICIT = 'mpm.json:/time_integration={"scheme": "explicit"}'
EXPLICIT_STEPS = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5]  # [s] of the coupling
REST = 0.1  # [s] at the end of a run that count as rest
IMPACT_END = 0.2  # [s]: until then the soil arrives, after it the heap leans on the wall


def step_size(dt: float) -> list[str]:
    return [f"coupler.json:/time/dt={dt:g}", f"coupler.json:/time/dt_min={dt / 64:g}"]


ANSWER = ["peak of A [mm]", "residual displacement of A [mm]", "force at rest [N/m]",
          f"impulse to {IMPACT_END:g} s [N s/m]",
          "impulse [N s/m]"]
ANSWER_NAMES = [name.partition(" [")[0] for name in ANSWER]  # without units


def answer_of(run: Measured) -> list[float]:
    """ANSWER of a run."""
    impulse = run.impulse()
    return [1e3 * run.peak()[0], 1e3 * run.displacement().mean_of_last(REST), run.force().mean_of_last(REST),
            float(impulse.at(np.array(IMPACT_END))), float(impulse.values[-1])]


def errors_of(run: Measured, reference: Measured) -> list[float]:
    """Errors of A's displacement and of the impulse."""
    return [relative_rms(run.displacement(), reference.displacement()),
            relative_rms(run.impulse(), reference.impulse())]


SPEED_SCENES = (SCENE, f"{SCENE}_explicit", "slope_barrier", "two_posts", "slide_on_terrain")


def speed(runner: Runner) -> None:
    """Wall time of a step of granular_obstacle, in free flow and in contact, and where it goes."""
    runs = {name: runner.run(name, name, []) for name in SPEED_SCENES}
    table = runs[SCENE].table("steps.csv")
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
    runner.report(LATER_HEAD, [[name, *later_iterations(run)] for name, run in runs.items()], "later iterations")
    runner.remark("newton: Newton iterations of the soil (0: explicit steps); share of soil: CPU time of the soil in "
                  "iterations after the first one of a step over that in all of them; share of steps: over the wall "
                  "time of the steps with more than one. A better start of later iterations saves less than that")
    runner.report(["scene", "CPU time [s]", "frames and checkpoints [s]", "share"],
                  [[name, run.solver_seconds(), run.solver_seconds("output_cpu_seconds"),
                    run.solver_seconds("output_cpu_seconds") / run.solver_seconds()] for name, run in runs.items()],
                  "output")


LATER_HEAD = ["scene", "steps in contact", "iterations", "newton, first", "newton, a later one", "share of soil",
              "share of steps"]


def later_iterations(run: Measured) -> list[float]:
    """LATER_HEAD of the steps of several iterations."""
    table = run.table("iterations.csv")
    tries = np.cumsum(table["iteration"] == 0)
    several = np.isin(tries, tries[table["iteration"] == 1])
    later = several & (table["iteration"] > 0)
    first = several & (table["iteration"] == 0)
    soil = table["soil_seconds"]
    return [int(first.sum()), float(several.sum() / first.sum()), float(table["soil_newton"][first].mean()),
            float(table["soil_newton"][later].mean()), float(soil[later].sum() / soil[several].sum()),
            float(soil[later].sum() / table["wall_seconds"][several].sum())]


MARKS = {"fixed steps": "o", "steps by their error": "s", "explicit": "^",
         "explicit, steps by their limits": "*", "explicit, wide limits of the coupling": "v"}
CONVERGENCE = "coupler.json:/coupling/convergence"
WIDE_LIMITS = [f"{CONVERGENCE}/displacement/{kind}=1e-3" for kind in ("absolute", "relative")]
WIDE_LIMITS.append(f"{CONVERGENCE}/force/absolute=0.1")


def error_vs_time(runner: Runner) -> None:
    """The answer of granular_obstacle over the step size, implicit and explicit, beside the run time."""
    series = {
        "fixed steps": {f"dt {1e3 * dt:g} ms": [FIXED_STEPS, *step_size(dt)] for dt in STEP_SIZES},
        "steps by their error": {f"time_error {e:g}": [f"mpm.json:/step_control/time_error={e:g}"]
                                 for e in TIME_ERRORS},
        "explicit": {f"explicit, dt {1e3 * dt:g} ms": [EXPLICIT, FIXED_STEPS, *step_size(dt)]
                     for dt in EXPLICIT_STEPS},
        "explicit, steps by their limits": {"explicit, limits": [EXPLICIT]},
        "explicit, wide limits of the coupling": {
            f"explicit, dt {1e3 * dt:g} ms, wide": [EXPLICIT, FIXED_STEPS, *step_size(dt), *WIDE_LIMITS]
            for dt in EXPLICIT_STEPS[:3]},
    }
    runs = {kind: {name: runner.run(folder_of(name), SCENE, settings) for name, settings in of_kind.items()}
            for kind, of_kind in series.items()}
    reference_name = list(runs["fixed steps"])[-1]
    reference = runs["fixed steps"][reference_name]
    figure, (axes,) = new_figure(11, 4.5)
    rows = []
    for kind, of_kind in runs.items():
        errors = {}
        for name, run in of_kind.items():
            row = [name, run.table("steps.csv").num_rows, run.cuts(), *answer_of(run)]
            if run is not reference:
                errors[name] = [run.seconds(), *errors_of(run, reference)]
            rows.append([*row, *errors.get(name, [run.seconds(), "", ""])])
        seconds, of_a, of_impulse = np.array(list(errors.values())).T
        mark = MARKS[kind]
        axes.loglog(seconds, of_a, f"{mark}-", label=f"displacement of A, {kind}")
        axes.loglog(seconds, of_impulse, f"{mark}--", label=f"impulse on the structure, {kind}")
        for name, (x, *y) in errors.items():
            axes.annotate(name.removeprefix("explicit, ").removeprefix("dt ").removeprefix("time_error "),
                          (x, max(y)), textcoords="offset points", xytext=(0, 8), ha="center", fontsize=9)
    head = ["", "steps", "cuts", *ANSWER, "run time [s]", "error of A", "error of impulse"]
    runner.report(head, rows)
    runner.remark(f"errors: root mean square over the run, relative to fixed steps, {reference_name}; "
                  f"residual displacement and force at rest: mean of the last {REST} s")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())
    axes.margins(x=0.15, y=0.2)
    axes.set_xlabel("run time [s]")
    axes.set_ylabel(f"relative error (RMS) against {reference_name}")
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


FORCE_LIMITS = [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1]  # [N], root mean square of a component


def tolerance(runner: Runner) -> None:
    """The answer of granular_obstacle over the limit of the coupling's force residual."""
    runs = {limit: runner.run(folder_of(f"force {limit:g} N"), SCENE,
                              [f"{CONVERGENCE}/force/absolute={limit:g}"])
            for limit in FORCE_LIMITS}
    reference = runs[FORCE_LIMITS[0]]
    rows = []
    for limit, run in runs.items():
        iterations = run.iterations_in_contact()
        errors = ["", ""] if run is reference else errors_of(run, reference)
        rows.append([f"{limit:g}", float(iterations.mean()), int(iterations.max()), run.cuts(), *answer_of(run),
                     run.seconds(), *errors])
    head = ["limit [N]", "iterations", "most", "cuts", *ANSWER, "run time [s]", "error of A", "error of impulse"]
    runner.report(head, rows)
    runner.remark(f"limit: root mean square over the components of the nodal forces; errors: root mean square over "
                  f"the run, relative to {FORCE_LIMITS[0]:g} N; iterations: mean of the steps in contact; "
                  f"residual displacement and force at rest: mean of the last {REST} s")


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
    head = ["model", "peak of A [mm]", "at t [s]", "residual [mm]", "impulse [N s/m]", "run time [s]"]
    runner.report(head, rows)
    runner.save(figure, "mesh_convergence.png")


def _impulse_or_none(run: Measured):
    """A monolithic run has no interface, hence no force on it."""
    try:
        return run.impulse()
    except ResultsError:
        return None


STUDIES = {study.__name__: study for study in (speed, error_vs_time, acceleration, tolerance,
                                               mesh_convergence)}
