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
  BoulderShape<dim> shape;
  BodyState start;
  HardLaw law;           ///< against what is hard
  double free_from = 0;  ///< it is held before that time [s]
};

}  // namespace gabion::mpm
