// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step_sizes/step_sizes.hpp"

#include <algorithm>

#include "common/base/log.hpp"
#include "mpm_solver/phases/phases.hpp"

namespace gabion::mpm {

void StepSizes::begin(const StepRequest& request) {
  if (!limits().any() || accepted_dt_ == 0 || request.dt >= accepted_dt_) return;
  if (proposal_.limit == logged_limit_) return;
  logged_limit_ = proposal_.limit;
  log::info("{:.6g} s: dt from {:.4g} to {:.4g} s, limited by {}", request.time, accepted_dt_,
            request.dt, limit_name(proposal_.limit));
}

void StepSizes::add_solution(int newton_iterations) {
  newton_counts_.add_solution(newton_iterations);
  step_newton_ = std::max(step_newton_, newton_iterations);
}

void StepSizes::add_failure(const ConvergenceError& error, double dt) {
  newton_counts_.add_failure(error.cause());
  if (error.cause() != phase_cause) control_.fail(dt);
}

void StepSizes::reject() {
  step_newton_ = 0;
  proposal_.limit = DtLimit::failure;
}

void StepSizes::accept(StepMeasures step, double phase_dt) {
  step.newton_iterations = step_newton_;
  proposal_ = control_.accept(step, phase_dt);
  accepted_dt_ = step.dt;
  step_newton_ = 0;
}

}  // namespace gabion::mpm
