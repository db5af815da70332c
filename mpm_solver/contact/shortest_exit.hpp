// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// The shortest displacement out of several planes: u = sum_k depths_k n_k, depths_k > 0, of all u
/// with n_l . u >= delta_l. It changes continuously where a plane comes in, at any angle: two that
/// are nearly parallel push as one, two at right angles independently.
template <int dim>
struct ShortestExit {
  int size = 0;                               ///< number of planes that push
  std::array<int, dim> planes{};              ///< which, ascending
  std::array<double, dim> depths{};           ///< along their normals [m]
  Matrix<dim> inverse = Matrix<dim>::Zero();  ///< d depths_k / d delta_l, k, l < size
  double length = 0;                          ///< |u| [m]
};

/// @param normals  of length 1, pointing out
/// @param deltas   depths below the planes, > 0 [m]
template <int dim>
ShortestExit<dim> shortest_exit(std::span<const Vector<dim>> normals,
                                std::span<const double> deltas);

}  // namespace gabion::mpm
