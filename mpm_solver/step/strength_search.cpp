// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/strength_search.hpp"

#include <algorithm>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"

namespace gabion::mpm {

namespace {

// Growth of the displacement with F, over its mean in the search, from which on the soil counts as
// sliding.
constexpr double least_knee = 2;

// growth() above which the factor still depends on the largest displacement.
constexpr double largest_growth = 0.01;

// Share of the largest displacement of a search that one step may take.
constexpr double largest_share = 0.125;

}  // namespace

void StrengthSearch::start(const StrengthReduction& settings, int phase) {
  *this = {};
  phase_ = phase;
  from_ = settings.from;
  increment_ = settings.increment;
}

double StrengthSearch::next(const StrengthReduction& settings) const {
  if (highest_ == 0 || ended(settings)) return settings.from;
  return std::min(highest_ + increment_, settings.to);
}

bool StrengthSearch::found() const {
  return bracketed() && knee() >= least_knee;
}

double StrengthSearch::knee() const {
  if (!(displacement_ > 0)) return 0;
  const double rate = end() == SlopeEnd::displacement ? failed_rate_ : last_rate_;
  return rate * (highest_ - from_) / displacement_;
}

double StrengthSearch::growth() const {
  const auto at = [&](std::size_t k) -> std::pair<double, double> {
    if (k < steps_.size()) return {steps_[k].at("displacement"), steps_[k].at("factor")};
    return {displacement_ + failed_rate_ * (failed_ - highest_), failed_};
  };
  if (end() != SlopeEnd::displacement) return 0;
  const std::size_t last = steps_.size();
  const double half = at(last).first / 2;
  for (std::size_t k = 1; k <= last; ++k) {
    const auto [u, F] = at(k);
    if (u <= half) continue;
    const auto [u_n, F_n] = at(k - 1);
    return 1 - (F_n + (F - F_n) * (half - u_n) / (u - u_n)) / at(last).second;
  }
  return 0;
}

bool StrengthSearch::shorten(const StrengthReduction& settings, double displacement) {
  if (!can_fail(settings) || displacement <= largest_share * settings.max_displacement) {
    return false;
  }
  const double step = next(settings) - highest_;
  if (step <= settings.tolerance) return false;
  increment_ = step / 2;
  return true;
}

bool StrengthSearch::take(const StrengthReduction& settings, double displacement) {
  if (ended(settings)) return true;
  const double factor = next(settings);
  if (highest_ > 0) {
    const double rate = displacement / (factor - highest_);
    if (displacement_ + displacement > settings.max_displacement) {
      failed_rate_ = rate;
      return false;
    }
    displacement_ += displacement;
    last_rate_ = rate;
  }
  highest_ = factor;
  steps_.push_back({{"factor", factor}, {"displacement", displacement_}});
  return true;
}

void StrengthSearch::fail(const StrengthReduction& settings, SlopeEnd reason,
                          const std::string& text) {
  require(can_fail(settings), "strength reduction: a failure outside of the search: {}", text);
  const double factor = next(settings);
  failed_ = factor;
  reason_ = text;
  if (factor - highest_ <= settings.tolerance) {
    end_ = static_cast<std::int64_t>(reason);
  } else {
    increment_ = (factor - highest_) / 2;
  }
}

Json StrengthSearch::summary() const {
  Json json = {{"phase", phase() + 1},
               {"verdict", !bracketed() ? "no_failure"
                           : found()    ? "failure"
                                        : "not_solved"},
               {"equilibrium_with", highest_},
               {"displacement", displacement_},
               {"steps", steps_}};
  if (failed_ < std::numeric_limits<double>::infinity()) {
    json["none_with"] = failed_;
    json["reason"] = reason_;
  }
  if (!bracketed()) return json;
  json["ended_by"] = end() == SlopeEnd::displacement ? "displacement" : "no_equilibrium";
  json["knee"] = knee();
  json["growth"] = growth();
  if (found()) json["factor_of_safety"] = 0.5 * (highest_ + failed_);
  return json;
}

void StrengthSearch::log_result() const {
  if (!bracketed()) {
    log::warn(
        "strength reduction: no failure found, the soil still rests with F = {:.5g}, where \"to\" "
        "or "
        "the time of the run ended the search",
        highest_);
  } else if (found()) {
    log::info(
        "factor of safety: equilibrium with F = {:.5g}, none with {:.5g}; displacement {:.3g} m, "
        "per F {:.3g} times its mean: {}",
        highest_, failed_, displacement_, knee(), reason_.get<std::string>());
    if (growth() > largest_growth) {
      log::warn(
          "strength reduction: F grew by {:.2g} % over the second half of the displacement, so it "
          "depends on \"max_displacement\": give the soil a larger young_modulus, "
          "which does not change the factor of safety",
          100 * growth());
    }
  } else {
    log::warn(
        "strength reduction: not solved with F = {:.5g}, but the soil did not slide before: with "
        "{:.5g} its displacement per F is {:.3g} times the mean of the search, less than {}. This "
        "is not a factor of safety; begin lower or with smaller increments. {}",
        failed_, highest_, knee(), least_knee, reason_.get<std::string>());
  }
}

void StrengthSearch::visit_state(StateVisitor& visitor) {
  visitor.integer("strength.phase", phase_);
  visitor.real("strength.from", from_);
  visitor.real("strength.highest", highest_);
  visitor.real("strength.failed", failed_);
  visitor.real("strength.increment", increment_);
  visitor.real("strength.displacement", displacement_);
  visitor.real("strength.last_rate", last_rate_);
  visitor.real("strength.failed_rate", failed_rate_);
  visitor.integer("strength.end", end_);
  visitor.fact("strength.steps", steps_);
  visitor.fact("strength.reason", reason_);
}

}  // namespace gabion::mpm
