// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/time_integration/newmark.hpp"

#include <string>

#include "common/base/require.hpp"

namespace gabion {

NewmarkBossak NewmarkBossak::bossak(double alpha) {
  require<ConfigError>(alpha >= -1.0 / 3 && alpha <= 0,
                       "Bossak's alpha: found " + std::to_string(alpha) + ", allowed: -1/3 to 0");
  return {.alpha_m = alpha, .beta = 0.25 * (1 - alpha) * (1 - alpha), .gamma = 0.5 - alpha};
}

NewmarkBossak NewmarkBossak::generalized_alpha(double rho_inf) {
  require<ConfigError>(rho_inf >= 0 && rho_inf <= 1,
                       "rho_inf: found " + std::to_string(rho_inf) + ", allowed: 0 to 1");
  const double alpha_m = (2 * rho_inf - 1) / (rho_inf + 1);
  const double alpha_f = rho_inf / (rho_inf + 1);
  const double lead = 1 - alpha_m + alpha_f;
  return {.alpha_m = alpha_m,
          .alpha_f = alpha_f,
          .beta = 0.25 * lead * lead,
          .gamma = 0.5 - alpha_m + alpha_f};
}

KeyTable newmark_keys(const std::string& scheme) {
  return {
      "time_integration",
      "How velocity and acceleration follow from the displacement of a step.",
      {key::choice("scheme", {"newmark", "bossak", "generalized_alpha"},
                   "`newmark`: trapezoidal rule; `bossak`: averaged inertia; "
                   "`generalized_alpha`: averaged forces too, with interfaces or rigid walls only "
                   "with `rho_inf` 0.")
           .or_else(scheme),
       key::number("alpha", "",
                   "Bossak's alpha: the farther from 0, the more high frequencies are damped.")
           .in(in_words(between(-1.0 / 3, 0), "a number in [-1/3, 0]"))
           .or_else(-0.1)
           .when("scheme", {"bossak"}),
       key::number("rho_inf", "",
                   "Spectral radius at dt -> infinity: 1 damps nothing, 0 the highest frequencies "
                   "in one step.")
           .in(between(0, 1))
           .or_else(0.8)
           .when("scheme", {"generalized_alpha"})}};
}

NewmarkBossak read_newmark_bossak(ConfigReader in) {
  NewmarkBossak scheme;
  const std::string name = in.choice("scheme");
  if (name == "bossak") {
    scheme = NewmarkBossak::bossak(in.number("alpha"));
  } else if (name == "generalized_alpha") {
    scheme = NewmarkBossak::generalized_alpha(in.number("rho_inf"));
  }
  in.finish();
  return scheme;
}

void require_balance_at_end_of_step(const ConfigReader& in, const NewmarkBossak& scheme) {
  if (scheme.alpha_f == 0) return;
  in.fail("time_integration",
          "found generalized_alpha with forces averaged over the step, allowed with interfaces: "
          "newmark, bossak, or rho_inf 0; soil and structure have to balance the interface's "
          "forces at the end of the step");
}

}  // namespace gabion
