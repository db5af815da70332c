# SPDX-License-Identifier: BSD-3-Clause
"""The verdict on a run in words: how it ended, whether it converged, what it waited for, what it conserved.

scripts/watch and scripts/report say the same.
"""

import math
import statistics
from collections.abc import Iterator
from dataclasses import dataclass

from plotting.account import FINE
from plotting.live import QUIET, Run, State
from plotting.lock import Owner
from plotting.words import count, duration, percent, seconds

SLOW = 10  # medians from which on a step is slow
# Columns of what a structure dissipates, and who does.
SINKS = {"plastic_work": "plastic flow", "damage_work": "cracks", "brake_work": "brakes",
         "failed_energy": "failed cells", "damping_work": "damping"}
CLOSED, OPEN = 1e-3, 1e-2  # of the energy or momentum exchanged: closed below, open above


@dataclass(frozen=True)
class Statement:
    """kind: good, note (worth a look) or bad; topic: end, convergence, cuts, time, energy, momentum."""

    kind: str
    topic: str
    text: str


def verdict(run: Run) -> list[Statement]:
    """All statements so far. `run` must have been read."""
    return [statement for part in (_end, _convergence, _cuts, _time, _soil, _structures, _interface)
            for statement in part(run)]


def headline(run: Run) -> str:
    """State of the run in a word, or a few."""
    quiet = run.seconds_since_last_row()
    if run.state() is State.RUNNING and quiet > QUIET:
        return f"running, no new row for {duration(quiet)}"
    return run.state().value


def _end(run: Run) -> Iterator[Statement]:
    state, steps = run.state(), run.account
    until = f"{count(steps.count, 'step')} to t = {steps.time:.6g} s"
    if state is State.COMPLETED:
        wall = (run.summary or {}).get("wall_seconds")
        total = wall.get("total") if isinstance(wall, dict) else wall
        yield Statement("good", "end", f"Completed: {until}{f' in {duration(total)}' if total else ''}.")
        return
    if state is State.RUNNING:
        share = f" of {run.end:g} s ({100 * steps.time / run.end:.0f} %)" if run.end > 0 else ""
        yield Statement("note", "end", f"Running: {until}{share}. All that follows is of these steps.")
        return
    quiet = duration(run.seconds_since_last_row())
    where = "Killed" if run.owner is Owner.GONE else "Killed, or running on another machine"
    text = {
        State.FAILED: f"Failed after {until}: {run.reason.rstrip('.')}.",
        State.STOPPED: f"Stopped after {until}: {run.reason.rstrip('.')}.",
        State.KILLED: f"{where}: {until}, no summary.json, no new row for {quiet}, "
                      "and none of its processes is here.",
        State.SILENT: f"Killed, or in a step that takes long: {until}, no summary.json and no new row for "
                      f"{quiet}.",
    }[state]
    step = run.checkpoint()
    if step is not None:
        text += f" It can go on from step {step}: scripts/run SCENE --restart {run.folder} --output NEW."
    yield Statement("bad" if state is not State.STOPPED else "note", "end", text)


def _convergence(run: Run) -> Iterator[Statement]:
    steps = run.account
    if not steps.count:
        return
    if set(steps.statuses) == {""}:  # no coupler: a step that does not converge is not accepted
        mean = steps.newton_iterations / steps.count
        yield Statement("good", "convergence",
                        f"Every step converged: {mean:.3g} Newton iterations each, {steps.most_newton} at most.")
        return
    bad = steps.first_unconverged
    if bad is not None:
        words = ", ".join(f"{number} {status.replace('_', ' ')}" for status, number in steps.statuses.items()
                          if status not in FINE)
        number = steps.count - sum(steps.statuses[status] for status in FINE)
        many = count(number, "step was", "steps were")
        yield Statement("bad", "convergence", f"{many} accepted without convergence ({words}), the first is step "
                        f"{bad['step']} at t = {float(bad['time']):.6g} s.")
        return
    if not steps.in_contact:
        yield Statement("good", "convergence", "No contact so far: each step took one coupling iteration.")
    elif steps.statuses["explicit"]:
        many = count(steps.statuses["explicit"], "step")
        yield Statement("note", "convergence", f"Explicit: {many} in contact in one coupling iteration each; without "
                        "iteration the agreement of soil and structure is not checked.")
    else:
        mean = steps.iterations_in_contact / steps.in_contact
        yield Statement("good", "convergence",
                        f"Every step converged: {steps.in_contact} in contact with {mean:.3g} iterations each, "
                        f"{steps.most_iterations} at most; {steps.statuses['inactive']} without contact.")


def _cuts(run: Run) -> Iterator[Statement]:
    number, steps = run.num_cuts, run.account
    if not number:
        if steps.count:
            yield Statement("good", "cuts", "No step was cut.")
        return
    row = steps.first_cut
    first = f", first in step {row['step']} before t = {float(row['time']):.6g} s" if row else ""
    reasons = run.cuts.why()
    why = "; ".join(f"{times} × {reason}" for reason, times in reasons[:3])
    more = f"; {count(len(reasons) - 3, 'other reason')}" if len(reasons) > 3 else ""
    yield Statement("note", "cuts", f"{count(number, 'cut')} of the step size{first}"
                    + (f". Why: {why}{more}." if reasons else "."))


