// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/phases/phases.hpp"

namespace gabion::mpm {

/// Look whether the cells of a grid from a file hang together: where nodes in one place are not
/// joined, soil on one side does not feel that on the other. Nodes of a slit whose sides are in
/// groups that `walls` hold in some phase may be apart. Warns of parts that are not connected.
/// @param in  reader of mpm.json, for messages
/// @throws ConfigError  other nodes in one place that are not joined: number and places
template <int dim>
void check_grid_mesh(const ConfigReader& in, const BackgroundGrid<dim>& grid,
                     const std::vector<Phase>& phases);

}  // namespace gabion::mpm
