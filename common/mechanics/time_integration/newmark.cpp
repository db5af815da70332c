// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/time_integration/newmark.hpp"

#include <string>

namespace gabion {

NewmarkBossak NewmarkBossak::bossak(double alpha) {
  require<ConfigError>(alpha >= -1.0 / 3 && alpha <= 0,
                       "Bossak's alpha: found " + std::to_string(alpha) + ", allowed: -1/3 to 0");
  return {.alpha_bossak = alpha, .beta = 0.25 * (1 - alpha) * (1 - alpha), .gamma = 0.5 - alpha};
}

NewmarkBossak read_newmark_bossak(ConfigReader in) {
  NewmarkBossak scheme;
  if (in.choice_or("scheme", {"newmark", "bossak"}, "newmark") == "bossak") {
    const Range range{[](double x) { return x >= -1.0 / 3 && x <= 0; }, "a number in [-1/3, 0]"};
    scheme = NewmarkBossak::bossak(in.number_or("alpha", -0.1, range));
  }
  in.finish();
  return scheme;
}

}  // namespace gabion
