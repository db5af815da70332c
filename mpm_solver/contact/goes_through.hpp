// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Whether the line through x and y goes through a simplex with these corners. Simplices that share
/// a side do not both have a line that meets the side.
inline bool goes_through(const Vector<2>& x, const Vector<2>& y,
                         const std::array<Vector<2>, 2>& corners) {
  const auto cross = [path = Vector<2>(y - x)](const Vector<2>& b) {
    return path[0] * b[1] - path[1] * b[0];
  };
  return (cross(corners[0] - x) >= 0) != (cross(corners[1] - x) >= 0);
}

inline bool goes_through(const Vector<3>& x, const Vector<3>& y,
                         const std::array<Vector<3>, 3>& corners) {
  const Vector<3> path = y - x;
  const auto side = [&](int a, int b) {
    return path.dot((corners[a] - x).cross(corners[b] - x)) >= 0;
  };
  return side(0, 1) == side(1, 2) && side(1, 2) == side(2, 0);
}

/// A direction along no line of a grid: lines of sight along those would often go through corners
/// of simplices.
template <int dim>
Vector<dim> aside() {
  if constexpr (dim == 2)
    return {0.6139, 0.7894};
  else
    return {0.5773, 0.3137, 0.7539};
}

}  // namespace gabion::mpm
