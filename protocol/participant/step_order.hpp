// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/run/solver.hpp"

namespace gabion {

/// Checks that the coupler's requests follow one another: a step starts where the last accepted one
/// ended, and the accepted step is the solved one. All functions throw ProtocolError.
class StepOrder {
 public:
  /// Check the request before a solution, and before a step that is accepted without one.
  void check(const StepRequest& request) const;
  /// @param request  that was solved
  void solved(const StepRequest& request) { solution_ = request; }
  /// @param with_solution  false: the participant was skipped
  void accept(const StepRequest& request, bool with_solution);
  /// Forget the last solution.
  void reject() { solution_.reset(); }
  /// Forget the order: the accepted state was loaded, and is one of any step.
  void forget() { *this = StepOrder(); }
  /// Whether a step was accepted, since the last state was loaded.
  bool has_begun() const { return accepted_.has_value(); }
  bool has_solution() const { return solution_.has_value(); }

 private:
  std::optional<StepRequest> accepted_;  // empty before the first accepted step
  std::optional<StepRequest> solution_;
};

}  // namespace gabion
