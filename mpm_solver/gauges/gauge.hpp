// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// A piece of a plane through which soil is watched, at rest. 2D: a segment from the foot to the
/// top. 3D: a parallelogram over a foot line.
template <int dim>
struct Gauge {
  /// 2D: foot, top. 3D: start and end of the foot line, top above its start [m].
  using Corners = std::array<Vector<dim>, dim>;
  /// @throws ConfigError  corners in one line
  Gauge(std::string name_, const Corners& corners);

  std::string name;
  Vector<dim> foot;     ///< first corner [m]
  Vector<dim> normal;   ///< unit; 2D: to the right of foot to top; 3D: foot line x foot to top
  double height = 0;    ///< length of the side from foot to top [m]
  double size = 0;      ///< area [m^2]; 2D: length [m]
  Vector<dim> up;       ///< up . (x - foot) is 0 at the foot, 1 at the top
  Vector<dim> forward;  ///< forward . (x - foot) is 0 and 1 at the ends of the foot line; 2D: zero

  /// Signed distance from the plane, along the normal [m].
  double distance(const Vector<dim>& x) const { return normal.dot(x - foot); }
  /// Whether the projection of x along the normal lies in the piece; of its edges those at the foot
  /// and at the start of the foot line belong to it.
  bool holds(const Vector<dim>& x) const;
  /// 1 or -1 for a straight path from x0 to x1 that crosses the piece along or against the normal,
  /// else 0. A place on the plane counts as in front of it, so that successive paths count once.
  int crossing(const Vector<dim>& x0, const Vector<dim>& x1) const;
};

}  // namespace gabion::mpm
