// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/small_cuts/weak_nodes.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// Data among which light nodes are sought.
template <int dim>
struct LightNodeSearch {
  const BackgroundGrid<dim>& grid;
  const MaterialPoints<dim>& points;
  const PointWeights<dim>& weights;
  const WallConditions<dim>& walls;
  double share = 0;  ///< of the mass within reach
  double doubled_share = 0;  ///< share for nodes with several numbers, where it is larger
  /// The surfaces, where weak nodes (find_weak_nodes) join too; null: they do not.
  const FacetSights<dim>* sights = nullptr;
};

/// A node that its points hardly weigh on,
///
///     m_i < share sum_p m_p   over the points with N_ip among their values,
///
/// makes the stiffness nearly singular where there is no inertia: only the gradient of a shape
/// function then holds it. With inertia the stiffness is nearly singular where bodies slide on each
/// other, since friction at its limit holds nothing. It is not solved for: it takes the number of
/// the nearest heavier node of its grid cells and moves with it, so that mass, weight and every
/// force on it act there. Weak nodes join the nearest node in front of the surface that they are
/// behind. Nodes that a wall holds neither join nor are joined, but for doubled ones, which have no
/// ghost stiffness: they join nodes that the same walls hold in the same directions. Without a
/// partner a node stays.
///
/// @param[in,out] nodes  active, with their mass; numbered anew where a node joined, mass and
///                       motion are then to be mapped again
/// @returns number of nodes that joined another
/// @note Collective on comm; the same on all ranks.
template <int dim>
std::int32_t join_light_nodes(MPI_Comm comm, const LightNodeSearch<dim>& search,
                              GridNodes<dim>& nodes);

}  // namespace gabion::mpm
