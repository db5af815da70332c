// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

/// A surface where it is when a run begins.
template <int dim>
struct PlacedSurface {
  std::vector<Simplex<dim>> simplices;
  std::vector<Vector<dim>> vertices;  ///< [m]
};

/// Surfaces that are searched as one for contact points: those whose rim meets the other one flush,
/// at an outside corner or at a bend by less than that of `corner_cosine`. At a corner that the
/// soil lies in, as between a floor and a wall, each of the two is searched for itself: none of
/// their rims is in the way there.
/// @param tolerance  a rim that is nearer to a surface meets it [m]
/// @returns of each surface the first one of those that it is one with; itself: none before it
template <int dim>
std::vector<std::int32_t> joint_surfaces(const std::vector<PlacedSurface<dim>>& surfaces,
                                         double tolerance);

}  // namespace gabion::mpm
