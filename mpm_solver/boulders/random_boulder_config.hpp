// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/keys.hpp"
#include "mpm_solver/boulders/boulders.hpp"

namespace gabion::mpm {

/// Keys of an entry of "random_boulders".
KeyTable random_boulder_keys();

/// Read an entry and draw its boulders, NAME_1 to NAME_N, the largest first; log how many, how
/// large and heavy they are. Equal settings give equal boulders.
/// @param among  what they must not overlap; its boulders are those that are placed already
/// @throws ConfigError  also where there is no room for them
template <int dim>
std::vector<BoulderSettings<dim>> read_random_boulders(ConfigReader& in,
                                                       const BoulderScene<dim>& among);

}  // namespace gabion::mpm
