// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// A face that soil at rest presses on.
template <int dim>
struct RestingPlace {
  Vector<dim> normal = Vector<dim>::Zero();  ///< of length 1, into the soil
  double gap = 0;                            ///< of the point's contact sphere [m]
  double square = 0;                         ///< of the depth that bears the pressure alone [m^2]
  Vector<dim> pull = Vector<dim>::Zero();    ///< tangential force of the soil on the face [N]
  std::int32_t owner = 0;                    ///< surface of the contact that has the face
};

/// The displacement u whose depths n_k . u give each face the traction that it has at rest, with
/// the depths shared by ShortestExit (docs/theory/interface.md, (I17)):
///
///     s = sum_k square_k n_k ,   u = s / sqrt(|s|)
///
/// Faces that are turned by less than 30 degrees are one, the one with the smallest gap.
/// @returns zero without places [m]
template <int dim>
Vector<dim> penetration_at_rest(std::span<const RestingPlace<dim>> places);

}  // namespace gabion::mpm
