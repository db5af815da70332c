// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/phases/strength_reduction.hpp"

#include <fmt/format.h>

namespace gabion::mpm {

KeyTable strength_reduction_keys() {
  const StrengthReduction defaults;
  return {
      "strength_reduction",
      "Strengths divided by a factor F that grows by `increment` a step until no equilibrium "
      "is found: c / F, tan(phi) / F, tan(psi) / F, and friction / F of rigid walls and between "
      "groups of bodies.",
      {key::number("from", "", "F of the first step of the phase.")
           .in(positive())
           .or_else(defaults.from),
       key::number("to", "", "Largest F that is tried.").in(positive()).or_else(defaults.to),
       key::number("increment", "",
                   "Growth of F a step; halved after each failure, and where a step takes more "
                   "than an eighth of `max_displacement`.")
           .in(positive())
           .or_else(defaults.increment),
       key::number("tolerance", "", "Largest distance from an F with equilibrium to one without.")
           .in(positive())
           .or_else(defaults.tolerance),
       key::number(
           "max_displacement", "m",
           "Displacement since `from` beyond which a step counts as failed: about 1 % of the "
           "height H of the slope. Give the soil a `young_modulus` of at least 5000 rho g H; it "
           "does not change the factor of safety.")
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

}  // namespace gabion::mpm
