// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/coupled_step.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/log.hpp"
#include "common/run/repeated_failure.hpp"

namespace gabion {

namespace {

std::string number_or(const std::optional<double>& value, const std::string& text) {
  return value ? fmt::format("{:.3g}", *value) : text;
}

/// Reason why a step has ended without convergence.
std::string failure_text(const Attempt& now) {
  const ConvergenceState& state = now.row.state;
  std::string text = fmt::format(
      "coupling {} after {} iterations: displacement residual {:.3g} m (allowed {}), force "
      "residual {} N (allowed {})",
      name(state.verdict), now.iterations(), state.displacement_residual,
      number_or(state.displacement_limit, "any"), number_or(state.force_residual, "none yet"),
      number_or(state.force_limit, "any"));
  if (!state.below_round_off.empty()) {
    text += fmt::format("; the limit of the {} is below the round-off of its values",
                        state.below_round_off);
  }
  return text;
}

}  // namespace

CoupledStep::CoupledStep(const CouplingSettings& settings, Sides& sides, CouplingRecord& record,
                         CouplingCounts& counts, PhaseTimes& phases)
    : settings_(settings),
      sides_(sides),
      record_(record),
      counts_(counts),
      phases_(phases),
      scheme_(make_scheme(settings.scheme)),
      acceleration_(make_acceleration(settings.acceleration, scheme_->fields(sides.map().size()))),
      predictor_(settings.predictor),
      convergence_(settings.convergence) {}

Attempt CoupledStep::solve(const StepRequest& request) {
  try {
    return iterate(request);
  } catch (const ConvergenceError& error) {
    return {.request = request,
            .outcome = Outcome::unsolved,
            .reason = error.what(),
            .at_any_dt = error.cause() == fails_at_any_dt};
  }
}

/// The coupling iterations of one step.
Attempt CoupledStep::iterate(const StepRequest& request) {
  Attempt now = begin(request);
  for (;; ++now.request.iteration) {
    const Stopwatch watch;
    const bool contact = scheme_->solve(sides_, now);  // f = H^T MPM(H x), x_tilde = FEM(f)
    if (contact && scheme_->repeats()) {
      measure(now);
    } else {
      accept_one_pass(contact, now);
    }
    log_iteration(now, watch);
    if (now.outcome != Outcome::iterating) return now;
    accelerate(now);
  }
}

Attempt CoupledStep::begin(const StepRequest& request) {
  sides_.begin_solution();
  acceleration_->begin_step();
  convergence_.begin_step();
  if (next_) return *std::exchange(next_, std::nullopt);
  return predict(request);
}

Attempt CoupledStep::predict(const StepRequest& request) const {
  Attempt now{.request = request};
  scheme_->set_guess(predictor_.predict(request.time + request.dt), now);
  return now;
}

/// Accept one pass without a residual: the scheme is explicit, or without contact the force does
/// not depend on x.
void CoupledStep::accept_one_pass(bool contact, Attempt& now) {
  now.outcome = contact ? Outcome::one_pass : Outcome::no_contact;
  if (!contact) {
    now.x = now.x_tilde;
    now.u = sides_.map().soil_displacement(now.x);
    now.skipped = sides_.all_structures_solved() ? Skipped::acceleration : Skipped::structure;
  }
  now.row.state = Convergence::one_pass(now.x, now.x_tilde, now.f);
  if (now.row.state.verdict != Verdict::not_finite) return;
  now.outcome = Outcome::failed;
  now.reason = "values are not finite";
}

void CoupledStep::measure(Attempt& now) {
  if (now.request.iteration == 0) forget_if_misleading(now.request.dt);
  ConvergenceState& state = now.row.state;
  state = scheme_->check(convergence_, now);
  if (state.verdict == Verdict::converged && !sides_.all_structures_solved()) {
    // The residual of a structure that was skipped is zero, whatever the soil answers.
    state.verdict = Verdict::going_on;
  }
  if (state.verdict != Verdict::converged) warn_of_round_off(state);
  if (state.verdict == Verdict::going_on && now.iterations() >= settings_.max_iterations) {
    state.verdict = Verdict::limit_reached;
  }
  if (state.verdict == Verdict::going_on) return;
  now.outcome = Outcome::converged;
  if (state.verdict != Verdict::converged) end_unconverged(now);
}

void CoupledStep::end_unconverged(Attempt& now) {
  const Verdict verdict = now.row.state.verdict;
  const bool usable = verdict == Verdict::limit_reached || verdict == Verdict::stagnated;
  if (settings_.on_limit != OnLimit::accept || !usable) {
    now.outcome = Outcome::failed;
    now.reason = failure_text(now);
    return;
  }
  now.outcome = Outcome::unconverged;
  log::warn("step {} accepted without convergence: {}", now.request.step, failure_text(now));
  ++counts_.accepted_unconverged;
}

void CoupledStep::forget_if_misleading(double dt) {
  constexpr double smallest_share = 0.5;  // of dt: below it, a structure moves less than a quarter
                                          // as far
  const bool much_smaller = dt < smallest_share * columns_dt_ * (1 - 1e-9);
  if (contact_.changed(sides_.soil_reports()) || much_smaller) forget_columns();
}

void CoupledStep::forget_columns() {
  forgotten_columns_ = acceleration_->reset();
  columns_dt_ = 0;
  ++counts_.history_resets;
}

void CoupledStep::warn_of_round_off(const ConvergenceState& state) {
  if (warned_round_off_ || state.below_round_off.empty()) return;
  warned_round_off_ = true;
  log::warn(
      "coupling/convergence: the limit of the {} is below the round-off of its values; "
      "iterations will stagnate",
      state.below_round_off);
}

void CoupledStep::log_iteration(Attempt& now, const Stopwatch& watch) {
  now.row.request = now.request;
  now.row.wall_seconds = watch.seconds();
  record_.iteration(now.row);
  log::debug("step {} iteration {}: displacement residual {:.3e} m, force residual {:.3e} N, {}",
             now.request.step, now.request.iteration, now.row.state.displacement_residual,
             now.row.state.force_residual.value_or(0), name(now.row.state.verdict));
  ++counts_.total;
}

void CoupledStep::accelerate(Attempt& now) {
  const ScopedTimer timer(phases_, "acceleration");
  const Stopwatch watch;
  scheme_->set_guess(acceleration_->next(scheme_->unknowns(now.x, now.f_given),
                                         scheme_->unknowns(now.x_tilde, now.f)),
                     now);
  acceleration_seconds_ += watch.seconds();
  now.row.acceleration = acceleration_->counters();
  now.row.acceleration.dropped_by_contact = std::exchange(forgotten_columns_, 0);
  if (!now.row.acceleration.fell_back) return;
  ++counts_.filter_fallbacks;
  log::warn(
      "step {} iteration {}: the residual does not decrease with the filter of coupler.json; from "
      "now on the default one acts, qr2 with {}",
      now.request.step, now.request.iteration, Filter().limit);
}

void CoupledStep::accept(const Attempt& done, double time) {
  if (done.skipped == Skipped::nothing && scheme_->repeats()) {
    const Stopwatch watch;
    acceleration_->end_step(scheme_->unknowns(done.x, done.f_given),
                            scheme_->unknowns(done.x_tilde, done.f));
    acceleration_seconds_ += watch.seconds();
    columns_dt_ = done.request.dt;
  }
  contact_.accept(sides_.soil_reports());
  predictor_.accept(time, scheme_->unknowns(done.x_tilde, done.f));
}

void CoupledStep::forget(double time, const Attempt& done) {
  forget_columns();
  predictor_.forget();
  predictor_.accept(time, scheme_->unknowns(done.x_tilde, done.f));
}

void CoupledStep::start_next(const StepRequest& request, const DtRange& proposed) {
  next_ = predict(request);
  sides_.start_next(*next_, proposed);
  ++counts_.started_early;
}

void CoupledStep::settle_next(const StepRequest& request) {
  if (!next_) return;
  const StepRequest& asked = next_->request;
  if (sides_.solve_next() && asked.time == request.time && asked.dt == request.dt) return;
  call_off_next();
}

void CoupledStep::call_off_next() {
  if (!next_) return;
  next_.reset();
  sides_.call_off_next();
  ++counts_.called_off;
}

void CoupledStep::start_at_rest() {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(sides_.map().size());
  predictor_.accept(0, scheme_->unknowns(sides_.accepted_x(), none));
}

double CoupledStep::take_acceleration_seconds() {
  return std::exchange(acceleration_seconds_, 0);
}

void CoupledStep::visit_state(StateVisitor& visitor) {
  acceleration_->visit_state(visitor);
  predictor_.visit_state(visitor);
  contact_.visit_state(visitor);
  visitor.integer("forgotten_columns", forgotten_columns_);
  visitor.real("columns_dt", columns_dt_);
}

}  // namespace gabion
