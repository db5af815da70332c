// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mpm_solver/boulders/boulder_shape.hpp"
#include "mpm_solver/boulders/hard_contact.hpp"

namespace gabion::mpm {

/// A rigid body among the soil. Its surface is one of MpmSettings::rigid_walls, the boulders' are
/// the last of them, in this order.
template <int dim>
struct BoulderSettings {
  std::string name;
  std::string where;   ///< its place in the config, for messages
  double density = 0;  ///< [kg/m^3]
  BoulderShape<dim> shape;
  BodyState start;
  HardLaw law;                ///< contact with hard bodies
  double soil_friction = 0;   ///< Coulomb's coefficient between soil and boulder
  double free_from = 0;       ///< it is held before that time [s]
  bool removes_soil = false;  ///< at the start, where it is
};

}  // namespace gabion::mpm
