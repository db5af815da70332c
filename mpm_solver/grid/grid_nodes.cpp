// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/grid_nodes.hpp"

#include <algorithm>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

template <int dim>
void number_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                  std::vector<std::int32_t> grid_nodes, GridNodes<dim>& nodes) {
  const bool same = nodes.grid_node == grid_nodes;
  if (num_ranks(comm) > 1 && (nodes.shared.alone() || !nodes.shared.all(same))) {
    nodes.shared = SharedNodes(comm, grid_nodes, grid.mesh.num_nodes_total());
  }
  nodes.active.resize(grid.mesh.nodes.size(), -1);
  for (const std::int32_t node : nodes.listed) nodes.active[node] = -1;
  nodes.grid_node = std::move(grid_nodes);
  nodes.listed = nodes.grid_node;
  nodes.x.clear();
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    nodes.active[nodes.grid_node[i]] = i;
    nodes.x.push_back(grid.mesh.nodes[nodes.grid_node[i]]);
  }
}

template <int dim>
void activate_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                    const PointWeights<dim>& weights, std::span<const std::int32_t> others,
                    GridNodes<dim>& nodes) {
  constexpr std::int32_t found = 0;
  nodes.active.resize(grid.mesh.nodes.size(), -1);
  for (const std::int32_t node : nodes.listed) nodes.active[node] = -1;
  nodes.listed.clear();
  const auto list = [&nodes](std::span<const std::int32_t> grid_nodes) {
    for (const std::int32_t node : grid_nodes) {
      if (nodes.active[node] == found) continue;
      nodes.active[node] = found;
      nodes.listed.push_back(node);
    }
  };
  for (const CellGroup& group : weights.groups) list(weights.nodes_of(group));
  list(others);
  std::vector<std::int32_t> grid_nodes = nodes.listed;
  std::sort(grid_nodes.begin(), grid_nodes.end());
  number_nodes(comm, grid, std::move(grid_nodes), nodes);
}

template void number_nodes<2>(MPI_Comm, const BackgroundGrid<2>&, std::vector<std::int32_t>,
                              GridNodes<2>&);
template void number_nodes<3>(MPI_Comm, const BackgroundGrid<3>&, std::vector<std::int32_t>,
                              GridNodes<3>&);
template void activate_nodes<2>(MPI_Comm, const BackgroundGrid<2>&, const PointWeights<2>&,
                                std::span<const std::int32_t>, GridNodes<2>&);
template void activate_nodes<3>(MPI_Comm, const BackgroundGrid<3>&, const PointWeights<3>&,
                                std::span<const std::int32_t>, GridNodes<3>&);

}  // namespace gabion::mpm
