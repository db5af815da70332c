// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/krylov_pause.hpp"

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion {

namespace {

constexpr std::int64_t first_pause = 4;
constexpr std::int64_t longest_pause = 64;

}  // namespace

void KrylovPause::after_failure(std::int64_t of_method) {
  if (of_method != method) last = 0;
  method = of_method;
  last = last == 0 ? first_pause : std::min(2 * last, longest_pause);
  steps = last;
}

void KrylovPause::visit_state(StateVisitor& visitor) {
  visitor.integer("krylov_pause.steps", steps);
  visitor.integer("krylov_pause.last", last);
  visitor.integer("krylov_pause.method", method);
  require(0 <= steps && steps <= last && last <= longest_pause,
          "saved state: a pause of {} steps out of {}, allowed: 0 <= steps <= last <= {}", steps,
          last, longest_pause);
}

}  // namespace gabion
