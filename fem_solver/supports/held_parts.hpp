// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/mesh/connected_parts.hpp"
#include "common/settings/config_reader.hpp"
#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Check the parts of a mesh that share no nodes, between which no forces pass. Warns of a part
/// that nothing holds while others are held, and of nodes in one place that are not joined.
/// @param in          reader of fem.json, for messages
/// @param connection  of the whole mesh; without parts nothing is checked
/// @throws ConfigError  a part that nothing holds is in contact with a held one: it would fall off;
///                      in statics and for an initial equilibrium a part that is not held in every
///                      direction
template <int dim>
void check_held_parts(const ConfigReader& in, const FemSettings<dim>& settings,
                      const MeshConnection<dim>& connection);

}  // namespace gabion::fem
