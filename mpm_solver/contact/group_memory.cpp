// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_memory.hpp"

#include <algorithm>
#include <compare>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/gather.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
std::pair<std::int32_t, std::int32_t> key_of(const RememberedNode<dim>& node) {
  return {node.place, node.pair};
}

}  // namespace

template <int dim>
const RememberedNode<dim>* GroupMemory<dim>::find(std::int32_t place, std::int32_t pair) const {
  const auto found = std::ranges::lower_bound(nodes_, std::pair(place, pair), {}, key_of<dim>);
  return found != nodes_.end() && key_of(*found) == std::pair(place, pair) ? &*found : nullptr;
}

template <int dim>
GroupMemory<dim> GroupMemory<dim>::of_all(MPI_Comm comm) const {
  if (num_ranks(comm) == 1) return *this;
  NodeLists own;
  put(own);
  const NodeLists all{gather_on_all<std::int64_t>(comm, own.where),
                      gather_on_all<double>(comm, own.values)};
  GroupMemory result;
  result.take(all);
  return result;
}

template <int dim>
void GroupMemory<dim>::put(NodeLists& lists) const {
  for (const auto& node : nodes_) {
    lists.where.insert(lists.where.end(), {node.place, node.pair});
    lists.values.insert(lists.values.end(), node.force.begin(), node.force.end());
    lists.values.insert(lists.values.end(), node.slip.begin(), node.slip.end());
    lists.values.insert(lists.values.end(), {node.gap, node.area, node.moved, node.stored});
  }
}

template <int dim>
void GroupMemory<dim>::take(const NodeLists& lists) {
  nodes_.assign(lists.where.size() / 2, {});
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    auto& node = nodes_[k];
    node.place = static_cast<std::int32_t>(lists.where[2 * k]);
    node.pair = static_cast<std::int32_t>(lists.where[2 * k + 1]);
    const double* value = lists.values.data() + width * k;
    node.force = Eigen::Map<const Vector<dim>>(value);
    node.slip = Eigen::Map<const Vector<dim>>(value + dim);
    node.gap = value[2 * dim];
    node.area = value[2 * dim + 1];
    node.moved = value[2 * dim + 2];
    node.stored = value[2 * dim + 3];
  }
  std::ranges::sort(nodes_, {}, key_of<dim>);
}

template <int dim>
void GroupMemory<dim>::visit_state(StateVisitor& visitor, const std::string& prefix,
                                   std::int32_t num_places, std::int32_t num_pairs) {
  NodeLists lists;
  put(lists);
  auto& [where, values] = lists;
  visitor.list(prefix + "nodes", where);
  visitor.list(prefix + "node_values", values);
  require(where.size() % 2 == 0 && values.size() == width * (where.size() / 2),
          "saved state: {}nodes: found {} numbers and {} values, allowed: 2 and {} of each", prefix,
          where.size(), values.size(), width);
  for (std::size_t k = 0; k < where.size(); k += 2) {
    require(where[k] >= 0 && where[k] < num_places && where[k + 1] >= 0 && where[k + 1] < num_pairs,
            "saved state: {}nodes: found node {} of pair {}, allowed: below {} and {}", prefix,
            where[k], where[k + 1], num_places, num_pairs);
  }
  take(lists);
  require(std::ranges::adjacent_find(nodes_, {}, key_of<dim>) == nodes_.end(),
          "saved state: {}nodes: found a node twice", prefix);
}

template class GroupMemory<2>;
template class GroupMemory<3>;

}  // namespace gabion::mpm
