// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/grid_nodes.hpp"

#include <utility>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

template <int dim>
void number_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                  std::vector<std::int32_t> grid_nodes, GridNodes<dim>& nodes) {
  const bool same = nodes.grid_node == grid_nodes;
  nodes.num_places = grid.num_nodes_total();
  if (num_ranks(comm) > 1 && (nodes.shared.alone() || !nodes.shared.all(same))) {
    nodes.shared = SharedNodes(comm, grid_nodes, nodes.num_fields * nodes.num_places);
  }
  nodes.active.assign(std::size_t{1} * nodes.num_fields * nodes.num_places, -1);
  nodes.grid_node = std::move(grid_nodes);
  for (std::int32_t i = 0; i < nodes.size(); ++i) nodes.active.at(nodes.grid_node[i]) = i;
  if (same && std::ssize(nodes.x) == nodes.size()) return;
  nodes.x.clear();
  for (std::int32_t i = 0; i < nodes.size(); ++i) nodes.x.push_back(grid.node(nodes.place(i)));
}

template <int dim>
void activate_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                    const PointWeights<dim>& weights, std::span<const std::int32_t> others,
                    GridNodes<dim>& nodes) {
  constexpr std::int32_t found = 0;
  nodes.num_fields = weights.num_fields;
  nodes.active.assign(std::size_t{1} * nodes.num_fields * grid.num_nodes_total(), -1);
  for (const std::int32_t node : weights.group_nodes) nodes.active.at(node) = found;
  for (const std::int32_t node : others) nodes.active.at(node) = found;
  std::vector<std::int32_t> grid_nodes;
  nodes.active.for_each([&](std::size_t node, std::int32_t) {
    grid_nodes.push_back(static_cast<std::int32_t>(node));
  });
  number_nodes(comm, grid, std::move(grid_nodes), nodes);
  list_groups(weights, nodes);
}

template <int dim>
void list_groups(const PointWeights<dim>& weights, GridNodes<dim>& nodes) {
  nodes.of_groups.resize(weights.group_nodes.size());
  for (std::size_t k = 0; k < nodes.of_groups.size(); ++k) {
    nodes.of_groups[k] = nodes.active[weights.group_nodes[k]];
  }
}

template void list_groups<2>(const PointWeights<2>&, GridNodes<2>&);
template void list_groups<3>(const PointWeights<3>&, GridNodes<3>&);
template void number_nodes<2>(MPI_Comm, const BackgroundGrid<2>&, std::vector<std::int32_t>,
                              GridNodes<2>&);
template void number_nodes<3>(MPI_Comm, const BackgroundGrid<3>&, std::vector<std::int32_t>,
                              GridNodes<3>&);
template void activate_nodes<2>(MPI_Comm, const BackgroundGrid<2>&, const PointWeights<2>&,
                                std::span<const std::int32_t>, GridNodes<2>&);
template void activate_nodes<3>(MPI_Comm, const BackgroundGrid<3>&, const PointWeights<3>&,
                                std::span<const std::int32_t>, GridNodes<3>&);

}  // namespace gabion::mpm
