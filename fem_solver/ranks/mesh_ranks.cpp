// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/ranks/mesh_ranks.hpp"

#include <algorithm>
#include <utility>

namespace gabion::fem {

namespace {

/// A held node is one of the group where any holder has a facet of the group at it.
std::vector<std::int32_t> nodes_of(const std::vector<std::int32_t>& facets,
                                   const SharedNodes& shared, std::size_t num_held) {
  std::vector<double> marks(num_held, 0.0);
  for (const std::int32_t i : facets) marks[i] = 1;
  shared.sum(marks, 1);
  std::vector<std::int32_t> nodes;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i] > 0) nodes.push_back(static_cast<std::int32_t>(i));
  }
  return nodes;
}

/// @param numbers  ascending
/// @returns        -1 where it is not among them
std::int32_t place_in(std::span<const std::int32_t> numbers, std::int32_t number) {
  const auto found = std::ranges::lower_bound(numbers, number);
  if (found == numbers.end() || *found != number) return -1;
  return static_cast<std::int32_t>(found - numbers.begin());
}

}  // namespace

MeshRanks::MeshRanks(MPI_Comm comm, PartNumbers numbers, const FacetGroups& groups)
    : comm_(comm), numbers_(std::move(numbers)), shared_(comm, numbers_.nodes, numbers_.num_nodes) {
  if (alone()) return;
  for (const auto& [name, group] : groups) {
    group_nodes_[name] = nodes_of(group, shared_, numbers_.nodes.size());
  }
}

std::int32_t MeshRanks::held_node(std::int32_t node_of_all) const {
  return alone() ? node_of_all : place_in(numbers_.nodes, node_of_all);
}

std::int32_t MeshRanks::held_cell(std::int32_t cell_of_all) const {
  return alone() ? cell_of_all : place_in(numbers_.cells, cell_of_all);
}

std::vector<std::int64_t> MeshRanks::owned_nodes(std::int32_t num_nodes) const {
  std::vector<std::int64_t> nodes;
  for (std::int32_t i = 0; i < num_nodes; ++i) {
    if (shared_.owns(i)) nodes.push_back(node_of_all(i));
  }
  return nodes;
}

std::vector<std::int64_t> MeshRanks::own_lines(std::int32_t num_lines) const {
  std::vector<std::int64_t> lines;
  for (std::int32_t l = 0; l < num_lines; ++l) lines.push_back(line_of_all(l));
  return lines;
}

std::vector<std::int64_t> MeshRanks::own_cells(std::int32_t num_cells) const {
  std::vector<std::int64_t> cells;
  for (std::int32_t c = 0; c < num_cells; ++c) cells.push_back(cell_of_all(c));
  return cells;
}

}  // namespace gabion::fem
