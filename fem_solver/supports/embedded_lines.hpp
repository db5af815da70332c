// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/mesh/connected_parts.hpp"
#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Find the hosts of embedded lines, whose nodes are then no unknowns and join no parts.
/// @param[out] connection  of the mesh without these lines, where there are some
/// @throws ConfigError  see find_embedded_nodes(); a condition or load at such a node
/// @note Collective.
template <int dim>
void embed_lines(FemSettings<dim>& settings, MeshConnection<dim>& connection);

}  // namespace gabion::fem
