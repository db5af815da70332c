// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/keys.hpp"
#include "common/settings/scene.hpp"
#include "mpm_solver/boulders/boulders.hpp"

namespace gabion::mpm {

/// Keys of an entry of "boulders".
KeyTable boulder_keys();

/// Read "boulders", none if the key is not there, and add their surfaces to the rigid walls.
/// @param among  what is read of the rest; it refers to `boulders` and `walls`
/// @throws ConfigError  also where one overlaps another one, a rigid wall or an interface, is too
///                      small for the cells, or free in a phase without inertia
template <int dim>
void read_boulders(const Scene& scene, ConfigReader& in, const BoulderScene<dim>& among,
                   std::vector<BoulderSettings<dim>>& boulders,
                   std::vector<RigidWallSettings<dim>>& walls);

}  // namespace gabion::mpm
