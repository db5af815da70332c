// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/keys.hpp"
#include "common/settings/scene.hpp"
#include "mpm_solver/boulders/boulder_settings.hpp"

namespace gabion::mpm {

template <int dim>
struct MpmSettings;

/// Keys of an entry of "boulders".
KeyTable boulder_keys();

/// Read "boulders", none if the key is not there, and add their surfaces to the rigid walls.
/// @pre the rest of mpm.json that describes soil, phases and surfaces is read
/// @throws ConfigError  also where one overlaps another one, a rigid wall or an interface, is too
///                      small for the cells, or free in a phase without inertia
template <int dim>
void read_boulders(const Scene& scene, ConfigReader& in, MpmSettings<dim>& settings);

}  // namespace gabion::mpm
