// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// The points of two bodies near a node of the grid, relative to it and by the cell size.
template <int dim>
struct TwoClouds {
  std::span<const Vector<dim>> first, second;  ///< neither is empty
};

/// Direction from one cloud to the other.
template <int dim>
struct PlaneNormal {
  Vector<dim> n = Vector<dim>::Zero();  ///< of length 1, from the first cloud to the second
  bool separates = false;               ///< a plane with this normal lies between the clouds
};

/// Normal of the plane between two clouds of points: by logistic regression, and where a plane
/// separates the clouds, that with the widest margin (docs/theory/bodies.md). That plane is unique,
/// so no regression is made where a plane across the guess separates them already.
/// @param guess  of length 1
/// @see Nairn, Hammerquist, Smith (2020)
template <int dim>
PlaneNormal<dim> plane_between(const TwoClouds<dim>& clouds, const Vector<dim>& guess);

}  // namespace gabion::mpm
