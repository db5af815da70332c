// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/scene.hpp"
#include "mpm_solver/contact/contact_settings.hpp"

namespace gabion::mpm {

/// What factors of the contact's keys are multiplied with.
struct ContactUnits {
  double penalty = 0;    ///< of "penalty_factor" 1 [Pa/m]
  double cell_size = 0;  ///< mean [m]
};

/// Read "interfaces", none if the key is not there.
/// @throws ConfigError  also two of one name, or a facet in two of them
template <int dim>
std::vector<ContactSettings<dim>> read_interfaces(const Scene& scene, ConfigReader& in,
                                                  const ContactUnits& units);

/// Read "rigid_walls" likewise.
template <int dim>
std::vector<RigidWallSettings<dim>> read_rigid_walls(const Scene& scene, ConfigReader& in,
                                                     const ContactUnits& units);

}  // namespace gabion::mpm