def _time(run: Run) -> Iterator[Statement]:
    steps = run.account
    total = sum(steps.wall)
    if not total:
        return
    median = statistics.median(steps.wall)
    text = f"A step took {seconds(total / steps.count)} on average, {seconds(median)} in the median."
    if steps.awaited:
        shares = {name: sum(part[k] for part in steps.parts) / total for k, name in enumerate(steps.awaited)}
        waits = ", ".join(f"{name} {percent(share)}" for name, share in sorted(shares.items(), key=lambda s: -s[1]))
        text += f" The coupler waited for: {waits}."
    slow = [k for k, wall in enumerate(steps.wall) if wall > SLOW * median]
    spent = sum(steps.wall[k] for k in slow)
    text += _slow_steps(run, slow, percent(spent / total)) if slow else " No step was slow."
    yield Statement("note" if spent > 0.05 * total else "good", "time", text)


def _slow_steps(run: Run, slow: list[int], share: str) -> str:
    """Statement on slow steps and the participant that was waited for. slow: their places in the rows."""
    steps = run.account
    worst = max(slow, key=steps.wall.__getitem__)
    text = (f" {count(len(slow), 'slow step')}, over {SLOW} times that, took {share} of the time; the slowest "
            f"is step {steps.numbers[worst]} with {seconds(steps.wall[worst])}")
    if not steps.awaited:
        return text + "."
    waits = [sum(steps.parts[k][p] for k in slow) for p in range(len(steps.awaited))]
    most = max(range(len(waits)), key=waits.__getitem__)
    part = waits[most] / sum(steps.wall[k] for k in slow)
    return f"{text}; {percent(part)} of that was for {steps.awaited[most]}."


def _judged(topic: str, share: float, text: str) -> Statement:
    kind = "good" if share < CLOSED else "note" if share < OPEN else "bad"
    return Statement(kind, topic, text)


def _soil(run: Run) -> Iterator[Statement]:
    """The energy and momentum balance of each soil (docs/theory/soil.md)."""
    ledger, unit = run.ledger, run.ledger.per_metre
    for prefix in ledger.owners("energy_balance"):
        name = prefix.rstrip(".") or "soil"
        around = ledger.size(prefix, "gravity_work", "boundary_work", "kinetic_energy", "elastic_energy")
        if around > 0:
            error = ledger.size(prefix, "energy_balance") / around
            made = max(ledger.size(prefix, "created_energy"), ledger.size(prefix, "contact_created")) / around
            closed = "closed" if max(error, made) < OPEN else "not closed"
            yield _judged("energy", max(error, made),
                          f"Energy of {name}: {closed}. Of the {around:.3g} J{unit} that were exchanged, "
                          f"{percent(error)} are missing and {percent(made)} were created.")
        axes = [axis for axis in "xyz" if f"{prefix}momentum_error_{axis}" in ledger.first]
        of_energy = math.sqrt(2 * ledger.size(prefix, "mass") * around)  # soil at rest has next to no momentum
        moved = max(ledger.size(prefix, *(f"momentum_{axis}" for axis in axes)), of_energy)
        if moved > 0:
            error = ledger.size(prefix, *(f"momentum_error_{axis}" for axis in axes)) / moved
            closed = "closed" if error < OPEN else "not closed"
            yield _judged("momentum", error, f"Momentum of {name}: {closed}. Missing: {percent(error)} of {moved:.3g} "
                          f"kg m/s{unit}, the largest momentum, or sqrt(2 m E) of the energy "
                          "exchanged.")


def _structures(run: Run) -> Iterator[Statement]:
    """Energy that a structure stores and dissipates against the work that came in: what is missing the time integration
    damped, more must not be."""
    ledger, unit = run.ledger, run.ledger.per_metre
    for prefix in ledger.owners("external_work"):
        at_start = sum(ledger.first.get(prefix + part, 0) for part in ("kinetic_energy", "elastic_energy"))
        around = max(at_start, ledger.size(prefix, "external_work"))
        if not around > 0:
            continue
        changed = {part: (ledger.last.get(prefix + part, 0) - ledger.first.get(prefix + part, 0)) / around
                   for part in ("external_work", "kinetic_energy", "elastic_energy", *SINKS)}
        gain = sum(changed.values()) - 2 * changed["external_work"]
        name = prefix.rstrip(".") or "structure"
        moves = ledger.size(prefix, "kinetic_energy") > 0
        cause = "by its time integration" if moves else "by loads that act at once in steps of statics"
        came_in = f"the {around:.3g} J{unit} that came in"
        word = f"has {percent(gain)} more than {came_in}"
        if gain <= 0:
            word = f"lost {percent(-gain)} of {came_in}, {cause}"
        word += "".join(f"; {sink} took {percent(changed[part])}" for part, sink in SINKS.items() if changed[part] > 0)
        if gain >= OPEN and ledger.size(prefix, "kinetic_energy") > around:
            word += "; waves that are shorter than the step ring in it"
        yield _judged("energy", max(gain, 0.0), f"Energy of {name}: it {word}.")
        made = -ledger.lowest.get(f"{prefix}damping_work", 0.0)
        if made > 1e-9 * around:
            yield Statement("bad", "energy", f"Damping of {name} created {made:.3g} J{unit}; it must only dissipate.")


def _interface(run: Run) -> Iterator[Statement]:
    steps = run.account
    if not steps.most_soil_work > 0:
        return
    share = steps.made_work / steps.most_soil_work
    word = "made" if share > 0 else "took"
    yield _judged("energy", abs(share), f"The coupling {word} {percent(abs(share))} of the work that it passed on.")
