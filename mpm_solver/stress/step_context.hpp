// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>

#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/points/material_points.hpp"
#include "mpm_solver/stress/softening_average.hpp"

namespace gabion::mpm {

/// Context of laws in a step or substep, see PointContext.
template <int dim>
struct StepContext {
  double dt = 0;                              ///< [s]
  const BackgroundGrid<dim>* grid = nullptr;  ///< null: bands are not limited by the grid
  SofteningAverages averages = {};            ///< of the bodies

  /// Context of one point at the accepted state.
  PointContext of_point(const MaterialPoints<dim>& points, std::int32_t p) const;
};

/// A law with state variables in MaterialPoints::variables, from increment to increment: Umat.
template <class Law>
concept HasVariables = requires(const Law& law) {
  { law.num_variables() } -> std::same_as<int>;
};

/// Width of the narrowest band of shear that the basis can make in a cell [m].
template <int dim>
double band_width(const BackgroundGrid<dim>& grid, std::int32_t cell);

}  // namespace gabion::mpm
