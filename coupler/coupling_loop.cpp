// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/coupling_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <gabion_version.hpp>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/settings/scene.hpp"

namespace gabion {

namespace {

Solver& find_solver(const std::vector<NamedSolver>& participants, const std::string& name) {
  const auto found = std::find_if(participants.begin(), participants.end(),
                                  [&](const NamedSolver& p) { return p.name == name; });
  require<ConfigError>(found != participants.end(),
                       "participant \"{}\" of coupler.json is not there", name);
  return found->solver;
}

template <class Value>
std::string bytes_of(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

}  // namespace

CouplingLoop::CouplingLoop(const CouplerSettings& settings,
                           const std::vector<NamedSolver>& participants, RunRecord& files,
                           RunKeeper* keeper)
    : settings_(settings),
      predictor_(settings.coupling.predictor),
      convergence_(settings.coupling.convergence),
      steps_(settings.time),
      checkpoints_(
          keeper, steps_, [this](StateVisitor& visitor) { visit_state(visitor); }, phases_),
      clock_(settings.output_interval),
      progress_(settings.time.end, files.writes()),
      files_(files) {
  std::map<std::string, std::vector<InterfaceMesh>> meshes;
  for (const ParticipantRole& entry : settings_.participants) {
    Solver& solver = find_solver(participants, entry.name);
    meshes[entry.name] = solver.interfaces();
    for (const InterfaceMesh& mesh : meshes[entry.name]) {
      surfaces_[entry.name][mesh.name] =
          hash_text(bytes_of(mesh.coordinates) + bytes_of(mesh.facets));
    }
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
  if (checkpoints_.go_on()) {
    clock_.due(steps_.time());  // what is due here was written by the run that is continued
  } else {
    record_->probes(0, probes);
    predictor_.accept(0, stacked(accepted_x_, accepted_x_));  // no displacement, no force
    if (clock_.due(0)) write_output();
  }
  while (!steps_.finished()) {
    advance();
    checkpoints_.after_step();
  }
  write_output();
  checkpoints_.at_end();
}

/// A foreign code does not read the scene, so its surface may be another one than it was.
void CouplingLoop::visit_surfaces(StateVisitor& visitor) const {
  Json saved = surfaces_;
  visitor.fact("surfaces", saved);
  for (const auto& participant : surfaces_.items()) {
    const Json before = saved.value(participant.key(), Json::object());
    for (const auto& surface : participant.value().items()) {
      require<ConfigError>(
          before.value(surface.key(), "") == surface.value(),
          "participant \"{}\": found another mesh of interface \"{}\", allowed: that "
          "of the run that is continued",
          participant.key(), surface.key());
    }
  }
}

void CouplingLoop::visit_state(StateVisitor& visitor) {
  visit_surfaces(visitor);
  steps_.visit_state(visitor);
  record_->visit_state(visitor);
  acceleration_->visit_state(visitor);
  predictor_.visit_state(visitor);
  contact_.visit_state(visitor);
  map_->visit_state(visitor);
  visit_vector(visitor, "accepted_x", accepted_x_);
  visitor.integer("forgotten_columns", forgotten_columns_);
  soil_work_.visit_state(visitor, "soil_work.");
  structure_work_.visit_state(visitor, "structure_work.");
  for (Side* side : sides()) visitor.flag("may_sleep." + side->name(), side->may_sleep);
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
  map_->accept(accepted_x_);
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
  result.update(checkpoints_.summary());
  result["cuts"] = steps_.cuts();
  result["methods"] = {{"scheme", name(coupling.scheme)},
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
