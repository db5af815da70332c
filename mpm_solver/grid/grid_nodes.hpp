// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// The nodes that carry the step: those that act on a material point of any rank, numbered in the
/// order of the grid. Nodal fields are replicated on all ranks.
template <int dim>
struct GridNodes {
  std::vector<std::int32_t> grid_node;  ///< of each active node
  std::vector<std::int32_t> active;     ///< of each grid node; -1 = not active
  std::vector<Vector<dim>> x;           ///< position [m]
  std::vector<double> m;                ///< mass [kg]
  std::vector<Vector<dim>> v;  ///< velocity mapped from the points [m/s], before the walls act
  std::vector<Vector<dim>> a;  ///< acceleration mapped from the points [m/s^2]

  /// Active numbers of the given grid nodes. @pre all are active
  void list_active(std::span<const std::int32_t> grid_nodes, std::int32_t* numbers) const {
    for (std::size_t i = 0; i < grid_nodes.size(); ++i) numbers[i] = active[grid_nodes[i]];
  }
  /// Values of a nodal field at the given grid nodes, dim each. @param field  size() x dim
  void gather(std::span<const std::int32_t> grid_nodes, std::span<const double> field,
              double* values) const {
    for (std::size_t i = 0; i < grid_nodes.size(); ++i) {
      const double* at_node =
          field.data() + static_cast<std::ptrdiff_t>(active[grid_nodes[i]]) * dim;
      for (int d = 0; d < dim; ++d) values[i * dim + d] = at_node[d];
    }
  }
  std::int32_t size() const { return static_cast<std::int32_t>(grid_node.size()); }
};

/// Number the active nodes.
/// @returns whether they differ from those of the last call
template <int dim>
bool activate_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                    const PointWeights<dim>& weights, GridNodes<dim>& nodes);

}  // namespace gabion::mpm
