// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/participant/step_order.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "common/base/require.hpp"

namespace gabion {

namespace {
// Times are sums of steps, rounded.
double allowed_difference(const StepRequest& request) {
  return 1e-6 * request.dt + 8 * std::numeric_limits<double>::epsilon() * std::abs(request.time);
}
}  // namespace

void StepOrder::check(const StepRequest& request) const {
  if (!accepted_) return;
  require<ProtocolError>(
      request.step == accepted_->step + 1,
      "the coupler asks for step {} after step {} was accepted, expected step {}", request.step,
      accepted_->step, accepted_->step + 1);
  const double time = accepted_->time + accepted_->dt;
  require<ProtocolError>(
      std::abs(request.time - time) <= allowed_difference(request),
      "the coupler asks for step {} from {} s, but the accepted state is that of {} s",
      request.step, request.time, time);
}

void StepOrder::accept(const StepRequest& request, bool with_solution) {
  check(request);
  if (with_solution) {
    require<ProtocolError>(solution_.has_value(),
                           "the coupler accepts step {}, which has no solution", request.step);
    require<ProtocolError>(
        request.step == solution_->step && request.time == solution_->time &&
            request.dt == solution_->dt,
        "the coupler accepts step {} with dt {} s, but the solution is that of step {} "
        "with dt {} s",
        request.step, request.dt, solution_->step, solution_->dt);
  }
  accepted_ = request;
  solution_.reset();
}

}  // namespace gabion
