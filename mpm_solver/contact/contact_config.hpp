// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/scene.hpp"
#include "mpm_solver/contact/contact_settings.hpp"

namespace gabion::mpm {

/// Read "interfaces", none if the key is not there.
/// @param penalty_unit  penalty of boundary points with "penalty_factor" 1 [Pa/m]
/// @throws ConfigError  also two of one name, or a facet in two of them
template <int dim>
std::vector<ContactSettings<dim>> read_interfaces(const Scene& scene, ConfigReader& in,
                                                  double penalty_unit);

/// Like read_interfaces(), of "rigid_walls".
template <int dim>
std::vector<RigidWallSettings<dim>> read_rigid_walls(const Scene& scene, ConfigReader& in,
                                                     double penalty_unit);

}  // namespace gabion::mpm
