// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/coupling_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <gabion_version.hpp>

#include "common/base/log.hpp"
#include "common/run/repeated_failure.hpp"

namespace gabion {

namespace {

std::vector<std::string> names_of_interfaces(const CouplerSettings& settings) {
  std::vector<std::string> names;
  for (const auto& interface : settings.interfaces) names.push_back(interface.name);
  return names;
}

StepRequest request_of(const TimeSteps& steps) {
  return {.step = steps.step(), .iteration = 0, .time = steps.time(), .dt = steps.dt()};
}

}  // namespace

CouplingLoop::CouplingLoop(const CouplerSettings& settings,
                           const std::vector<NamedSolver>& participants, RunRecord& files,
                           RunKeeper* keeper)
    : settings_(settings),
      files_(files),
      sides_(settings_, participants, phases_),
      record_(files, sides_.map().dim(), names_of_interfaces(settings)),
      step_(settings_.coupling, sides_, record_, counts_, phases_),
      steps_(settings.time),
      checkpoints_(
          keeper, steps_, [this](StateVisitor& visitor) { visit_state(visitor); }, phases_),
      clock_(settings.output_interval),
      progress_(settings.time.end, files.writes()),
      soil_work_(sides_.soil_start_weights()),
      structure_work_(sides_.structure_start_weights()) {}

void CouplingLoop::run() {
  try {
    run_steps();
  } catch (const std::exception& error) {
    // Participants still answer when a step failed, but not when one of them is lost.
    const bool step_failed = dynamic_cast<const ConvergenceError*>(&error) != nullptr;
    Json failed = summary(step_failed);
    failed["completed"] = false;
    failed["reason"] = error.what();
    try {
      files_.write_json("summary.json", failed);
    } catch (const Error& no_summary) {
      log::error("{}", no_summary.what());  // what came first is the run's error
    }
    if (step_failed) write_output();
    balances_.report();
    throw;
  }
  balances_.report();
  Json done = summary(true);
  done["completed"] = true;
  files_.write_json("summary.json", done);
}

void CouplingLoop::run_steps() {
  sides_.tell_force_kinds();
  std::vector<std::string> probe_names;
  for (const Side* side : sides_.all()) {
    for (const auto& name : side->solver().probe_names()) {
      probe_names.push_back(side->name() + "." + name);
    }
  }
  record_.start(probe_names);
  balances_.start(probe_names);
  if (checkpoints_.go_on()) {
    clock_.due(steps_.time());  // what is due here was written by the run that is continued
  } else {
    start();
  }
  while (!steps_.finished()) {
    advance();
    checkpoints_.after_step();
  }
  write_output();
  checkpoints_.at_end();
}

/// Start at time 0: interfaces are where the structures begin.
void CouplingLoop::start() {
  sides_.tell_start();
  soil_work_.start(sides_.map().soil_displacement(sides_.accepted_x()));
  structure_work_.start(sides_.accepted_x());
  std::vector<double> probes;
  for (const Side* side : sides_.all()) {
    const std::vector<double> values = side->solver().probes();
    probes.insert(probes.end(), values.begin(), values.end());
  }
  record_.probes(0, probes);
  balances_.add(probes);
  step_.start_at_rest();
  if (clock_.due(0)) write_output();
}

void CouplingLoop::advance() {
  const Stopwatch watch;
  const int cuts_before = steps_.cuts();
  sides_.begin_step();
  for (;;) {
    const Attempt attempt = step_.solve(request_of(steps_));
    if (attempt.acceptable()) return accept(attempt, steps_.cuts() - cuts_before, watch);
    reject(attempt);
  }
}

void CouplingLoop::accept(const Attempt& done, int cuts, const Stopwatch& watch) {
  const Stopwatch accepting;
  sides_.start_accept(done);
  step_.accept(done, steps_.after(0).time());
  sides_.renew_map();
  const AcceptReport structures = sides_.finish_structures_accept(done, accepting);
  const Stopwatch waiting;
  const bool other_facets = sides_.take_facets();
  if (!other_facets) start_next(done, structures.proposed_dt);
  AcceptReport both = sides_.finish_soils_accept(done, waiting);
  soils_dt_ = both.proposed_dt;
  if (other_facets) {
    sides_.tell_facets();
    step_.forget(steps_.after(0).time(), done);
  }
  steps_.accept(allowed_dt(done, smaller_dt(soils_dt_, structures.proposed_dt)));
  step_.settle_next(request_of(steps_));
  both.probes.insert(both.probes.end(), structures.probes.begin(), structures.probes.end());
  record_step(done, cuts, watch);
  record_.probes(steps_.time(), both.probes);
  balances_.add_cuts(cuts);
  balances_.add(both.probes);
  progress_.update(done.request.step, steps_.time(), done.request.dt, done.iterations());
  if (clock_.due(steps_.time())) write_output();
}

/// Start the soils' first solution of the next step while they still accept this one. Skipped where
/// output, a checkpoint or the end of the run comes first, or where a structure has not accepted
/// yet.
void CouplingLoop::start_next(const Attempt& done, double structures_dt) {
  const double others_dt = allowed_dt(done, structures_dt);
  const double likely_dt = smaller_dt(soils_dt_, others_dt);
  const TimeSteps next = steps_.after(likely_dt);
  if (next.finished() || clock_.is_due(next.time()) || checkpoints_.is_likely()) return;
  if (!sides_.take_next_step()) return;
  DtRange proposed = steps_.same_next(likely_dt);
  if (proposed.contains(others_dt)) proposed.below.reset();  // the soils did not propose it
  step_.start_next(request_of(next), proposed);
}

/// Step size that the solvers propose, reduced where the coupling needed many iterations
/// (docs/theory/coupling.md).
double CouplingLoop::allowed_dt(const Attempt& done, double proposed_dt) const {
  const DtByIterations& control = settings_.coupling.step_control;
  const bool halve = control.many > 0 && done.iterations() >= control.many;
  const bool hold = control.few > 0 && done.iterations() > control.few;
  if (!halve && !hold) return proposed_dt;
  const double dt = halve ? done.request.dt / 2 : done.request.dt;
  return smaller_dt(proposed_dt, dt);
}

void CouplingLoop::record_step(const Attempt& done, int cuts, const Stopwatch& watch) {
  StepRow row{.last = done.row,
              .time = steps_.time(),
              .iterations = done.iterations(),
              .status = status(done),
              .skipped = done.skipped,
              .soil_newton = done.soil_newton,
              .structure_newton = done.structure_newton,
              .interfaces = sides_.map().structure_resultants(done.x, done.f),
              .soil_work = soil_work_.accept(done.u, -done.f_soil),
              .structure_work = structure_work_.accept(done.x_tilde, done.f_given),
              .cuts = cuts,
              .acceleration_seconds = step_.take_acceleration_seconds(),
              .wall_seconds = watch.seconds()};
  for (const Side* side : sides_.all()) side->add_details(row.wall_seconds, row.details);
  record_.step(row);
  balances_.add_work(row.soil_work, row.soil_work + row.structure_work);
  counts_.add_step(row.iterations, row.skipped);
}

void CouplingLoop::reject(const Attempt& failed) {
  sides_.reject();
  step_.reject();
  const StepRequest& request = failed.request;
  if (settings_.coupling.on_limit == OnLimit::stop && failed.outcome != Outcome::unsolved) {
    throw ConvergenceError(fmt::format("step {} at time {} s, dt {} s: {} (on_limit is \"stop\")",
                                       request.step, request.time, request.dt, failed.reason));
  }
  if (failed.at_any_dt) throw ConvergenceError(failed.reason, fails_at_any_dt);
  steps_.cut(failed.reason);
  log::warn("step {} at {} s: dt cut from {} to {} s: {}", request.step, request.time, request.dt,
            steps_.dt(), failed.reason);
}

void CouplingLoop::write_output() {
  if (written_ == steps_.time()) return;
  const ScopedTimer timer(phases_, "output");
  for (const Side* side : sides_.all()) side->solver().write_output(steps_.time());
  written_ = steps_.time();
}

void CouplingLoop::visit_state(StateVisitor& visitor) {
  step_.call_off_next();  // states are those between two steps
  sides_.visit_state(visitor);
  step_.visit_state(visitor);
  steps_.visit_state(visitor);
  record_.visit_state(visitor);
  soil_work_.visit_state(visitor, "soil_work.");
  structure_work_.visit_state(visitor, "structure_work.");
}

Json CouplingLoop::summary(bool participants_answer) {
  Json result = counts_.json();
  const CouplingSettings& coupling = settings_.coupling;
  const bool implicit = coupling.scheme != Scheme::explicit_;
  result["program"] = files_.kind();
  result["version"] = version;
  result["end_time"] = steps_.time();
  result.update(checkpoints_.summary());
  result["cuts"] = steps_.cuts();
  result["methods"] = {{"scheme", name(coupling.scheme)},
                       {"acceleration", implicit ? coupling.acceleration.method : "none"},
                       {"predictor", coupling.predictor},
                       {"mapping", coupling.mapping.method}};
  result["mapping"] = sides_.map().report();
  result["wall_seconds"] = phases_.seconds();
  result["wall_seconds"]["total"] = watch_.seconds();
  for (const Side* side : sides_.all()) result["messages"][side->name()] = side->calls();
  if (!participants_answer) return result;
  for (const Side* side : sides_.all())
    result["participants"][side->name()] = side->solver().summary();
  return result;
}

}  // namespace gabion
