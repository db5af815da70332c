// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Axes of a contact as columns, the unit normal n first.
template <int dim>
Matrix<dim> frame_of(const Vector<dim>& n) {
  Matrix<dim> frame;
  frame.col(0) = n;
  if constexpr (dim == 2) {
    frame.col(1) << -n[1], n[0];
  } else {
    frame.col(1) = n.unitOrthogonal();
    frame.col(2) = n.cross(frame.col(1));
  }
  return frame;
}

/// The part of v across the unit normal n.
template <int dim>
Vector<dim> tangential(const Vector<dim>& v, const Vector<dim>& n) {
  return v - n.dot(v) * n;
}

}  // namespace gabion::mpm
