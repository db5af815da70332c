// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/phases/strength_reduction.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gabion::mpm {

KeyTable strength_reduction_keys() {
  const StrengthReduction defaults;
  return {
      "strength_reduction",
      "Strengths divided by a factor F that grows by `increment` a step until no equilibrium "
      "is found: c / F, tan(phi) / F, tan(psi) / F.",
      {key::number("from", "", "F of the first step of the phase.")
           .in(positive())
           .or_else(defaults.from),
       key::number("to", "", "Largest F that is tried.").in(positive()).or_else(defaults.to),
       key::number("increment", "", "Growth of F a step; halved after each failure.")
           .in(positive())
           .or_else(defaults.increment),
       key::number("tolerance", "", "Largest distance from an F with equilibrium to one without.")
           .in(positive())
           .or_else(defaults.tolerance),
       key::number("max_displacement", "m",
                   "Displacement since `from` beyond which the slope has failed: some percent "
                   "of its height.")
           .in(positive())}};
}

StrengthReduction read_strength_reduction(ConfigReader in) {
  StrengthReduction settings;
  settings.from = in.number("from");
  settings.to = in.number("to");
  settings.increment = in.number("increment");
  settings.tolerance = in.number("tolerance");
  settings.max_displacement = in.number("max_displacement");
  if (!(settings.to > settings.from)) {
    in.fail("to",
            fmt::format("found {}, allowed: a number above from = {}", settings.to, settings.from));
  }
  in.finish();
  return settings;
}

void StrengthSearch::start(const StrengthReduction& settings, int phase) {
  *this = {};
  phase_ = phase;
  increment_ = settings.increment;
}

double StrengthSearch::next(const StrengthReduction& settings) const {
  if (highest_ == 0 || ended(settings)) return settings.from;
  return std::min(highest_ + increment_, settings.to);
}

bool StrengthSearch::take(const StrengthReduction& settings, double displacement) {
  if (ended(settings)) return true;
  const double factor = next(settings);
  if (highest_ == 0) {
    highest_ = factor;
    return true;
  }
  if (displacement_ + displacement > settings.max_displacement) return false;
  displacement_ += displacement;
  last_rate_ = displacement / (factor - highest_);
  if (first_rate_ == 0) first_rate_ = last_rate_;
  highest_ = factor;
  return true;
}

bool StrengthSearch::fail(const StrengthReduction& settings, SlopeEnd reason) {
  if (highest_ == 0 || ended(settings)) return false;
  const double factor = next(settings);
  failed_ = factor;
  if (factor - highest_ <= settings.tolerance) {
    end_ = static_cast<std::int64_t>(reason);
  } else {
    increment_ = (factor - highest_) / 2;
  }
  return true;
}

void StrengthSearch::visit_state(StateVisitor& visitor) {
  visitor.integer("strength.phase", phase_);
  visitor.real("strength.highest", highest_);
  visitor.real("strength.failed", failed_);
  visitor.real("strength.increment", increment_);
  visitor.real("strength.displacement", displacement_);
  visitor.real("strength.first_rate", first_rate_);
  visitor.real("strength.last_rate", last_rate_);
  visitor.integer("strength.end", end_);
}

}  // namespace gabion::mpm
