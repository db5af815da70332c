// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/ranks/shared_nodes.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

/// Most groups of bodies, which are bits of a number.
inline constexpr int most_groups = 32;

/// Groups of bodies that weigh on each node of the grid, and the numbers that the node has for
/// them: the first group keeps the number n of the node, the k-th other one gets n + k num_places.
/// A rank knows this for the nodes on which its own points weigh.
template <int dim>
class GroupsAtNodes {
 public:
  /// @param of_body     group of each body
  /// @param num_places  nodes of the grid
  /// @param weights     with numbers of the grid, or with those of split_groups
  /// @note Collective.
  GroupsAtNodes(MPI_Comm comm, std::span<const std::int32_t> of_body, std::int32_t num_places,
                const PointWeights<dim>& weights);

  /// Bit k: group k weighs on the node, its points on any rank.
  std::uint32_t at(std::int32_t place) const { return groups_[place]; }
  bool is_shared(std::int32_t place) const { return std::popcount(groups_[place]) > 1; }
  /// The number of a node for a group that weighs on it.
  std::int32_t node(std::int32_t place, std::int32_t group) const {
    const std::uint32_t before = groups_[place] & ((std::uint32_t{1} << group) - 1);
    return place + num_places_ * std::popcount(before);
  }
  /// Most groups of a node of any rank, at least 1.
  std::int32_t most() const { return most_; }
  /// Whether a node is this rank's: that of the lowest rank whose points weigh on it.
  bool owns(std::int32_t place) const;
  /// All numbers of the nodes of this rank that several groups weigh on.
  std::vector<std::int32_t> numbers_of_shared() const;

 private:
  std::int32_t num_places_;
  std::int32_t most_ = 1;
  SparseList<std::uint32_t> groups_;
  std::vector<std::int32_t> places_;  // of this rank, ascending; one rank: empty
  SharedNodes shared_;                // of places_
};

/// Give the bodies of each group nodes of their own where several groups weigh on a node.
/// @param weights  as evaluate_basis left them
/// @returns numbers of nodes that a rank needs, since it has another number of each: none on one
///          rank
/// @note Collective.
template <int dim>
std::vector<std::int32_t> split_groups(MPI_Comm comm, std::span<const std::int32_t> of_body,
                                       std::int32_t num_places, PointWeights<dim>& weights);

}  // namespace gabion::mpm
