// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// A layer of soil whose axes are turned against the rows of the grid. Places are given along and
/// across the layer, from its centre.
struct TurnedLayer {
  double width = 1, height = 1;  ///< along and across [m]
  double h = 0.1;                ///< of the cells of the grid and of the body [m]
  double angle = 0;              ///< of the layer to the rows of the grid [rad]

  Matrix<2> turn() const {
    Matrix<2> R;
    R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    return R;
  }
  Vector<2> along() const { return turn().col(0); }
  Vector<2> across() const { return turn().col(1); }

  /// A grid about the layer, at least two cells wider on each side.
  Json grid() const {
    const double c = std::cos(angle), s = std::sin(angle);
    const int nx = static_cast<int>(std::ceil(0.5 * (width * c + height * s) / h)) + 2;
    const int ny = static_cast<int>(std::ceil(0.5 * (width * s + height * c) / h)) + 2;
    return box({-nx * h, -ny * h}, {nx * h, ny * h}, {2 * nx, 2 * ny}, "quad4");
  }
  /// Cells of the body before it is turned, see settings().
  Json mesh() const {
    const auto number = [this](double size) { return static_cast<int>(std::lround(size / h)); };
    return box({-0.5 * width, -0.5 * height}, {0.5 * width, 0.5 * height},
               {number(width), number(height)}, "quad4");
  }
  /// A plate to which the soil sticks, from one place to another. @param speed  along the layer
  /// and across it [m/s]  @param penalty  [Pa/m]
  Json plate(const std::string& name, std::pair<Vector<2>, Vector<2>> ends, const Vector<2>& speed,
             double penalty) const {
    const Vector<2> from = turn() * ends.first, to = turn() * ends.second, v = turn() * speed;
    return {{"name", name},
            {"surface", {{"polyline", {{from[0], from[1]}, {to[0], to[1]}}}, {"spacing", h / 2}}},
            {"method", "boundary_points"},
            {"mode", "fixed"},
            {"penalty", penalty},
            {"motion", {{"velocity", {v[0], v[1]}}}}};
  }
  /// Settings of an mpm.json of one body, with the body turned.
  mpm::MpmSettings<2> settings(const Json& json) const {
    auto settings = mpm_settings<2>(json);
    for (auto& x : settings.layouts[0].mesh.nodes) x = turn() * x;
    return settings;
  }
};

}  // namespace gabion::test
