// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// The search of a scene to its end. The last solution is rejected: its result remains.
inline Json search_of_strength(const Json& scene) {
  const auto solver = make_mpm(scene);
  const auto result = [&] { return solver->summary().at("strength_reduction"); };
  for (int k = 0; k < 80; ++k) {
    const StepRequest request{k + 1, 0, static_cast<double>(k), 1};
    InterfaceValues sent;
    solver->solve_step(request, {}, sent);
    if (k > 0 && result().at("verdict") != "no_failure") {
      solver->reject_step();
      break;
    }
    solver->accept_step(request, true);
  }
  return result();
}

}  // namespace gabion::test
