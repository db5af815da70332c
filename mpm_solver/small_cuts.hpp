// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>

#include "mpm_solver/basis.hpp"
#include "mpm_solver/grid_nodes.hpp"

namespace gabion::mpm {

/// What is done about cells and nodes that hold little soil.
enum class SmallCutMethod {
  none,         ///< a floor under the nodal mass
  ghost,        ///< GhostStiffness beside that floor
  mass_cutoff,  ///< nodes with little mass move with a neighbour
};

struct SmallCutSettings {
  SmallCutMethod method = SmallCutMethod::none;
  double ghost_factor = 1.0 / 30;  ///< of Young's modulus, > 0
  /// Of the mean nodal mass, in (0, 0.01]: floor of the mass in inertia and weight; with
  /// mass_cutoff the share below which a node is dropped.
  double mass_share = 1e-8;
};

/// Take the nodes whose mass is below mass_share of the mean out of the solution: each moves with
/// the nearest kept node of a cell that it shares with soil, and all its mass and forces (internal,
/// contact, weight) go there. The resultants are exact, moments only to the distance of the two.
/// Nodes with no such neighbour, and those listed in `keep`, stay.
/// @param keep   grid nodes
/// @param nodes  with the masses of points_to_grid, which has to be called again when any was
///               dropped; `active` of a dropped node is the number of the node that it follows
/// @returns number of nodes dropped
/// @note Collective.
template <int dim>
std::int32_t drop_light_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                              const PointWeights<dim>& weights, double mass_share,
                              std::span<const std::int32_t> keep, GridNodes<dim>& nodes);

}  // namespace gabion::mpm
