// SPDX-License-Identifier: BSD-3-Clause
// The steps of a search for the factor of safety.
#include <fmt/format.h>

#include <string>

#include "common/base/log.hpp"
#include "common/base/unbalanced.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/step/soil_step.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

// Of a first step without equilibrium.
std::string advice(const StrengthSearch& search, const StrengthReduction& settings) {
  if (search.highest() > 0) return "";
  return fmt::format(
      "; if the soil cannot rest with this strength, let strength_reduction/from = {} be smaller",
      settings.from);
}

}  // namespace

// Solve with the largest strength factor for which this step finds an equilibrium. The end of a
// search is part of the accepted state, whatever becomes of this step.
template <int dim>
StepReport SoilStep<dim>::solve_weaker(const StepRequest& request,
                                       const InterfaceValues& received) {
  const StrengthReduction& settings = *phase().strength_reduction;
  for (;;) {
    const double factor = start_.strength_factor;
    SlopeEnd reason = SlopeEnd::no_equilibrium;
    std::string text;
    try {
      const StepReport report = solve_once(request, received);
      const double largest = max_over_ranks(
          model_.comm, largest_displacement(soil_.weights(), soil_.nodes(), method_->du()));
      if (strength_.shorten(settings, largest)) {
        begin_with(request, StrengthSearch(strength_));
        continue;
      }
      if (strength_.take(settings, largest)) return report;
      reason = SlopeEnd::displacement;
      text = fmt::format("points would move by {:.3g} m", strength_.displacement() + largest);
    } catch (const ConvergenceError& error) {
      text = fmt::format("strength divided by F = {:.5g}: {}", factor, error.what());
      if (!strength_.can_fail(settings)) throw_as(text + advice(strength_, settings), error);
    }
    strength_.fail(settings, reason, text);
    log::info("strength reduction: no equilibrium with F = {:.5g}: {}", factor, text);
    if (strength_.bracketed()) {
      strength_.log_result();
      state_.strength = strength_;
    }
    begin_with(request, StrengthSearch(strength_));
  }
}

template StepReport SoilStep<2>::solve_weaker(const StepRequest&, const InterfaceValues&);
template StepReport SoilStep<3>::solve_weaker(const StepRequest&, const InterfaceValues&);

}  // namespace gabion::mpm
