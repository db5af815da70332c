// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/group_fields.hpp"

#include <algorithm>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/grid/node_bits.hpp"

namespace gabion::mpm {

template <int dim>
GroupsAtNodes<dim>::GroupsAtNodes(MPI_Comm comm, std::span<const std::int32_t> of_body,
                                  std::int32_t num_places, const PointWeights<dim>& weights)
    : num_places_(num_places), groups_(num_places, 0) {
  for (const CellGroup& group : weights.groups) {
    const std::uint32_t bit = std::uint32_t{1} << of_body[group.body];
    for (const std::int32_t node : weights.nodes_of(group)) {
      std::uint32_t& groups = groups_.at(node % num_places);
      groups |= bit;
      most_ = std::max(most_, static_cast<std::int32_t>(std::popcount(groups)));
    }
  }
  if (num_ranks(comm) == 1) return;
  groups_.for_each([&](std::size_t place, std::uint32_t) {
    places_.push_back(static_cast<std::int32_t>(place));
  });
  shared_ = SharedNodes(comm, places_, num_places);
  join_bits(comm, shared_, std::span<const std::int32_t>(places_), groups_);
  for (const std::int32_t place : places_) {
    most_ = std::max(most_, static_cast<std::int32_t>(std::popcount(groups_[place])));
  }
  max_over_ranks(comm, std::span<std::int32_t>(&most_, 1));
}

template <int dim>
bool GroupsAtNodes<dim>::owns(std::int32_t place) const {
  if (shared_.alone()) return true;
  const auto found = std::ranges::lower_bound(places_, place);
  return found != places_.end() && *found == place &&
         shared_.owns(static_cast<std::int32_t>(found - places_.begin()));
}

template <int dim>
std::vector<std::int32_t> GroupsAtNodes<dim>::numbers_of_shared() const {
  std::vector<std::int32_t> numbers;
  for (const std::int32_t place : places_) {
    if (!is_shared(place)) continue;
    for (int k = 0; k < std::popcount(groups_[place]); ++k) {
      numbers.push_back(place + k * num_places_);
    }
  }
  return numbers;
}

template <int dim>
std::vector<std::int32_t> split_groups(MPI_Comm comm, std::span<const std::int32_t> of_body,
                                       std::int32_t num_places, PointWeights<dim>& weights) {
  const GroupsAtNodes<dim> at_nodes(comm, of_body, num_places, weights);
  if (at_nodes.most() == 1) return {};
  for (const CellGroup& group : weights.groups) {
    for (std::int32_t k = 0; k < group.num_nodes; ++k) {
      std::int32_t& node = weights.group_nodes[group.first_node + k];
      node = at_nodes.node(node, of_body[group.body]);
    }
  }
  weights.num_fields = at_nodes.most();
  return at_nodes.numbers_of_shared();
}

template class GroupsAtNodes<2>;
template class GroupsAtNodes<3>;
template std::vector<std::int32_t> split_groups<2>(MPI_Comm, std::span<const std::int32_t>,
                                                   std::int32_t, PointWeights<2>&);
template std::vector<std::int32_t> split_groups<3>(MPI_Comm, std::span<const std::int32_t>,
                                                   std::int32_t, PointWeights<3>&);

}  // namespace gabion::mpm
