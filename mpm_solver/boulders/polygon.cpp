// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/polygon.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

namespace {

using Box = Eigen::AlignedBox<double, 2>;

// Twice the area of a triangle, below 0 where its corners go clockwise.
double cross(const Vector<2>& a, const Vector<2>& b, const Vector<2>& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

const Vector<2>& corner(const Polygon& polygon, std::size_t k) {
  return polygon[k % polygon.size()];
}

Box box_of(const Vector<2>& a, const Vector<2>& b) {
  return Box(a).extend(b);
}

// For sides on one line the sign is rounding only; their boxes decide whether they overlap.
bool do_meet(const Vector<2>& a, const Vector<2>& b, const Vector<2>& c, const Vector<2>& d) {
  return box_of(a, b).intersects(box_of(c, d)) && cross(a, b, c) * cross(a, b, d) <= 0 &&
         cross(c, d, a) * cross(c, d, b) <= 0;
}

// Whether the side from b to c lies on that from a to b, to within rounding.
bool folds_back(const Vector<2>& a, const Vector<2>& b, const Vector<2>& c) {
  constexpr double rounding = 1e-12;
  return std::abs(cross(a, b, c)) <= rounding * (b - a).norm() * (c - b).norm() &&
         (b - a).dot(c - b) <= 0;
}

void require_different_corners(const Polygon& polygon) {
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector<2>& x = polygon[k];
    if (x != corner(polygon, k + 1)) continue;
    throw ConfigError(fmt::format(
        "found the corner ({}, {}) twice in a row, allowed: each corner once; the last side goes "
        "back to the first one",
        x[0], x[1]));
  }
}

}  // namespace

double signed_area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    twice += cross(polygon[0], polygon[k], polygon[k + 1]);
  }
  return 0.5 * twice;
}

// A ray along x meets an odd number of sides.
bool is_inside(const Polygon& polygon, const Vector<2>& x) {
  bool inside = false;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector<2>&a = polygon[k], &b = corner(polygon, k + 1);
    if ((a[1] > x[1]) == (b[1] > x[1])) continue;
    if ((cross(a, b, x) > 0) == (b[1] > a[1])) inside = !inside;
  }
  return inside;
}

double distance_to(const Polygon& polygon, const Vector<2>& x) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const std::array<Vector<2>, 2> side = {polygon[k], corner(polygon, k + 1)};
    least = std::min(least, (x - closest_place<2>(side, x).x).norm());
  }
  return least;
}

void require_simple(const Polygon& polygon) {
  require_different_corners(polygon);
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector<2>&a = polygon[i], &b = corner(polygon, i + 1);
    for (std::size_t j = i + 1; j < n; ++j) {
      const Vector<2>&c = polygon[j], &d = corner(polygon, j + 1);
      const bool follows = j == i + 1, is_before = i == 0 && j == n - 1;
      const bool wrong = follows     ? folds_back(a, b, d)
                         : is_before ? folds_back(c, d, b)
                                     : do_meet(a, b, c, d);
      if (!wrong) continue;
      throw ConfigError(fmt::format(
          "found sides {} and {} that meet, from ({}, {}) and from ({}, {}), allowed: a polygon "
          "that does not cross itself",
          i, j, a[0], a[1], c[0], c[1]));
    }
  }
}

}  // namespace gabion::mpm
