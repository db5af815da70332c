// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gabion {

template <int dim>
using Vector = Eigen::Matrix<double, dim, 1>;

/// Second-order tensor, row = first index.
template <int dim>
using Matrix = Eigen::Matrix<double, dim, dim>;

/// Derivative of a second-order tensor P by a second-order tensor H:
/// A(i * dim + J, k * dim + L) = dP_iJ / dH_kL.
template <int dim>
using Tangent = Eigen::Matrix<double, dim * dim, dim * dim, Eigen::RowMajor>;

/// Number of stored components of a symmetric tensor. In plane strain (dim 2) the out-of-plane
/// normal component is kept, because it carries stress and elastic strain.
template <int dim>
inline constexpr int symmetric_size = dim == 2 ? 4 : 6;

/// Symmetric tensor, true components (no factor 2): 2D xx, yy, zz, xy; 3D xx, yy, zz, xy, yz, xz.
template <int dim>
using Symmetric = Eigen::Matrix<double, symmetric_size<dim>, 1>;

/// Side of the square or cube of this volume.
template <int dim>
double cube_side(double volume) {
  static_assert(dim == 2 || dim == 3);
  return dim == 2 ? std::sqrt(volume) : std::cbrt(volume);
}

}  // namespace gabion
