// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/run/state.hpp"

namespace gabion {

/// Pause of a Krylov method that failed: the direct method takes all matrices of the rest of the
/// step and of `steps` more steps. These are 4 after the first failure, and twice as many after
/// each further failure of the method in a row, up to 64. Other methods are not concerned.
struct KrylovPause {
  std::int64_t steps = 0;  ///< still to come in which it is not tried
  std::int64_t last = 0;   ///< what the last failure has set `steps` to; 0 after a success

  std::int64_t method = -1;  ///< LinearMethod::number of the one that failed last; -1: none

  void after_failure(std::int64_t of_method);
  void after_success() { *this = {}; }
  void after_rest() { steps -= steps > 0 ? 1 : 0; }
  /// @throws Error  taking: lengths that no failure leads to
  void visit_state(StateVisitor& visitor);
  bool operator==(const KrylovPause&) const = default;
};

}  // namespace gabion
