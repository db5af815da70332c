// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/stress/rigid_links.hpp"

namespace gabion::fem {

/// The rigid links of a structure with their nodes.
/// @throws ConfigError  "beam" is no group of one node of beams; a group of no nodes beside it; a
///                      node that two links take along, or that is the node of beams of one
template <int dim>
std::vector<RigidLink<dim>> rigid_links(const FemSettings<dim>& settings);

/// Throws as rigid_links().
template <int dim>
void check_rigid_links(const FemSettings<dim>& settings);

}  // namespace gabion::fem
