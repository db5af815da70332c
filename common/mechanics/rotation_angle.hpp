// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// Angle of the rotation R with the largest R : A [rad]: of a deformation gradient that of its
/// polar decomposition A = R U, of the second moments of a set of points that of their best fit.
/// @see Kabsch (1976)
template <int dim>
double rotation_angle(const Matrix<dim>& A) {
  if constexpr (dim == 2) {
    return std::abs(std::atan2(A(1, 0) - A(0, 1), A(0, 0) + A(1, 1)));
  } else {
    const Eigen::JacobiSVD<Matrix<dim>> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix<dim> U = svd.matrixU();
    if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(dim - 1) *= -1;
    const Matrix<dim> R = U * svd.matrixV().transpose();
    return std::acos(std::clamp(0.5 * (R.trace() - 1), -1.0, 1.0));
  }
}

}  // namespace gabion
