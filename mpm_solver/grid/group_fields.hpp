// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

/// Groups of bodies are bits of a number.
inline constexpr int most_groups = 32;

/// Which groups of bodies weigh on each node of the grid, and the numbers that the node has for
/// them: the first group keeps the number n of the node, the k-th other one gets n + k num_places.
template <int dim>
class GroupsAtNodes {
 public:
  /// @param of_body     group of each body
  /// @param num_places  nodes of the grid
  /// @param weights     with numbers of the grid, or with those of split_groups
  GroupsAtNodes(std::span<const std::int32_t> of_body, std::int32_t num_places,
                const PointWeights<dim>& weights);

  /// Bit k: group k weighs on the node.
  std::uint32_t at(std::int32_t place) const { return groups_[place]; }
  bool is_shared(std::int32_t place) const { return std::popcount(groups_[place]) > 1; }
  /// The number of a node for a group that weighs on it.
  std::int32_t node(std::int32_t place, std::int32_t group) const {
    const std::uint32_t before = groups_[place] & ((std::uint32_t{1} << group) - 1);
    return place + num_places_ * std::popcount(before);
  }
  /// Most groups of a node, at least 1.
  std::int32_t most() const { return most_; }

 private:
  std::int32_t num_places_;
  std::int32_t most_ = 1;
  SparseList<std::uint32_t> groups_;
};

/// Give the bodies of each group nodes of their own where several groups weigh on a node.
/// @param weights  as evaluate_basis left them
template <int dim>
void split_groups(std::span<const std::int32_t> of_body, std::int32_t num_places,
                  PointWeights<dim>& weights);

}  // namespace gabion::mpm
