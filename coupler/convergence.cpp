// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/convergence.hpp"

#include <algorithm>
#include <cmath>

namespace gabion {

namespace {

FieldLimits read_field_limits(ConfigReader in) {
  FieldLimits limits;
  limits.absolute = in.number("absolute", positive());
  limits.relative = in.number("relative", positive());
  limits.floor = in.number("floor", positive());
  in.finish();
  return limits;
}

}  // namespace

ConvergenceSettings read_convergence_settings(ConfigReader in) {
  ConvergenceSettings settings;
  settings.displacement = read_field_limits(in.object("displacement"));
  settings.force = read_field_limits(in.object("force"));
  const Range above_one{[](double x) { return x > 1; }, "a number > 1"};
  settings.divergence = in.number_or("divergence", settings.divergence, above_one);
  settings.stagnation = in.integer_or("stagnation", settings.stagnation, at_least(2));
  in.finish();
  return settings;
}

std::string name(Verdict verdict) {
  switch (verdict) {
    case Verdict::going_on:
      return "going_on";
    case Verdict::converged:
      return "converged";
    case Verdict::not_finite:
      return "not_finite";
    case Verdict::limit_reached:
      return "limit_reached";
    case Verdict::stagnated:
      return "stagnated";
    case Verdict::diverged:
      return "diverged";
  }
  return "unknown";
}

double rms(const Eigen::VectorXd& values) {
  if (values.size() == 0) return 0;
  return values.stableNorm() / std::sqrt(static_cast<double>(values.size()));
}

double FieldLimits::limit(double norm) const {
  return std::min(absolute, std::max(relative * norm, floor));
}

void Convergence::begin_step() {
  force_last_.resize(0);
  since_smallest_ = 0;
  first_ = true;
}

ConvergenceState Convergence::one_pass(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                                       const Eigen::VectorXd& force) {
  ConvergenceState state;
  state.displacement_residual = rms(x_tilde - x);
  const bool finite = x.allFinite() && x_tilde.allFinite() && force.allFinite() &&
                      std::isfinite(state.displacement_residual);
  state.verdict = finite ? Verdict::converged : Verdict::not_finite;
  return state;
}

ConvergenceState Convergence::check(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                                    const Eigen::VectorXd& force) {
  ConvergenceState state = one_pass(x, x_tilde, force);
  state.displacement_limit = settings_.displacement.limit(rms(x_tilde));
  state.force_limit = settings_.force.limit(rms(force));
  if (force_last_.size() > 0) state.force_residual = rms(force - force_last_);
  force_last_ = force;
  const bool finite =
      state.verdict != Verdict::not_finite && std::isfinite(state.force_residual.value_or(0));
  state.verdict = finite ? judge(state) : Verdict::not_finite;
  return state;
}

Verdict Convergence::judge(const ConvergenceState& state) {
  const double displacement = state.displacement_residual / state.displacement_limit;
  const double force = state.force_residual.value_or(0) / state.force_limit;
  if (state.force_residual && displacement <= 1 && force <= 1) return Verdict::converged;

  const double worst = std::max(displacement, force);
  if (first_) reference_ = std::max(state.displacement_residual, state.displacement_limit);
  if (first_ || worst < smallest_) {
    smallest_ = worst;
    since_smallest_ = 0;
  } else {
    ++since_smallest_;
  }
  first_ = false;
  if (state.displacement_residual > settings_.divergence * reference_) return Verdict::diverged;
  if (since_smallest_ >= settings_.stagnation) return Verdict::stagnated;
  return Verdict::going_on;
}

}  // namespace gabion
