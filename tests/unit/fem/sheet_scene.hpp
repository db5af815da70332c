// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/gmsh_text.hpp"
#include "tests/unit/fem/fem_scene.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test {

/// A mesh of sheets "net" alone and groups of points, nodes numbered from 1 on.
struct SheetText {
  std::vector<std::array<double, 3>> nodes;
  std::vector<std::vector<int>> cells;  // of three or four nodes
  std::vector<std::pair<std::string, std::vector<int>>> points;

  GmshText file() const {
    GmshText text{.groups = {{2, 1, "net"}},
                  .entities = {{2, 1, {1}}},
                  .nodes = nodes,
                  .blocks = {{2, 1, cells.front().size() == 3 ? 2 : 3, cells}}};
    LineText{.nodes = {}, .lines = {}, .points = points}.add_to(text, 2);
    return text;
  }
};

using PlaceOnSheet = std::function<std::array<double, 3>(double, double)>;

/// n x m cells (with `triangles` twice as many) over the unit square, whose places are mapped.
/// Points: "rim"; the sides "low" and "high" of the first coordinate; "sides" of the second.
inline SheetText sheet(int n, int m, const PlaceOnSheet& place, bool triangles = false) {
  SheetText text;
  std::vector<int> rim, low, high, sides;
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i) {
      text.nodes.push_back(place(static_cast<double>(i) / n, static_cast<double>(j) / m));
      const int node = static_cast<int>(text.nodes.size());
      if (i == 0) low.push_back(node);
      if (i == n) high.push_back(node);
      if (j == 0 || j == m) sides.push_back(node);
      if (i == 0 || i == n || j == 0 || j == m) rim.push_back(node);
      if (i == n || j == m) continue;
      const int right = node + 1, up = node + n + 1, over = up + 1;
      if (triangles && (i + j) % 2 == 0) {
        text.cells.insert(text.cells.end(), {{node, right, over}, {node, over, up}});
      } else if (triangles) {
        text.cells.insert(text.cells.end(), {{node, right, up}, {right, over, up}});
      } else {
        text.cells.push_back({node, right, over, up});
      }
    }
  }
  text.points = {{"rim", rim}, {"low", low}, {"high", high}, {"sides", sides}};
  return text;
}

inline PlaceOnSheet flat(double length, double width) {
  return [=](double xi, double eta) { return std::array<double, 3>{length * xi, width * eta, 0}; };
}

/// A distorted and turned plane: inner places are moved in the plane.
inline PlaceOnSheet distorted_plane(double turn = 0.7) {
  return [=](double xi, double eta) {
    const double bump = 16 * xi * (1 - xi) * eta * (1 - eta);
    const double x = 2 * xi + 0.12 * bump * std::sin(5 * eta),
                 y = eta + 0.09 * bump * std::cos(4 * xi);
    return std::array<double, 3>{x * std::cos(turn), y, x * std::sin(turn)};
  };
}

/// A doubly curved, distorted place of sheets in space.
inline std::array<double, 3> curved(double xi, double eta) {
  return {1.3 * xi + 0.1 * eta * eta, eta - 0.15 * xi * eta, 0.3 * std::sin(2 * xi + eta)};
}

/// A disc of rings of triangles, 6 k nodes on the ring k, in the plane z = 0.
inline SheetText disc(double radius, int rings) {
  SheetText text;
  text.nodes.push_back({0, 0, 0});
  std::vector<int> starts = {1}, rim;
  for (int k = 1; k <= rings; ++k) {
    starts.push_back(static_cast<int>(text.nodes.size()) + 1);
    for (int i = 0; i < 6 * k; ++i) {
      const double angle = std::numbers::pi * i / (3.0 * k), r = radius * k / rings;
      text.nodes.push_back({r * std::cos(angle), r * std::sin(angle), 0});
      if (k == rings) rim.push_back(static_cast<int>(text.nodes.size()));
    }
    const auto outer = [&](int i) { return starts[k] + i % (6 * k); };
    const auto inner = [&](int i) { return k == 1 ? 1 : starts[k - 1] + i % (6 * (k - 1)); };
    for (int sector = 0; sector < 6; ++sector) {
      for (int i = 0; i < k; ++i) {
        const int at = sector * k + i, below = sector * (k - 1) + i;
        text.cells.push_back({inner(below), outer(at), outer(at + 1)});
        if (i + 1 < k) text.cells.push_back({inner(below), outer(at + 1), inner(below + 1)});
      }
    }
  }
  text.points = {{"rim", rim}};
  return text;
}

inline Json membrane(double E, double nu, double thickness, double density = 1) {
  return {{"group", "net"},        {"law", "linear_elastic"}, {"formulation", "membrane"},
          {"young_modulus", E},    {"poisson_ratio", nu},     {"density", density},
          {"thickness", thickness}};
}

inline Json sheet_scene(const std::string& file, const Json& material) {
  return {{"dimension", 3}, {"mesh", {{"file", file}}}, {"materials", {material}}};
}

}  // namespace gabion::test
