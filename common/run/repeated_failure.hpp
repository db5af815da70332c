// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/run/solver.hpp"

namespace gabion {

/// Cause of a ConvergenceError after which a smaller dt is of no use.
inline constexpr const char* fails_at_any_dt = "fails_at_any_dt";

/// Notices that a step without inertia fails in the same way with any dt: Newton's method has the
/// same residuals [N] with another dt only where load and supports are the same, as where a
/// constant load acts at once. Of a coupled step only the first iteration counts: later ones depend
/// on what the coupling has learnt, and it forgets that when dt gets smaller.
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
  std::string kind_;  // of its failure: cause and residuals
};

}  // namespace gabion
