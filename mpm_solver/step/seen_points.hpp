// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <vector>

#include "mpm_solver/grid/box_grid.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Points that a rank knows: its own, with their numbers, then those of other ranks that are near.
template <int dim>
struct SeenPoints {
  std::vector<Vector<dim>> x;      ///< [m]
  std::vector<double> volume;      ///< over that of a cell
  std::vector<std::int32_t> cell;  ///< of the grid
};

template <int dim>
struct SightOfPoints {
  MPI_Comm comm;
  const BoxGrid<dim>& box;
  const MaterialPoints<dim>& points;  ///< of this rank
  double reach = 0;                   ///< by the side of the largest point of all ranks
};

/// Collect the points of this rank, and those of others that are in the cells of its points, beside
/// them, or within the reach. A rank sends what is near the box around the cells of another.
/// @pre  the points are in the grid
/// @note Collective.
template <int dim>
SeenPoints<dim> see_points(const SightOfPoints<dim>& sight);

}  // namespace gabion::mpm
