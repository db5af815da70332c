// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <vector>

#include "common/mechanics/materials/rotation_warning.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Angle of the rotation that best fits the displacement of a body's points since the start [rad].
/// @note Collective.
template <int dim>
double body_rotation(MPI_Comm comm, const MaterialPoints<dim>& points, std::size_t body);

/// Warns of bodies of `linear_elastic` that have turned.
template <int dim>
class BodyRotations {
 public:
  /// Refers to the bodies.
  BodyRotations(MPI_Comm comm, const std::vector<Body<dim>>& bodies)
      : comm_(comm), bodies_(bodies), warnings_(bodies.size()) {}
  /// @note Collective.
  void look(const MaterialPoints<dim>& points);

 private:
  MPI_Comm comm_;
  const std::vector<Body<dim>>& bodies_;
  std::vector<RotationWarning> warnings_;
};

}  // namespace gabion::mpm
