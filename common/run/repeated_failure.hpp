// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/run/solver.hpp"

namespace gabion {

/// Cause of a ConvergenceError after which a smaller dt is of no use.
inline constexpr const char* fails_at_any_dt = "fails_at_any_dt";

/// Notices that a step without inertia fails with any dt for one cause. It compares Newton's texts,
/// which have the residuals (of many the first and the last ones) and the worst node: they are
/// equal for another dt only where load and supports are equal, such as where a constant load acts
/// at once.
class RepeatedFailure {
 public:
  /// Look at what a try of a step without inertia threw.
  /// @returns  the error itself, or, where a try with another dt said the same, one of the cause
  ///           fails_at_any_dt
  /// @param advice  what a user does about it, as the end of a sentence
  ConvergenceError judge(const StepRequest& request, const ConvergenceError& error,
                         const std::string& advice);

 private:
  StepRequest last_;
  std::string text_;  // of its failure
};

}  // namespace gabion
