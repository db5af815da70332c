// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"

namespace gabion::fem {

/// Limits beyond which a cell or line of a material fails; each suffices alone; without any the
/// material never fails.
struct FailureLimits {
  std::optional<double> plastic_strain;  ///< the largest of a point, of a beam of a fibre
  std::optional<double> force;           ///< tension of a line [N]
  /// Of a line from its stress-free length, without its brake's run; of concrete, that which opens
  /// its crack, mean of the points of a cell.
  std::optional<double> strain;
  /// Of concrete: that at which a bar is crushed as far, mean of the points of a cell.
  std::optional<double> crushing_strain;
  int fade_steps = 3;  ///< steps in which the stress of a failed cell falls to zero

  bool any() const { return plastic_strain || force || strain || crushing_strain; }
};

/// Reason for which a cell or line failed.
enum class FailureReason { none, plastic_strain, force, strain, crushing_strain };

/// A reason in words, with value, limit and unit.
std::string describe(FailureReason reason, double value, double limit);

/// Keys of all limits, each of the laws that have it. @param lines  those of lines, too
std::vector<Key> failure_keys(bool lines);

/// Read what failure_keys() list of a law.
/// @throws ConfigError  "fade_steps" without a limit
FailureLimits read_failure(ConfigReader& in, const std::string& law);

}  // namespace gabion::fem
