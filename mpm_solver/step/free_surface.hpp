// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/outer_point.hpp"
#include "mpm_solver/small_cuts/weak_nodes.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// The surroundings at which soil may end. Refers to all of them.
template <int dim>
struct SurroundingsOfSoil {
  MPI_Comm comm;
  const BackgroundGrid<dim>& grid;             ///< a box
  const MaterialPoints<dim>& points;           ///< of this rank
  const std::vector<WallSettings>& walls;      ///< of the phase
  const FacetSights<dim>* surfaces = nullptr;  ///< those that act; null: none does
};

/// The points of some bodies at which the soil ends in air (docs/theory/water.md). They are
/// found anew from the places of all points, and nothing is remembered. Lengths are measured by the
/// spacing of the grid along each axis, as points are laid. Soil goes on
///
/// - in a point of any body within 1.1 times the sum of both sides, in a cone of 45 degrees to n,
/// - behind facets of the grid's sides that a wall holds, and behind surfaces, within one side.
///
/// Only cells that are small cuts, or beside such a cell or a side of the grid that no wall holds,
/// are looked at. n points away from the mean of the points around, and of their images in walls.
/// Points of other ranks count where they are near enough.
/// @pre  all points are in the grid
/// @returns those of this rank
/// @note Collective.
template <int dim>
std::vector<OuterPoint<dim>> find_free_surface(const SurroundingsOfSoil<dim>& parts,
                                               std::span<const std::int32_t> bodies);

}  // namespace gabion::mpm
