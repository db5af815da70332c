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
/// at an outside corner, or at a bend by less than that of `corner_cosine`. At a corner that the
/// soil lies in, as between a floor and a wall, each of the two is searched by itself, since no rim
/// interferes there.
/// @param tolerance  a rim that is nearer to a surface meets it [m]
/// @returns for each surface the first of those that it is joined with; itself: it is the first
template <int dim>
std::vector<std::int32_t> joint_surfaces(const std::vector<PlacedSurface<dim>>& surfaces,
                                         double tolerance);

}  // namespace gabion::mpm
