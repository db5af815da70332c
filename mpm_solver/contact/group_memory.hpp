// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "common/run/state.hpp"

namespace gabion::mpm {

/// State of a contact node that was closed at the end of a step.
template <int dim>
struct RememberedNode {
  std::int32_t place = 0, pair = 0;         ///< as of GroupNode
  Vector<dim> force = Vector<dim>::Zero();  ///< of the step, on the second group [N]
  Vector<dim> slip = Vector<dim>::Zero();   ///< elastic, of the second group along the first [m]
  double gap = 0;                           ///< < 0 [m]
  double area = 0;                          ///< [m^2]
  double moved = 0;                         ///< how far the node's soil went in the step [m]
  double stored = 0;                        ///< in its springs [J]
};

/// Remembered nodes of a step, by place and pair.
template <int dim>
class GroupMemory {
 public:
  /// The node that was closed there, null: none.
  const RememberedNode<dim>* find(std::int32_t place, std::int32_t pair) const;
  /// @pre by place, then by pair
  void replace(std::vector<RememberedNode<dim>> nodes) { nodes_ = std::move(nodes); }
  const std::vector<RememberedNode<dim>>& nodes() const { return nodes_; }
  /// Remembered nodes of all ranks; no node is on two of them. @note Collective.
  GroupMemory of_all(MPI_Comm comm) const;
  /// @throws Error  not one of num_places or num_pairs, or one twice
  void visit_state(StateVisitor& visitor, const std::string& prefix, std::int32_t num_places,
                   std::int32_t num_pairs);

 private:
  static constexpr std::size_t width = 2 * dim + 4;  // values of a node
  struct NodeLists {
    std::vector<std::int64_t> where{};  // place and pair of each
    std::vector<double> values{};
  };
  void put(NodeLists& lists) const;
  void take(const NodeLists& lists);

  std::vector<RememberedNode<dim>> nodes_;
};

}  // namespace gabion::mpm
