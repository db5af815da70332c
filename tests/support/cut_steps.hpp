// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "common/run/solver.hpp"
#include "common/run/time_steps.hpp"

namespace gabion::test {

/// Solve and accept all steps with free interfaces; one that does not converge is cut.
/// @param accepted  called with the time of each accepted step [s]
inline void run_with_cuts(
    Solver& solver, const TimeSettings& time,
    const std::function<void(double)>& accepted = [](double) {}) {
  TimeSteps steps(time);
  InterfaceValues sent;
  while (!steps.finished()) {
    const StepRequest request{steps.step(), 0, steps.time(), steps.dt()};
    try {
      solver.solve_step(request, {}, sent);
      solver.accept_step(request, true);
      steps.accept();
      accepted(steps.time());
    } catch (const ConvergenceError& error) {
      solver.reject_step();
      steps.cut(error.what());
    }
  }
}

}  // namespace gabion::test
