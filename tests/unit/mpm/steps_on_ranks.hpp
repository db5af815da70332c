// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver_program/ranked_state.hpp"
#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test {

/// Steps that depend on nothing but their scene: explicit ones, or implicit ones that are solved as
/// exactly as can be.
inline void solve_exactly(const std::string& scheme, Json& scene) {
  if (scheme == "explicit") {
    scene["time_integration"] = {{"scheme", "explicit"}};
  } else {
    scene["newton"] = exact_newton;
    scene["linear_solver"] = {{"method", "mumps"}};
  }
}

/// Solve and accept the steps from number `first` to `last`.
inline void run(Solver& solver, double dt, int first, int last) {
  InterfaceValues forces;
  for (int n = first; n <= last; ++n) {
    const StepRequest step{n, 0, (n - 1) * dt, dt};
    solver.solve_step(step, {}, forces);
    solver.accept_step(step, true);
  }
}

}  // namespace gabion::test
