// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Give the nodes of beams a node for their rotation each, behind all others.
/// @throws ConfigError  on several ranks
template <int dim>
void add_rotation_nodes(const ConfigReader& in, FemSettings<dim>& s);

/// @throws ConfigError  rotations held, or moments on, nodes of no beam
template <int dim>
void check_rotations(const FemSettings<dim>& s);

}  // namespace gabion::fem
