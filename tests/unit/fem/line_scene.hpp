// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/gmsh_text.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

/// A mesh of lines alone, one group of them each, and groups of points, nodes numbered from 1 on.
struct LineText {
  std::vector<std::array<double, 3>> nodes;
  std::vector<std::pair<std::string, std::vector<std::vector<int>>>> lines;
  std::vector<std::pair<std::string, std::vector<int>>> points;

  GmshText file() const {
    GmshText text{.groups = {}, .entities = {}, .nodes = nodes, .blocks = {}};
    add_to(text, 1);
    return text;
  }

  /// @param tag  first free one of groups and entities
  void add_to(GmshText& text, int tag) const {
    for (const auto& [name, members] : points) {
      text.groups.push_back({0, tag, name});
      text.entities.push_back({0, tag, {tag}});
      std::vector<std::vector<int>> elements;
      for (const int node : members) elements.push_back({node});
      text.blocks.push_back({0, tag++, 15, elements});
    }
    for (const auto& [name, members] : lines) {
      text.groups.push_back({1, tag, name});
      text.entities.push_back({1, tag, {tag}});
      text.blocks.push_back({1, tag++, 1, members});
    }
  }
};

/// A straight chain of equal lines "rope" along x from node 1 on, with the points "low" and "high"
/// at its ends and "middle".
inline LineText chain(double length, int cells) {
  LineText text;
  std::vector<std::vector<int>> lines;
  for (int i = 0; i <= cells; ++i) {
    text.nodes.push_back({length * i / cells, 0, 0});
    if (i > 0) lines.push_back({i, i + 1});
  }
  text.lines = {{"rope", lines}};
  text.points = {{"low", {1}}, {"high", {cells + 1}}, {"middle", {cells / 2 + 1}}};
  return text;
}

inline Json line_material(const std::string& law, double E, double area, double density = 1) {
  return {{"law", law}, {"young_modulus", E}, {"area", area}, {"density", density}};
}

inline Json line_scene(int dimension, const std::string& file, Json material,
                       const std::string& group = "rope") {
  material["group"] = group;
  return {{"dimension", dimension}, {"mesh", {{"file", file}}}, {"materials", {material}}};
}

/// One step of a run alone.
inline void advance(Solver& solver, int n, double dt) {
  const StepRequest request{n, 0, (n - 1) * dt, dt};
  InterfaceValues sent;
  solver.solve_step(request, {}, sent);
  solver.accept_step(request, true);
}

}  // namespace gabion::test
