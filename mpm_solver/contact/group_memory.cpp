// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_memory.hpp"

#include <algorithm>
#include <compare>
#include <utility>

#include "common/base/require.hpp"

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
void GroupMemory<dim>::visit_state(StateVisitor& visitor, const std::string& prefix,
                                   std::int32_t num_places, std::int32_t num_pairs) {
  constexpr std::size_t width = 2 * dim + 4;
  std::vector<std::int64_t> where;
  std::vector<double> values;
  for (const auto& node : nodes_) {
    where.insert(where.end(), {node.place, node.pair});
    values.insert(values.end(), node.force.begin(), node.force.end());
    values.insert(values.end(), node.slip.begin(), node.slip.end());
    values.insert(values.end(), {node.gap, node.area, node.moved, node.stored});
  }
  visitor.list(prefix + "nodes", where);
  visitor.list(prefix + "node_values", values);
  const std::size_t count = where.size() / 2;
  require(where.size() % 2 == 0 && values.size() == width * count,
          "saved state: {}nodes: found {} numbers and {} values, allowed: 2 and {} of each", prefix,
          where.size(), values.size(), width);
  nodes_.assign(count, {});
  for (std::size_t k = 0; k < count; ++k) {
    auto& node = nodes_[k];
    require(where[2 * k] >= 0 && where[2 * k] < num_places && where[2 * k + 1] >= 0 &&
                where[2 * k + 1] < num_pairs,
            "saved state: {}nodes: found node {} of pair {}, allowed: below {} and {}", prefix,
            where[2 * k], where[2 * k + 1], num_places, num_pairs);
    node.place = static_cast<std::int32_t>(where[2 * k]);
    node.pair = static_cast<std::int32_t>(where[2 * k + 1]);
    const double* value = values.data() + width * k;
    node.force = Eigen::Map<const Vector<dim>>(value);
    node.slip = Eigen::Map<const Vector<dim>>(value + dim);
    node.gap = value[2 * dim];
    node.area = value[2 * dim + 1];
    node.moved = value[2 * dim + 2];
    node.stored = value[2 * dim + 3];
    require(k == 0 || key_of(nodes_[k - 1]) < key_of(node),
            "saved state: {}nodes: found a node out of order", prefix);
  }
}

template class GroupMemory<2>;
template class GroupMemory<3>;

}  // namespace gabion::mpm
