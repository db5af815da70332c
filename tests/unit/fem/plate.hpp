// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

inline constexpr double height = 0.5, width = 0.1, density = 1000, g = 9.81;

/// An upright plate on a fixed base, wet on its left side and top.
inline Json plate(const std::string& law = "neo_hookean") {
  return {{"dimension", 2},
          {"mesh", box_2d({width, height}, {2, 10})},
          {"material", elastic(law, 1e5, 0.3, density)},
          {"gravity", {0, -g}},
          {"initial_equilibrium", true},
          {"supports", {{{"group", "bottom"}, {"report_reaction", true}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"left", "top"}}}}},
          {"probes",
           {{{"name", "A"}, {"point", {0, height}}}, {{"name", "B"}, {"point", {0.033, 0.21}}}}}};
}

/// An equal horizontal force [N] on every vertex.
inline InterfaceValues push(const Solver& solver, double force) {
  InterfaceValues values;
  const auto meshes = solver.interfaces();
  const InterfaceMesh& mesh = meshes.at(0);
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    values[mesh.name].insert(values[mesh.name].end(), {force, 0.0});
  }
  return values;
}

}  // namespace gabion::test
