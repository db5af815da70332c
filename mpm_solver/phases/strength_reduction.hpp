// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// "strength_reduction" of a phase: strengths are divided by a factor F that grows from step to
/// step until no equilibrium is found.
struct StrengthReduction {
  double from = 1;              ///< F of the first step, > 0
  double to = 5;                ///< largest F, > from
  double increment = 0.1;       ///< of F a step until the first failure, > 0
  double tolerance = 0.005;     ///< largest width of the bracket of F, > 0
  double max_displacement = 0;  ///< [m] since `from` beyond which the slope has failed, > 0
};

KeyTable strength_reduction_keys();
/// @throws ConfigError
StrengthReduction read_strength_reduction(ConfigReader in);

}  // namespace gabion::mpm
