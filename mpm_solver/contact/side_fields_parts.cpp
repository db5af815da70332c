// SPDX-License-Identifier: BSD-3-Clause
// How groups of points near thin walls are parted.
#include <algorithm>
#include <numeric>
#include <utility>

#include "mpm_solver/contact/side_fields.hpp"

namespace gabion::mpm {

namespace {

// Give the entries of a group another order.
template <int dim>
void reorder(const CellGroup& group, std::span<const std::int32_t> order,
             PointWeights<dim>& weights) {
  const PointWeights<dim> old = [&] {
    PointWeights<dim> part;
    const auto copy = [&](const auto& from, auto& to, std::int32_t first, std::int32_t last) {
      to.assign(from.begin() + first, from.begin() + last);
    };
    const std::int32_t begin = weights.starts[group.first], end = weights.starts[group.last];
    copy(weights.point, part.point, group.first, group.last);
    copy(weights.volume, part.volume, group.first, group.last);
    copy(weights.starts, part.starts, group.first, group.last + 1);
    copy(weights.local, part.local, begin, end);
    copy(weights.N, part.N, begin, end);
    copy(weights.grad_N, part.grad_N, begin, end);
    for (std::int32_t& start : part.starts) start -= begin;
    return part;
  }();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::int32_t from = order[k], to = group.first + static_cast<std::int32_t>(k);
    const std::int32_t first = weights.starts[to];
    weights.point[to] = old.point[from];
    weights.volume[to] = old.volume[from];
    const int n = old.num_nodes(from);
    std::copy_n(old.local_of(from), n, weights.local.begin() + first);
    std::copy_n(old.N_of(from), n, weights.N.begin() + first);
    std::copy_n(old.grad_of(from), n, weights.grad_N.begin() + first);
    weights.starts[to + 1] = first + n;
  }
}

}  // namespace

// The groups of points that see the doubled nodes of a group in the same way, with their nodes.
template <int dim>
void SideFields<dim>::part(const CellGroup& group, NearGroup& near, PointWeights<dim>& weights,
                           PointWeights<dim>& parted) const {
  const auto nodes = weights.nodes_of(group);
  Sides doubled = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (is_doubled(nodes[k])) doubled |= Sides{1} << k;
  }
  for (Sides& sides : near.sides) sides &= doubled;
  std::vector<std::int32_t> order(near.sides.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::int32_t e) { return near.sides[e]; });
  if (!std::ranges::is_sorted(order)) reorder<dim>(group, order, weights);
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    const Sides sides = near.sides[order[from]];
    while (to < order.size() && near.sides[order[to]] == sides) ++to;
    CellGroup own = group;
    own.first = group.first + static_cast<std::int32_t>(from);
    own.last = group.first + static_cast<std::int32_t>(to);
    own.first_node = static_cast<std::int32_t>(parted.group_nodes.size());
    std::uint8_t number[max_group_nodes<dim>];
    const auto begin = weights.local.begin() + weights.starts[own.first];
    const auto end = weights.local.begin() + weights.starts[own.last];
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (std::find(begin, end, static_cast<std::uint8_t>(k)) == end) continue;
      number[k] = static_cast<std::uint8_t>(parted.group_nodes.size() - own.first_node);
      const bool far = (sides >> k & 1) != 0;
      parted.group_nodes.push_back(nodes[k] + (far ? grid_.num_nodes_total() : 0));
    }
    own.num_nodes = static_cast<std::int32_t>(parted.group_nodes.size()) - own.first_node;
    std::transform(begin, end, begin, [&](std::uint8_t k) { return number[k]; });
    parted.groups.push_back(own);
  }
}

// Part the groups near thin walls, and keep the others.
template <int dim>
void SideFields<dim>::part_groups(PointWeights<dim>& weights) {
  PointWeights<dim> parted;
  parted.body_groups.push_back(0);
  auto near = near_.begin();
  for (std::size_t b = 0; b + 1 < weights.body_groups.size(); ++b) {
    for (std::int32_t g = weights.body_groups[b]; g < weights.body_groups[b + 1]; ++g) {
      if (near != near_.end() && near->group == g) {
        part(weights.groups[g], *near++, weights, parted);
        continue;
      }
      const auto nodes = weights.nodes_of(weights.groups[g]);
      parted.groups.push_back(weights.groups[g]);
      parted.groups.back().first_node = static_cast<std::int32_t>(parted.group_nodes.size());
      parted.group_nodes.insert(parted.group_nodes.end(), nodes.begin(), nodes.end());
    }
    parted.body_groups.push_back(static_cast<std::int32_t>(parted.groups.size()));
  }
  weights.groups = std::move(parted.groups);
  weights.group_nodes = std::move(parted.group_nodes);
  weights.body_groups = std::move(parted.body_groups);
  weights.num_fields = 2;
}

template class SideFields<2>;
template class SideFields<3>;

}  // namespace gabion::mpm
