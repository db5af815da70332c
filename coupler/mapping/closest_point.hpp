// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

namespace gabion {

/// Closest point of a facet, as weights of the facet's vertices that sum to 1. Points of the plane
/// have a third coordinate of 0.
struct ClosestPoint {
  std::array<double, 4> weights{};
  double distance = 0;  ///< [m]
};

/// @pre the ends differ
ClosestPoint closest_on_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b);

/// @pre the triangle has an area
ClosestPoint closest_on_triangle(const Eigen::Vector3d& p,
                                 const std::array<Eigen::Vector3d, 3>& corners);

/// Closest point on the bilinear surface of four corners, which may be warped: Newton's method
/// inside, segments on the border.
ClosestPoint closest_on_quad(const Eigen::Vector3d& p,
                             const std::array<Eigen::Vector3d, 4>& corners);

}  // namespace gabion
