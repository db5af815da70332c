// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/basis.hpp"

namespace gabion::mpm {

/// The nodes that carry the step: those of cells that hold a material point on any rank, numbered
/// in the order of the grid. Nodal fields are replicated on all ranks.
template <int dim>
struct GridNodes {
  std::vector<std::int32_t> grid_node;  ///< of each active node
  std::vector<std::int32_t> active;     ///< of each grid node; -1 = not active
  std::vector<double> m;                ///< mass [kg]
  std::vector<Vector<dim>> v;  ///< velocity mapped from the points [m/s], before the walls act
  std::vector<Vector<dim>> a;  ///< acceleration mapped from the points [m/s^2]

  std::int32_t size() const { return static_cast<std::int32_t>(grid_node.size()); }
};

/// Number the active nodes.
/// @returns whether they differ from those of the last call
template <int dim>
bool activate_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                    const PointWeights<dim>& weights, GridNodes<dim>& nodes);

}  // namespace gabion::mpm
