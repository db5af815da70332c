// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/repeated_failure.hpp"

#include <fmt/ranges.h>

#include <utility>

#include "common/base/unbalanced.hpp"

namespace gabion {

namespace {

/// Cause and residuals of a failure of Newton's method; empty for every other one.
std::string kind_of(const ConvergenceError& error) {
  const auto* unbalanced = dynamic_cast<const UnbalancedError*>(&error);
  if (!unbalanced || unbalanced->residuals().empty()) return {};
  return fmt::format("{}: {:.2e}", error.cause(), fmt::join(unbalanced->residuals(), " "));
}

}  // namespace

ConvergenceError RepeatedFailure::judge(const StepRequest& request, const ConvergenceError& error,
                                        const std::string& advice) {
  const StepRequest before = std::exchange(last_, request);
  const std::string kind = std::exchange(kind_, kind_of(error));
  const bool same_step = before.step == request.step && before.time == request.time &&
                         before.dt != request.dt && before.iteration == 0 && request.iteration == 0;
  if (!same_step || kind.empty() || kind != kind_) return error;
  return ConvergenceError(
      fmt::format("step {} at time {} s fails in the same way with dt = {} s and dt = {} s: load "
                  "and supports do not depend on dt, so a smaller one does not help; {} ({})",
                  request.step, request.time, before.dt, request.dt, advice, error.what()),
      fails_at_any_dt);
}

}  // namespace gabion
