// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <vector>

#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Sums over all the points of all ranks.
template <int dim>
struct PointTotals {
  double mass = 0;                             ///< [kg]
  Vector<dim> momentum = Vector<dim>::Zero();  ///< [kg m/s]
  double kinetic_energy = 0;                   ///< [J]
  double elastic_energy = 0;                   ///< [J]
  std::vector<double> front;                   ///< largest x of each body [m]
};
template <int dim>
PointTotals<dim> point_totals(MPI_Comm comm, const MaterialPoints<dim>& points);

}  // namespace gabion::mpm
