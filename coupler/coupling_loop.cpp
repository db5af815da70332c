// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/coupling_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <gabion_version.hpp>
#include <utility>

#include "common/base/log.hpp"

namespace gabion {

namespace {

Solver& find_solver(const std::vector<NamedSolver>& participants, const std::string& name) {
  const auto found = std::find_if(participants.begin(), participants.end(),
                                  [&](const NamedSolver& p) { return p.name == name; });
  require<ConfigError>(found != participants.end(),
                       fmt::format("participant \"{}\" of coupler.json is not there", name));
  return found->solver;
}

std::string number_or(const std::optional<double>& value, const std::string& text) {
  return value ? fmt::format("{:.3g}", *value) : text;
}

/// Take the answers of all these sides, also when one of them failed: nothing may be left under way
/// when the step is rejected.
/// @throws ConvergenceError  the first failure
void finish_all(const std::vector<Side*>& sides, const std::function<void(Side&)>& finish) {
  std::exception_ptr failure;
  for (Side* side : sides) {
    try {
      finish(*side);
    } catch (const ConvergenceError&) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

CouplingLoop::CouplingLoop(const CouplerSettings& settings,
                           const std::vector<NamedSolver>& participants, RunRecord& files)
    : settings_(settings),
      predictor_(settings.coupling.predictor),
      convergence_(settings.coupling.convergence),
      steps_(settings.time),
      clock_(settings.output_interval),
      progress_(settings.time.end, files.writes()),
      files_(files) {
  std::map<std::string, std::vector<InterfaceMesh>> meshes;
  for (const ParticipantRole& entry : settings_.participants) {
    Solver& solver = find_solver(participants, entry.name);
    meshes[entry.name] = solver.interfaces();
    (entry.sends_force ? soils_ : structures_).emplace_back(entry.name, solver);
  }
  map_ = std::make_unique<InterfaceMap>(settings_.interfaces, meshes, settings_.coupling.mapping);
  record_ = std::make_unique<CouplingRecord>(files_, map_->dim());
  accepted_x_ = Eigen::VectorXd::Zero(map_->size());
  std::vector<Eigen::Index> fields = {map_->size()};
  if (settings_.coupling.scheme == Scheme::parallel_implicit) fields.push_back(map_->size());
  acceleration_ = make_acceleration(settings_.coupling.acceleration, fields);
}

void CouplingLoop::run() {
  try {
    run_steps();
  } catch (const std::exception& error) {
    // Participants still answer when a step failed, but not when one of them is lost.
    const bool step_failed = dynamic_cast<const ConvergenceError*>(&error) != nullptr;
    Json failed = summary(step_failed);
    failed["completed"] = false;
    failed["reason"] = error.what();
    files_.write_json("summary.json", failed);
    if (step_failed) write_output();
    throw;
  }
  Json done = summary(true);
  done["completed"] = true;
  files_.write_json("summary.json", done);
}

void CouplingLoop::run_steps() {
  std::vector<std::string> probe_names;
  std::vector<double> probes;
  for (Side* side : sides()) {
    for (const auto& name : side->solver().probe_names()) {
      probe_names.push_back(side->name() + "." + name);
    }
    const std::vector<double> values = side->solver().probes();
    probes.insert(probes.end(), values.begin(), values.end());
  }
  record_->start(probe_names);
  record_->probes(0, probes);
  predictor_.accept(0, stacked(accepted_x_, accepted_x_));  // no displacement, no force
  if (clock_.due(0)) write_output();
  while (!steps_.finished()) advance();
  write_output();
}

void CouplingLoop::advance() {
  const Stopwatch watch;
  const int cuts_before = steps_.cuts();
  for (Side* side : sides()) side->begin_step();
  for (;;) {
    const Attempt attempt = try_step({steps_.step(), 0, steps_.time(), steps_.dt()});
    if (attempt.failure.empty()) return accept(attempt, steps_.cuts() - cuts_before, watch);
    reject(attempt);
  }
}

CouplingLoop::Attempt CouplingLoop::try_step(const StepRequest& request) {
  try {
    return iterate(request);
  } catch (const ConvergenceError& error) {
    Attempt failed;
    failed.row.request = request;
    failed.failure = error.what();
    failed.solver_failed = true;
    return failed;
  }
}

/// The method: x is the displacement of the structures' wet surfaces.
CouplingLoop::Attempt CouplingLoop::iterate(StepRequest request) {
  Attempt now;
  for (Side* side : sides()) side->begin_solution();
  acceleration_->begin_step();
  convergence_.begin_step();
  now.row.request = request;
  predict(now);
  const bool parallel = settings_.coupling.scheme == Scheme::parallel_implicit;
  for (;; ++now.row.request.iteration) {
    const Stopwatch watch;
    const bool contact = parallel ? solve_parallel(now) : solve_serial(now);
    if (!contact || settings_.coupling.scheme == Scheme::explicit_) {
      now.status = contact ? "explicit" : "inactive";
      if (!contact) now.x = now.x_tilde;  // the force is the same for every x
      check_one_pass(now);
      log_iteration(now, watch);
      return now;
    }
    if (now.row.request.iteration == 0 && contact_.changed(soil_reports())) {
      forgotten_columns_ = acceleration_->reset();
      ++counts_.history_resets;
    }
    now.row.state = parallel ? convergence_.check(now.x, now.x_tilde, now.force_given, now.force)
                             : convergence_.check(now.x, now.x_tilde, now.force);
    const bool done = finished(now);
    log_iteration(now, watch);
    if (done) return now;
    accelerate(now);
  }
}

/// What the scheme iterates on: the displacement, and the force too where both sides work at once.
Eigen::VectorXd CouplingLoop::stacked(const Eigen::VectorXd& displacement,
                                      const Eigen::VectorXd& force) const {
  if (settings_.coupling.scheme != Scheme::parallel_implicit) return displacement;
  Eigen::VectorXd result(displacement.size() + force.size());
  result << displacement, force;
  return result;
}

void CouplingLoop::predict(Attempt& now) const {
  const StepRequest& request = now.row.request;
  const Eigen::VectorXd state = predictor_.predict(request.time + request.dt);
  now.x = state.head(map_->size());
  now.force_given = state.tail(map_->size());  // serial: replaced by what the soils answer
}

void CouplingLoop::accelerate(Attempt& now) {
  const ScopedTimer timer(phases_, "acceleration");
  const Stopwatch watch;
  const Eigen::VectorXd next =
      acceleration_->next(stacked(now.x, now.force_given), stacked(now.x_tilde, now.force));
  now.x = next.head(map_->size());
  now.force_given = next.tail(map_->size());
  acceleration_seconds_ += watch.seconds();
  now.row.acceleration = acceleration_->counters();
  now.row.acceleration.dropped_by_contact = std::exchange(forgotten_columns_, 0);
  if (!now.row.acceleration.fell_back) return;
  ++counts_.filter_fallbacks;
  log::warn(
      "step {} iteration {}: with the filter of coupler.json the residual does not get "
      "smaller; from here on the default one is used, qr2 with {}",
      now.row.request.step, now.row.request.iteration, Filter().limit);
}

/// @returns whether the soils may answer another force to another x
bool CouplingLoop::solve_serial(Attempt& now) {
  solve_soils(now);  // force = H^T MPM(H x)
  now.force_given = now.force;
  const bool contact = now.row.request.iteration > 0 || contact_possible(now);
  solve_structures(now, /*may_sleep=*/!contact);  // x_tilde = FEM(force)
  return contact;
}

bool CouplingLoop::solve_parallel(Attempt& now) {
  const Stopwatch watch;
  const bool no_load = now.force_given.isZero(0);
  start_soils(now);
  const std::vector<Side*> structures = start_structures(now, /*may_sleep=*/no_load);
  std::exception_ptr failure;
  try {
    finish_soils(now, watch);
  } catch (const ConvergenceError&) {
    failure = std::current_exception();
  }
  finish_structures(now, structures, watch);
  if (failure) std::rethrow_exception(failure);
  const bool contact = now.row.request.iteration > 0 || contact_possible(now);
  if (!contact && !no_load) {  // a force was predicted, and there is none
    now.force_given = now.force;
    solve_structures(now, /*may_sleep=*/true);
  }
  return contact;
}

void CouplingLoop::solve_soils(Attempt& now) {
  const Stopwatch watch;
  start_soils(now);
  finish_soils(now, watch);
}

void CouplingLoop::solve_structures(Attempt& now, bool may_sleep) {
  const Stopwatch watch;
  finish_structures(now, start_structures(now, may_sleep), watch);
}

void CouplingLoop::start_soils(const Attempt& now) {
  for (Side& soil : soils_) {
    soil.start_solve(now.row.request, map_->soil_displacement(soil.name(), now.x));
  }
}

void CouplingLoop::finish_soils(Attempt& now, const Stopwatch& watch) {
  now.force = Eigen::VectorXd::Zero(map_->size());
  now.soil_forces.clear();
  now.row.soil = {};
  now.row.soil_newton = 0;
  std::vector<Side*> soils;
  for (Side& soil : soils_) soils.push_back(&soil);
  finish_all(soils, [&](Side& soil) {
    const ScopedTimer timer(phases_, soil.name());
    InterfaceValues sent;
    soil.finish_solve(sent);
    map_->add_soil_force(soil.name(), sent, now.force);
    const Resultant resultant =
        map_->soil_resultant(soil.name(), map_->soil_displacement(soil.name(), now.x), sent);
    now.row.soil.force += resultant.force;
    now.row.soil.moment += resultant.moment;
    now.row.soil_newton += soil.report().newton_iterations;
    now.soil_forces.push_back(std::move(sent));
  });
  now.row.structure = map_->structure_resultant(now.x, now.force);
  now.soil_newton += now.row.soil_newton;
  now.row.soil_seconds = watch.seconds();
}

std::vector<Side*> CouplingLoop::start_structures(Attempt& now, bool may_sleep) {
  now.x_tilde = accepted_x_;
  std::vector<Side*> started;
  for (Side& structure : structures_) {
    if (may_sleep && structure.may_sleep) {
      structure.skip();
      continue;
    }
    structure.start_solve(now.row.request,
                          map_->structure_values(structure.name(), now.force_given));
    started.push_back(&structure);
  }
  return started;
}

void CouplingLoop::finish_structures(Attempt& now, const std::vector<Side*>& started,
                                     const Stopwatch& watch) {
  now.row.structure_newton = 0;
  finish_all(started, [&](Side& structure) {
    const ScopedTimer timer(phases_, structure.name());
    InterfaceValues sent;
    structure.finish_solve(sent);
    map_->put_structure_values(structure.name(), sent, now.x_tilde);
    now.row.structure_newton += structure.report().newton_iterations;
  });
  now.structure_newton += now.row.structure_newton;
  now.row.structure_seconds = watch.seconds();
}

bool CouplingLoop::contact_possible(const Attempt& now) const {
  const bool active = std::any_of(soils_.begin(), soils_.end(),
                                  [](const Side& soil) { return soil.report().interface_active; });
  require(active || now.force.isZero(0),
          fmt::format("step {}: the soil sends a force (largest component {} N) and says that its "
                      "interfaces are not active",
                      now.row.request.step, now.force.cwiseAbs().maxCoeff()));
  return active;
}

void CouplingLoop::check_one_pass(Attempt& now) const {
  now.row.state = Convergence::one_pass(now.x, now.x_tilde, now.force);
  if (now.row.state.verdict == Verdict::not_finite) now.failure = "values are not finite";
  if (now.status != "inactive") return;
  const bool slept = std::any_of(structures_.begin(), structures_.end(),
                                 [](const Side& structure) { return !structure.solved(); });
  now.skipped = slept ? "structure" : "acceleration";
}

bool CouplingLoop::finished(Attempt& now) {
  ConvergenceState& state = now.row.state;
  const int iterations = now.row.request.iteration + 1;
  const bool all_solved = std::all_of(structures_.begin(), structures_.end(),
                                      [](const Side& structure) { return structure.solved(); });
  if (state.verdict == Verdict::converged && !all_solved) state.verdict = Verdict::going_on;
  if (state.verdict != Verdict::converged) warn_of_round_off(state);
  if (state.verdict == Verdict::going_on && iterations >= settings_.coupling.max_iterations) {
    state.verdict = Verdict::limit_reached;
  }
  if (state.verdict == Verdict::going_on) return false;
  now.status = name(state.verdict);
  if (state.verdict == Verdict::converged) return true;
  std::string text = fmt::format(
      "coupling {} after {} iterations: displacement residual {:.3g} m (allowed {}), force "
      "residual {} N (allowed {})",
      now.status, iterations, state.displacement_residual,
      number_or(state.displacement_limit, "any"), number_or(state.force_residual, "none yet"),
      number_or(state.force_limit, "any"));
  if (!state.below_round_off.empty()) {
    text += fmt::format("; the limit of the {} is below the round-off of its values",
                        state.below_round_off);
  }
  const bool usable =
      state.verdict == Verdict::limit_reached || state.verdict == Verdict::stagnated;
  if (settings_.coupling.on_limit == OnLimit::accept && usable) {
    log::warn("step {} accepted all the same: {}", now.row.request.step, text);
    ++counts_.accepted_unconverged;
  } else {
    now.failure = text;
  }
  return true;
}

void CouplingLoop::warn_of_round_off(const ConvergenceState& state) {
  if (warned_round_off_ || state.below_round_off.empty()) return;
  warned_round_off_ = true;
  log::warn(
      "coupling/convergence: the limit of the {} is below the round-off of its values; "
      "iterations will stagnate",
      state.below_round_off);
}

void CouplingLoop::log_iteration(Attempt& now, const Stopwatch& watch) {
  now.row.wall_seconds = watch.seconds();
  record_->iteration(now.row);
  log::debug("step {} iteration {}: displacement residual {:.3e} m, force residual {:.3e} N, {}",
             now.row.request.step, now.row.request.iteration, now.row.state.displacement_residual,
             now.row.state.force_residual.value_or(0), name(now.row.state.verdict));
  ++counts_.total;
}

std::vector<double> CouplingLoop::accept_sides(const Attempt& now, double& proposed_dt) {
  const ScopedTimer timer(phases_, "accept");
  std::vector<double> probes;
  for (Side* side : sides()) {
    const AcceptReport report = side->accept(now.row.request);
    probes.insert(probes.end(), report.probes.begin(), report.probes.end());
    if (report.proposed_dt > 0) {
      proposed_dt =
          proposed_dt > 0 ? std::min(proposed_dt, report.proposed_dt) : report.proposed_dt;
    }
    side->may_sleep = report.at_rest;
  }
  for (Side& structure : structures_) {
    for (const auto& [name, values] : map_->structure_values(structure.name(), now.force_given)) {
      const bool zero = std::all_of(values.begin(), values.end(), [](double f) { return f == 0; });
      structure.may_sleep = structure.may_sleep && zero;
    }
  }
  return probes;
}

void CouplingLoop::accept(const Attempt& now, int cuts, const Stopwatch& watch) {
  double proposed_dt = 0;
  const std::vector<double> probes = accept_sides(now, proposed_dt);
  if (now.skipped == "none" && settings_.coupling.scheme != Scheme::explicit_) {
    const Stopwatch acceleration;
    acceleration_->end_step(stacked(now.x, now.force_given), stacked(now.x_tilde, now.force));
    acceleration_seconds_ += acceleration.seconds();
  }
  accepted_x_ = now.x_tilde;
  contact_.accept(soil_reports());
  steps_.accept(allowed_dt(now, proposed_dt));
  predictor_.accept(steps_.time(), stacked(accepted_x_, now.force));

  StepRow row;
  row.last = now.row;
  row.time = steps_.time();
  row.iterations = now.row.request.iteration + 1;
  row.status = now.status;
  row.skipped = now.skipped;
  row.soil_newton = now.soil_newton;
  row.structure_newton = now.structure_newton;
  row.cuts = cuts;
  add_work(now, row);
  row.acceleration_seconds = std::exchange(acceleration_seconds_, 0);
  row.wall_seconds = watch.seconds();
  for (const Side* side : sides()) side->add_details(row.wall_seconds, row.details);
  record_->step(row);
  record_->probes(row.time, probes);
  counts_.add_step(row.iterations, now.skipped == "none");
  if (now.skipped != "none") ++counts_.skipped_acceleration;
  if (now.skipped == "structure") ++counts_.skipped_structure;
  progress_.update(now.row.request.step, row.time, now.row.request.dt, row.iterations);
  if (clock_.due(row.time)) write_output();
}

/// The solvers' wish, made smaller where the coupling needed many iterations (README section 3).
double CouplingLoop::allowed_dt(const Attempt& now, double proposed_dt) const {
  const StepControl& control = settings_.coupling.step_control;
  const int iterations = now.row.request.iteration + 1;
  const bool halve = control.many > 0 && iterations >= control.many;
  const bool hold = control.few > 0 && iterations > control.few;
  if (!halve && !hold) return proposed_dt;
  const double dt = halve ? now.row.request.dt / 2 : now.row.request.dt;
  return proposed_dt > 0 ? std::min(proposed_dt, dt) : dt;
}

void CouplingLoop::add_work(const Attempt& now, StepRow& row) {
  std::vector<double> u, f;
  for (std::size_t k = 0; k < soils_.size(); ++k) {
    for (const auto& [name, values] : map_->soil_displacement(soils_[k].name(), now.x)) {
      const std::vector<double>& force = now.soil_forces[k].at(name);
      u.insert(u.end(), values.begin(), values.end());
      f.insert(f.end(), force.begin(), force.end());
    }
  }
  const auto size = static_cast<Eigen::Index>(u.size());
  const Eigen::Map<const Eigen::VectorXd> soil_u(u.data(), size), soil_f(f.data(), size);
  row.soil_work = soil_work_.accept(soil_u, -soil_f);
  row.structure_work = structure_work_.accept(now.x_tilde, now.force_given);
}

void CouplingLoop::reject(const Attempt& now) {
  for (Side* side : sides()) side->reject();
  acceleration_->discard_step();
  const StepRequest& request = now.row.request;
  if (settings_.coupling.on_limit == OnLimit::stop && !now.solver_failed) {
    throw ConvergenceError(fmt::format("step {} at time {} s, dt {} s: {} (on_limit is \"stop\")",
                                       request.step, request.time, request.dt, now.failure));
  }
  steps_.cut(now.failure);
  log::warn("step {} at {} s: dt cut from {} to {} s: {}", request.step, request.time, request.dt,
            steps_.dt(), now.failure);
}

void CouplingLoop::write_output() {
  if (written_ == steps_.time()) return;
  const ScopedTimer timer(phases_, "output");
  for (Side* side : sides()) side->solver().write_output(steps_.time());
  written_ = steps_.time();
}

std::vector<Side*> CouplingLoop::sides() {
  std::vector<Side*> all;
  for (Side& soil : soils_) all.push_back(&soil);
  for (Side& structure : structures_) all.push_back(&structure);
  return all;
}

std::vector<StepReport> CouplingLoop::soil_reports() const {
  std::vector<StepReport> reports;
  for (const Side& soil : soils_) reports.push_back(soil.report());
  return reports;
}

Json CouplingLoop::summary(bool participants_answer) {
  Json result = counts_.json();
  const CouplingSettings& coupling = settings_.coupling;
  const bool implicit = coupling.scheme != Scheme::explicit_;
  result["program"] = files_.kind();
  result["version"] = version;
  result["end_time"] = steps_.time();
  result["steps"] = steps_.step() - 1;
  result["cuts"] = steps_.cuts();
  result["methods"] = {{"scheme", name(coupling.scheme)},
                       {"acceleration", implicit ? coupling.acceleration.method : "none"},
                       {"predictor", coupling.predictor},
                       {"mapping", coupling.mapping.method}};
  result["wall_seconds"] = phases_.seconds();
  result["wall_seconds"]["total"] = watch_.seconds();
  if (!participants_answer) return result;
  for (Side* side : sides()) result["participants"][side->name()] = side->solver().summary();
  return result;
}

}  // namespace gabion
