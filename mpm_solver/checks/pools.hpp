// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Refuse what pools cannot do as yet: soil whose water does not drain, boulders, gravity along
/// other than the last axis. Warns of walls between pools that lean over water.
/// @throws ConfigError
template <int dim>
void check_pools(const ConfigReader& in, const MpmSettings<dim>& settings);

/// Pools of the settings at a time, under this gravity.
template <int dim>
PoolLevels pool_levels(const MpmSettings<dim>& settings, double time, const Vector<dim>& gravity);

}  // namespace gabion::mpm
