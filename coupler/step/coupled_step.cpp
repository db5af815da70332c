// SPDX-License-Identifier: BSD-3-Clause
// One try to solve a step: the iterations of CouplingLoop.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "coupler/coupling_loop.hpp"

namespace gabion {

namespace {

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

void CouplingLoop::start_soils(Attempt& now) {
  for (Side& soil : soils_) {
    InterfaceValues& given = now.soil_displacement[soil.name()];
    given = map_->soil_displacement(soil.name(), now.x);
    soil.start_solve(now.row.request, given);
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
        map_->soil_resultant(soil.name(), now.soil_displacement.at(soil.name()), sent);
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
          "step {}: the soil sends a force (largest component {} N) and says that its "
          "interfaces are not active",
          now.row.request.step, now.force.cwiseAbs().maxCoeff());
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

}  // namespace gabion
