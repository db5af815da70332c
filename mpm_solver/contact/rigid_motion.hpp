// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/tensor.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// Given motion of a rigid surface: a translation d(t) and a turn about a centre that goes with it,
///
///     x(t) = c + d(t) + R(rate t) (X - c)
template <int dim>
struct RigidMotion {
  Vector<dim> velocity = Vector<dim>::Zero();  ///< [m/s], d = velocity t; not used with a table
  /// d(times[k]) = places[k], linear between them, at rest after the last; empty: none.
  std::vector<double> times;                 ///< [s], ascending from 0
  std::vector<Vector<dim>> places;           ///< [m]
  Vector<dim> centre = Vector<dim>::Zero();  ///< c [m]
  Vector<3> axis = Vector<3>::UnitZ();       ///< of length 1; in 2D the normal of the plane
  double rate = 0;                           ///< [rad/s]

  bool moves() const { return !velocity.isZero(0) || !times.empty() || rate != 0; }
  Vector<dim> translation(double time) const;
  /// x(t) - X of each vertex, num_vertices x dim [m].
  std::vector<double> displacement(const std::vector<Vector<dim>>& vertices, double time) const;
};

KeyTable rigid_motion_keys();

/// Read {"velocity": [..]} or {"table": [[t, ux, uy(, uz)], ..]}, and optionally {"rotation":
/// {"centre": [..], "rate", "axis": [..]}} (the axis in 3D only).
/// @throws ConfigError
template <int dim>
RigidMotion<dim> read_rigid_motion(ConfigReader in);

}  // namespace gabion::mpm
