// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace gabion {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double round_off =
    4 * epsilon;  // of a field's values; a residual is a difference of them

FieldLimits read_field_limits(ConfigReader in) {
  const Range above_round_off{[](double x) { return x >= 1e-15; },
                              "a number >= 1e-15 (round-off of the values)"};
  const Range fraction{[](double x) { return x > 0 && x < 1; }, "a number > 0 and < 1"};
  FieldLimits limits;
  if (in.has("absolute")) limits.absolute = in.number("absolute", positive());
  if (in.has("relative")) {
    limits.relative = in.number("relative", above_round_off);
    limits.floor = in.number_or("floor", limits.floor, non_negative());
  }
  if (in.has("drop")) limits.drop = in.number("drop", fraction);
  if (in.has("floor") && !limits.relative) {
    in.fail("floor", "found without \"relative\", whose limit it bounds");
  }
  in.finish();
  return limits;
}

/// 0 where both are 0: met exactly.
double share(double residual, double limit) {
  return residual == 0 ? 0 : residual / limit;
}

}  // namespace

ConvergenceSettings read_convergence_settings(ConfigReader in) {
  ConvergenceSettings settings;
  if (in.has("displacement")) settings.displacement = read_field_limits(in.object("displacement"));
  if (in.has("force")) settings.force = read_field_limits(in.object("force"));
  const bool any = in.choice_or("combine", {"and", "or"}, "and") == "or";
  settings.combine = any ? Combine::any : Combine::all;
  const Range above_one{[](double x) { return x > 1; }, "a number > 1"};
  settings.divergence = in.number_or("divergence", settings.divergence, above_one);
  settings.stagnation = in.integer_or("stagnation", settings.stagnation, at_least(2));
  in.finish();
  if (!settings.displacement.given() && !settings.force.given()) {
    in.fail(
        "displacement",
        "found no criterion, allowed: one or more of \"absolute\", \"relative\" and \"drop\" in "
        "\"displacement\", \"force\" or both");
  }
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
  const double squares = values.squaredNorm();  // the stable norm takes ten times as long
  const double norm = std::isnormal(squares) ? std::sqrt(squares) : values.stableNorm();
  return norm / std::sqrt(static_cast<double>(values.size()));
}

std::optional<double> FieldLimits::limit(double norm, std::optional<double> first,
                                         Combine combine) const {
  std::optional<double> result;
  const auto take = [&](double value) {
    if (!result) result = value;
    result = combine == Combine::all ? std::min(*result, value) : std::max(*result, value);
  };
  if (absolute) take(*absolute);
  if (relative) take(std::max(*relative * norm, floor));
  if (drop && first) take(*drop * *first);
  return result;
}

void Convergence::begin_step() {
  force_last_.resize(0);
  first_displacement_.reset();
  first_force_.reset();
  reference_ = 0;
  complete_before_ = false;
  since_smallest_ = 0;
  checks_ = 0;
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
  const Eigen::VectorXd before = std::exchange(force_last_, force);
  return check_pairs(x, x_tilde, before, force, 1);
}

ConvergenceState Convergence::check(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                                    const Eigen::VectorXd& force_given,
                                    const Eigen::VectorXd& force) {
  // The structures meet the force of the first iteration only in the second one.
  return check_pairs(x, x_tilde, force_given, force, 2);
}

ConvergenceState Convergence::check_pairs(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                                          const Eigen::VectorXd& force_given,
                                          const Eigen::VectorXd& force, int num_references) {
  ConvergenceState state = one_pass(x, x_tilde, force);
  if (force_given.size() > 0) state.force_residual = rms(force - force_given);
  if (state.verdict == Verdict::not_finite || !std::isfinite(state.force_residual.value_or(0))) {
    state.verdict = Verdict::not_finite;
    return state;
  }
  set_limits(rms(x_tilde), rms(force), num_references, state);
  state.verdict = judge(state);
  return state;
}

void Convergence::set_limits(double displacement_norm, double force_norm, int num_references,
                             ConvergenceState& state) {
  ++checks_;
  if (checks_ <= num_references) reference_ = std::max(reference_, state.displacement_residual);
  if (!first_displacement_) first_displacement_ = state.displacement_residual;
  if (!first_force_) first_force_ = state.force_residual;
  const Combine how = settings_.combine;
  state.displacement_limit =
      settings_.displacement.limit(displacement_norm, first_displacement_, how);
  state.force_limit = settings_.force.limit(force_norm, first_force_, how);
  const auto hopeless = [](std::optional<double> limit, double norm) {
    return limit && *limit < round_off * norm;
  };
  if (hopeless(state.force_limit, force_norm)) state.below_round_off = "force";
  if (hopeless(state.displacement_limit, displacement_norm)) state.below_round_off = "displacement";
}

Verdict Convergence::judge(const ConvergenceState& state) {
  std::vector<double> shares;  // of the limits, one a field that has criteria and a residual
  bool complete = true;
  if (settings_.displacement.given()) {
    shares.push_back(share(state.displacement_residual, *state.displacement_limit));
  }
  if (settings_.force.given()) {
    complete = state.force_residual && state.force_limit;
    if (complete) shares.push_back(share(*state.force_residual, *state.force_limit));
  }
  if (shares.empty()) return Verdict::going_on;
  const bool all = settings_.combine == Combine::all;
  const double worst = all ? *std::max_element(shares.begin(), shares.end())
                           : *std::min_element(shares.begin(), shares.end());
  if (worst <= 1 && (complete || !all)) return Verdict::converged;

  // The first iteration of the serial scheme knows no force residual: nothing to compare with.
  const bool first_complete = complete && !std::exchange(complete_before_, complete);
  if (checks_ == 1 || worst < smallest_ || (first_complete && worst > smallest_)) {
    smallest_ = worst;
    since_smallest_ = 0;
  } else {
    ++since_smallest_;
  }
  const double reference = std::max(reference_, state.displacement_limit.value_or(0));
  if (reference > 0 && state.displacement_residual > settings_.divergence * reference) {
    return Verdict::diverged;
  }
  if (since_smallest_ >= settings_.stagnation) return Verdict::stagnated;
  return Verdict::going_on;
}

}  // namespace gabion
