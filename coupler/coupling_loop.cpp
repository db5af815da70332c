// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/coupling_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <gabion_version.hpp>

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

}  // namespace

CouplingLoop::CouplingLoop(const CouplerSettings& settings,
                           const std::vector<NamedSolver>& participants, RunRecord& files)
    : settings_(settings),
      acceleration_(make_acceleration(settings.coupling.acceleration)),
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
  predictor_.accept(0, accepted_x_);
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
  now.x = predictor_.predict(request.time + request.dt);
  for (;; ++request.iteration) {
    const Stopwatch watch;
    now.row.request = request;
    solve_soils(now);  // force = H^T MPM(H x)
    const bool contact = request.iteration > 0 || contact_possible(now);
    solve_structures(now, /*may_sleep=*/!contact);  // x_tilde = FEM(force)
    if (!contact || settings_.coupling.scheme == Scheme::explicit_) {
      now.status = contact ? "explicit" : "inactive";
      if (!contact) now.x = now.x_tilde;  // the force is the same for every x
      check_one_pass(now);
      log_iteration(now, watch);
      return now;
    }
    if (request.iteration == 0 && contact_.changed(soil_reports())) {
      acceleration_->reset();
      ++counts_.history_resets;
    }
    now.row.state = convergence_.check(now.x, now.x_tilde, now.force);
    const bool done = finished(now);
    log_iteration(now, watch);
    if (done) return now;
    const ScopedTimer timer(phases_, "acceleration");
    now.x = acceleration_->next(now.x, now.x_tilde);
    now.row.acceleration = acceleration_->counters();
  }
}

void CouplingLoop::solve_soils(Attempt& now) {
  const Stopwatch watch;
  now.force = Eigen::VectorXd::Zero(map_->size());
  now.soil_forces.clear();
  now.row.soil = {};
  now.row.soil_newton = 0;
  for (Side& soil : soils_) {
    const ScopedTimer timer(phases_, soil.name());
    const InterfaceValues displacement = map_->soil_displacement(soil.name(), now.x);
    InterfaceValues sent;
    soil.solve(now.row.request, displacement, sent);
    map_->add_soil_force(soil.name(), sent, now.force);
    const Resultant resultant = map_->soil_resultant(soil.name(), displacement, sent);
    now.row.soil.force += resultant.force;
    now.row.soil.moment += resultant.moment;
    now.row.soil_newton += soil.report().newton_iterations;
    now.soil_forces.push_back(std::move(sent));
  }
  now.row.structure = map_->structure_resultant(now.x, now.force);
  now.soil_newton += now.row.soil_newton;
  now.row.soil_seconds = watch.seconds();
}

void CouplingLoop::solve_structures(Attempt& now, bool may_sleep) {
  const Stopwatch watch;
  now.x_tilde = accepted_x_;
  now.row.structure_newton = 0;
  for (Side& structure : structures_) {
    if (may_sleep && structure.may_sleep) {
      structure.skip();
      continue;
    }
    const ScopedTimer timer(phases_, structure.name());
    InterfaceValues sent;
    structure.solve(now.row.request, map_->structure_values(structure.name(), now.force), sent);
    map_->put_structure_values(structure.name(), sent, now.x_tilde);
    now.row.structure_newton += structure.report().newton_iterations;
  }
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
  if (state.verdict == Verdict::going_on && iterations >= settings_.coupling.max_iterations) {
    state.verdict = Verdict::limit_reached;
  }
  if (state.verdict == Verdict::going_on) return false;
  now.status = name(state.verdict);
  if (state.verdict == Verdict::converged) return true;
  const std::string force =
      state.force_residual ? fmt::format("{:.3g}", *state.force_residual) : "none yet";
  const std::string text = fmt::format(
      "coupling {} after {} iterations: displacement residual {:.3g} m (allowed {:.3g}), force "
      "residual {} N (allowed {:.3g})",
      now.status, iterations, state.displacement_residual, state.displacement_limit, force,
      state.force_limit);
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
    for (const auto& [name, values] : map_->structure_values(structure.name(), now.force)) {
      const bool zero = std::all_of(values.begin(), values.end(), [](double f) { return f == 0; });
      structure.may_sleep = structure.may_sleep && zero;
    }
  }
  return probes;
}

void CouplingLoop::accept(const Attempt& now, int cuts, const Stopwatch& watch) {
  double proposed_dt = 0;
  const std::vector<double> probes = accept_sides(now, proposed_dt);
  if (now.skipped == "none" && settings_.coupling.scheme == Scheme::serial_implicit) {
    acceleration_->end_step(now.x, now.x_tilde);
  }
  accepted_x_ = now.x_tilde;
  contact_.accept(soil_reports());
  steps_.accept(proposed_dt);
  predictor_.accept(steps_.time(), accepted_x_);

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
  row.structure_work = structure_work_.accept(now.x_tilde, now.force);
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
  const bool implicit = coupling.scheme == Scheme::serial_implicit;
  result["program"] = files_.kind();
  result["version"] = version;
  result["end_time"] = steps_.time();
  result["steps"] = steps_.step() - 1;
  result["cuts"] = steps_.cuts();
  result["methods"] = {{"scheme", implicit ? "serial_implicit" : "explicit"},
                       {"acceleration", implicit ? coupling.acceleration.method : "none"},
                       {"predictor", coupling.predictor},
                       {"mapping", coupling.mapping.method}};
  result["mapping"] = map_->report();
  result["wall_seconds"] = phases_.seconds();
  result["wall_seconds"]["total"] = watch_.seconds();
  if (!participants_answer) return result;
  for (Side* side : sides()) result["participants"][side->name()] = side->solver().summary();
  return result;
}

}  // namespace gabion
