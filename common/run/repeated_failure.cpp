// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/repeated_failure.hpp"

#include <fmt/format.h>

#include <utility>

namespace gabion {

ConvergenceError RepeatedFailure::judge(const StepRequest& request, const ConvergenceError& error,
                                        const std::string& advice) {
  const StepRequest before = std::exchange(last_, request);
  const std::string text = std::exchange(text_, error.what());
  const bool same = text == error.what() && before.step == request.step &&
                    before.time == request.time && before.dt != request.dt;
  if (!same || text.find("|r|/scale") == std::string::npos) return error;
  return ConvergenceError(
      fmt::format("step {} at time {} s fails in the same way with dt = {} s and dt = {} s: load "
                  "and supports do not change with it, so that no smaller dt helps; {} ({})",
                  request.step, request.time, before.dt, request.dt, advice, text),
      fails_at_any_dt);
}

}  // namespace gabion
