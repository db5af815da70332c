// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace gabion {

/// Proposals of a step size that lead to the same next step.
struct DtRange {
  double from = 0;                   ///< [s] allowed
  std::optional<double> below = {};  ///< [s] not allowed any more; empty: no bound

  /// @param proposed_dt  [s] 0 = no opinion, which is above all others
  bool contains(double proposed_dt) const {
    return proposed_dt <= 0 ? !below : proposed_dt >= from && (!below || proposed_dt < *below);
  }
};

}  // namespace gabion
