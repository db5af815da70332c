// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Signed distance of a convex set from an ellipsoid, as the largest value of
/// n . (nearest point of the set - centre) - extent(n) over directions n of length 1, below 0 where
/// the two overlap. Overlaps are those of contact: less deep than the radii of curvature.
struct EllipsoidGap {
  double gap = 0;                     ///< [m]
  Vector<3> out = Vector<3>::Zero();  ///< that direction: out of the ellipsoid
};

/// An ellipsoid in space, with A = R diag(axes^2) R^T: n . A n is the square of its extent along n.
class Ellipsoid {
 public:
  /// @param turned  turns its axes to space
  /// @param axes    semi-axes [m]; in 2D the third is 0, which stands for any
  Ellipsoid(const Vector<3>& centre, const Eigen::Quaterniond& turned, const Vector<3>& axes);

  const Vector<3>& centre() const { return centre_; }
  /// Half of its length along a direction of length 1 [m].
  double extent(const Vector<3>& n) const { return stretched(n).norm(); }
  /// The point of its surface that is farthest along a direction: centre + A n / extent.
  Vector<3> support(const Vector<3>& n) const { return centre_ + arm(n); }

  /// A plane through x with the normal n, out of what it bounds.
  EllipsoidGap to_plane(const Vector<3>& x, const Vector<3>& n) const;
  EllipsoidGap to_point(const Vector<3>& x) const;
  /// @param edge  along the line through x, of length 1
  EllipsoidGap to_line(const Vector<3>& x, const Vector<3>& edge) const;
  /// @throws ConvergenceError  the common normal is not found
  EllipsoidGap to(const Ellipsoid& other) const;

 private:
  // diag(axes) R^T n
  Vector<3> stretched(const Vector<3>& n) const {
    return axes_.cwiseProduct(turned_.transpose() * n);
  }
  Vector<3> arm(const Vector<3>& n) const;
  Matrix<3> squares() const;                            // A
  Matrix<3> curvature_radii(const Vector<3>& n) const;  // second derivative of the extent
  Vector<3> first_normal(const Ellipsoid& other) const;

  Vector<3> centre_;
  Matrix<3> turned_;
  Vector<3> axes_;
};

}  // namespace gabion::mpm
