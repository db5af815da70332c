// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/convergence/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace gabion {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double round_off =
    4 * epsilon;  // rounding of a field's values; a residual is a difference of them

/// @param absolute  sentence of that key
KeyTable field_limits_keys(const std::string& name, const std::string& unit,
                           const std::string& absolute) {
  return {
      name + "_limits",
      "Criteria of the residual of this field. Norms are root mean squares over its components.",
      {key::number("absolute", unit, absolute).in(positive()).or_none(),
       key::number("relative", "", "Largest residual over the norm of the field.")
           .in(in_words(at_least(1e-15), "a number >= 1e-15 (round-off of the values)"))
           .or_none(),
       key::number("floor", unit, "Lower bound of the limit that `relative` gives.")
           .in(non_negative())
           .or_else(FieldLimits{}.floor)
           .with("relative"),
       key::number("drop", "", "Largest residual over the first one of the step.")
           .in(in_words(inside(0, 1), "a number > 0 and < 1"))
           .or_none()}};
}

FieldLimits read_field_limits(ConfigReader in) {
  FieldLimits limits;
  limits.absolute = in.optional_number("absolute");
  limits.relative = in.optional_number("relative");
  if (limits.relative) limits.floor = in.number("floor");
  limits.drop = in.optional_number("drop");
  if (in.has("floor") && !limits.relative) {
    in.fail("floor", "found without \"relative\", whose limit it bounds");
  }
  in.finish();
  return limits;
}

/// Residual over limit; 0 where both are 0, a limit met exactly.
double share(double residual, double limit) {
  return residual == 0 ? 0 : residual / limit;
}

}  // namespace

KeyTable convergence_keys() {
  const ConvergenceSettings defaults;
  return {
      "convergence",
      "When a step has converged: at least one criterion, on displacement or force.",
      {key::object("displacement", field_limits_keys("displacement", "m", "Largest residual."),
                   "Criteria on the displacement residual: the structures' answer minus the guess.")
           .or_none(),
       key::object("force",
                   field_limits_keys("force", "N",
                                     "Largest residual of the nodal forces, which grow with the "
                                     "size of a facet; in 2D per metre of thickness."),
                   "Criteria on the force residual: change since the iteration before (serial), or "
                   "answer minus guess (parallel).")
           .or_none(),
       key::choice("combine", {"and", "or"}, "Whether all criteria have to hold, or any.")
           .or_else("and"),
       key::number("divergence", "",
                   "A step has diverged when its displacement residual exceeds this many times the "
                   "first one of the step (parallel: the larger of the first two). Where the limit "
                   "of the residual is larger than these, it takes their place.")
           .in(in_words({.low = 1, .low_open = true}, "a number > 1"))
           .or_else(defaults.divergence),
       key::integer("stagnation",
                    "Iterations without a new smallest residual after which the step stagnates.")
           .in(at_least(2))
           .or_else(defaults.stagnation)}};
}

ConvergenceSettings read_convergence_settings(ConfigReader in) {
  ConvergenceSettings settings;
  if (in.has("displacement")) settings.displacement = read_field_limits(in.object("displacement"));
  if (in.has("force")) settings.force = read_field_limits(in.object("force"));
  const bool any = in.choice("combine") == "or";
  settings.combine = any ? Combine::any : Combine::all;
  settings.divergence = in.number("divergence");
  settings.stagnation = in.integer("stagnation");
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
  std::vector<double> shares;  // residual over limit of each field that has both
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

  // The first iteration of the serial scheme has no force residual, so there is nothing to compare
  // with.
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
