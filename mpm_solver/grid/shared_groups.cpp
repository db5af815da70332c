// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/shared_groups.hpp"

#include <algorithm>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// Number the groups that several ranks have, in the order of body and cell.
template <int dim>
void number_shared(MPI_Comm comm, std::int32_t num_cells, PointWeights<dim>& weights) {
  const std::size_t num_bodies = weights.body_groups.size() - 1;
  std::vector<std::int32_t> number(num_bodies * num_cells, 0);
  const auto key = [&](const CellGroup& group) {
    return static_cast<std::size_t>(group.body) * num_cells + group.cell;
  };
  for (const CellGroup& group : weights.groups) number[key(group)] = 1;
  sum_over_ranks(comm, std::span<std::int32_t>(number));
  weights.num_shared = 0;
  for (std::int32_t& ranks : number) ranks = ranks > 1 ? weights.num_shared++ : -1;
  weights.shared.clear();
  for (const CellGroup& group : weights.groups) weights.shared.push_back(number[key(group)]);
}

// Nodes of each shared group on all ranks: ascending, each once.
template <int dim>
std::vector<std::vector<std::int32_t>> unite_nodes(MPI_Comm comm,
                                                   const PointWeights<dim>& weights) {
  constexpr std::size_t width = max_group_nodes<dim>;
  const std::size_t size = width * weights.num_shared;
  std::vector<std::int32_t> own(size, -1), all(size * num_ranks(comm));
  for (std::size_t g = 0; g < weights.groups.size(); ++g) {
    if (weights.shared[g] < 0) continue;
    const auto nodes = weights.nodes_of(weights.groups[g]);
    std::copy(nodes.begin(), nodes.end(), own.begin() + width * weights.shared[g]);
  }
  MPI_Allgather(own.data(), static_cast<int>(size), MPI_INT32_T, all.data(), static_cast<int>(size),
                MPI_INT32_T, comm);
  std::vector<std::vector<std::int32_t>> united(weights.num_shared);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all[k] >= 0) united[k % size / width].push_back(all[k]);
  }
  for (auto& nodes : united) {
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    require(nodes.size() <= width, "mpm_solver: more nodes act on a group than were foreseen");
  }
  return united;
}

// Replace the nodes of one group by the united ones.
template <int dim>
void take_nodes(const std::vector<std::int32_t>& united, const CellGroup& group,
                PointWeights<dim>& weights) {
  std::uint8_t place[max_group_nodes<dim>];
  const auto before = weights.nodes_of(group);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto found = std::lower_bound(united.begin(), united.end(), before[i]);
    place[i] = static_cast<std::uint8_t>(found - united.begin());
  }
  for (std::int32_t k = weights.starts[group.first]; k < weights.starts[group.last]; ++k) {
    weights.local[k] = place[weights.local[k]];
  }
}

}  // namespace

template <int dim>
void share_groups(MPI_Comm comm, std::int32_t num_cells, PointWeights<dim>& weights) {
  if (num_ranks(comm) == 1) return;
  number_shared(comm, num_cells, weights);
  if (weights.num_shared == 0) return;
  const auto united = unite_nodes(comm, weights);
  std::vector<std::int32_t> group_nodes;
  for (std::size_t g = 0; g < weights.groups.size(); ++g) {
    CellGroup& group = weights.groups[g];
    const auto before = weights.nodes_of(group);
    const auto first_node = static_cast<std::int32_t>(group_nodes.size());
    if (weights.shared[g] < 0) {
      group_nodes.insert(group_nodes.end(), before.begin(), before.end());
    } else {
      const auto& nodes = united[weights.shared[g]];
      take_nodes(nodes, group, weights);
      group_nodes.insert(group_nodes.end(), nodes.begin(), nodes.end());
    }
    group.first_node = first_node;
    group.num_nodes = static_cast<std::int32_t>(group_nodes.size()) - first_node;
  }
  // The spans of the loop refer to the old list.
  weights.group_nodes = std::move(group_nodes);
}

template void share_groups<2>(MPI_Comm, std::int32_t, PointWeights<2>&);
template void share_groups<3>(MPI_Comm, std::int32_t, PointWeights<3>&);

}  // namespace gabion::mpm
