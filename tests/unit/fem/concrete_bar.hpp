// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "tests/support/gmsh_text.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

/// A strip of quadrilaterals along x, the middle one in the group "weak", the others in "strong",
/// "left" and "right" at its ends; with the lines "steel" along its lower edge, where asked for.
inline GmshText strip(double length, double height, int cells, bool with_steel = false) {
  GmshText file;
  file.groups = {{1, 1, "left"}, {1, 2, "right"}, {2, 3, "weak"}};
  file.entities = {{1, 1, {1}}, {1, 2, {2}}, {2, 1, {3}}};
  std::vector<std::vector<int>> weak, strong, steel;
  for (int i = 0; i <= cells; ++i) {
    const double x = length * i / cells;
    file.nodes.push_back({x, 0, 0});
    file.nodes.push_back({x, height, 0});
    if (i == cells) break;
    const int n = 2 * i + 1;
    (i == cells / 2 ? weak : strong).push_back({n, n + 2, n + 3, n + 1});
    steel.push_back({n, n + 2});
  }
  file.blocks = {{1, 1, 1, {{1, 2}}}, {1, 2, 1, {{2 * cells + 1, 2 * cells + 2}}}, {2, 1, 3, weak}};
  if (!strong.empty()) {
    file.groups.push_back({2, 4, "strong"});
    file.entities.push_back({2, 2, {4}});
    file.blocks.push_back({2, 2, 3, strong});
  }
  if (with_steel) {
    file.groups.push_back({1, 5, "steel"});
    file.entities.push_back({1, 3, {5}});
    file.blocks.push_back({1, 3, 1, steel});
  }
  return file;
}

inline Json concrete(const std::string& group, double tensile_strength = 3e6) {
  Json material = elastic("concrete", 30e9, 0, 2400);
  material["tensile_strength"] = tensile_strength;
  material["fracture_energy"] = 100.0;
  material["compressive_strength"] = 38e6;
  material["crushing_energy"] = 54e3;
  if (!group.empty()) material["group"] = group;
  return material;
}

/// The n-th step of dt, cut as the program does where it is not solved.
/// @returns  Newton's iterations, most of a part
inline int advance(Solver& solver, int n, double dt) {
  const double start = (n - 1) * dt;
  double done = 0, part = dt;
  int most = 0;
  while (done < dt) {
    const StepRequest request{n, 0, start + done, part};
    InterfaceValues sent;
    try {
      most = std::max(most, solver.solve_step(request, {}, sent).newton_iterations);
    } catch (const ConvergenceError&) {
      if (part < dt / 1024) throw;
      solver.reject_step();
      part /= 2;
      continue;
    }
    solver.accept_step(request, true);
    done += part;
  }
  return most;
}

/// The strip is pulled by `elongation` in a second, its weak cell weaker by a tenth: at once with
/// the others Newton's method would have to find out which one it is that tears.
inline Json pulled_strip(const std::string& file, int cells, double elongation) {
  Json json = {{"dimension", 2}, {"mesh", {{"file", file}}}, {"analysis", "static"}};
  json["materials"] = {concrete("weak", 2.7e6)};
  if (cells > 1) json["materials"].push_back(concrete("strong"));
  json["supports"] = {{{"group", "left"}, {"report_reaction", true}}};
  json["prescribed"] = {
      {{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, elongation}}}}};
  return json;
}

}  // namespace gabion::test
