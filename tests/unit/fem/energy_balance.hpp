// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

/// Energy that a structure has or has used, less the work on it [J].
inline double imbalance(const Solver& solver) {
  double sum = -probe(solver, "external_work");
  for (const char* name : {"kinetic_energy", "elastic_energy", "plastic_work", "brake_work",
                           "damage_work", "failed_energy"}) {
    const auto names = solver.probe_names();
    if (std::ranges::find(names, name) != names.end()) sum += probe(solver, name);
  }
  return sum;
}

}  // namespace gabion::test
