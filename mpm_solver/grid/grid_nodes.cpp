// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/grid_nodes.hpp"

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

template <int dim>
bool activate_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                    const PointWeights<dim>& weights, GridNodes<dim>& nodes) {
  std::vector<std::int32_t> mark(grid.mesh.nodes.size(), 0);
  for (const CellGroup& group : weights.groups) {
    for (const std::int32_t node : weights.nodes_of(group)) mark[node] = 1;
  }
  sum_over_ranks(comm, std::span<std::int32_t>(mark));

  std::vector<std::int32_t> before = std::move(nodes.grid_node);
  nodes.grid_node.clear();
  nodes.x.clear();
  nodes.active.assign(mark.size(), -1);
  for (std::size_t i = 0; i < mark.size(); ++i) {
    if (mark[i] == 0) continue;
    nodes.active[i] = nodes.size();
    nodes.grid_node.push_back(static_cast<std::int32_t>(i));
    nodes.x.push_back(grid.mesh.nodes[i]);
  }
  return before != nodes.grid_node;
}

template bool activate_nodes<2>(MPI_Comm, const BackgroundGrid<2>&, const PointWeights<2>&,
                                GridNodes<2>&);
template bool activate_nodes<3>(MPI_Comm, const BackgroundGrid<3>&, const PointWeights<3>&,
                                GridNodes<3>&);

}  // namespace gabion::mpm
