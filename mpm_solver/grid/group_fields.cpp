// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/group_fields.hpp"

#include <algorithm>

namespace gabion::mpm {

template <int dim>
GroupsAtNodes<dim>::GroupsAtNodes(std::span<const std::int32_t> of_body, std::int32_t num_places,
                                  const PointWeights<dim>& weights)
    : num_places_(num_places), groups_(num_places, 0) {
  for (const CellGroup& group : weights.groups) {
    const std::uint32_t bit = std::uint32_t{1} << of_body[group.body];
    for (const std::int32_t node : weights.nodes_of(group)) {
      std::uint32_t& groups = groups_.at(node % num_places);
      groups |= bit;
      most_ = std::max(most_, static_cast<std::int32_t>(std::popcount(groups)));
    }
  }
}

template <int dim>
void split_groups(std::span<const std::int32_t> of_body, std::int32_t num_places,
                  PointWeights<dim>& weights) {
  const GroupsAtNodes<dim> at_nodes(of_body, num_places, weights);
  if (at_nodes.most() == 1) return;
  for (const CellGroup& group : weights.groups) {
    for (std::int32_t k = 0; k < group.num_nodes; ++k) {
      std::int32_t& node = weights.group_nodes[group.first_node + k];
      node = at_nodes.node(node, of_body[group.body]);
    }
  }
  weights.num_fields = at_nodes.most();
}

template class GroupsAtNodes<2>;
template class GroupsAtNodes<3>;
template void split_groups<2>(std::span<const std::int32_t>, std::int32_t, PointWeights<2>&);
template void split_groups<3>(std::span<const std::int32_t>, std::int32_t, PointWeights<3>&);

}  // namespace gabion::mpm
