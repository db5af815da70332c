// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh_part.hpp"
#include "common/mechanics/ranks/shared_nodes.hpp"

namespace gabion::fem {

/// Place of this rank's part of a mesh in the whole. Each cell belongs to one rank, which holds its
/// nodes. Nodal vectors are those of the held nodes, num_nodes x dim of the part, the same bits on
/// each holder. On one rank the part is the whole.
class MeshRanks {
 public:
  /// One rank, which has the whole mesh.
  MeshRanks() = default;
  /// @param groups   nodes of the part's facet and node groups; the same names on all ranks
  /// @note Collective.
  MeshRanks(MPI_Comm comm, PartNumbers numbers, const FacetGroups& groups);

  bool alone() const { return shared_.alone(); }
  MPI_Comm comm() const { return comm_; }
  const SharedNodes& shared() const { return shared_; }

  /// Number of a node or cell of the part in the whole.
  std::int32_t node_of_all(std::int32_t i) const { return alone() ? i : numbers_.nodes[i]; }
  std::int32_t cell_of_all(std::int32_t c) const { return alone() ? c : numbers_.cells[c]; }
  std::int32_t line_of_all(std::int32_t l) const { return alone() ? l : numbers_.lines[l]; }
  /// Numbers in the whole of the held nodes, ascending.
  template <int dim>
  std::vector<std::int32_t> held_nodes(const Mesh<dim>& part) const {
    if (!alone()) return numbers_.nodes;
    std::vector<std::int32_t> nodes(part.nodes.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
  }
  /// Node of the part with this number in the whole, -1: not held.
  std::int32_t held_node(std::int32_t node_of_all) const;
  /// Cell of the part with this number in the whole, -1: another rank's.
  std::int32_t held_cell(std::int32_t cell_of_all) const;
  /// Numbers in the whole of the nodes that this rank owns, ascending. @param num_nodes  held
  std::vector<std::int64_t> owned_nodes(std::int32_t num_nodes) const;
  /// Numbers in the whole of the cells of the part, ascending.
  std::vector<std::int64_t> own_cells(std::int32_t num_cells) const;
  /// Numbers in the whole of the lines of the part, ascending.
  std::vector<std::int64_t> own_lines(std::int32_t num_lines) const;
  /// Cells of the part, then lines, whose numbers follow those of all cells.
  template <int dim>
  std::vector<std::int64_t> own_elements(const Mesh<dim>& part) const {
    std::vector<std::int64_t> elements = own_cells(part.num_cells());
    for (const std::int64_t l : own_lines(part.num_lines())) {
      elements.push_back(num_cells_of_all(part) + l);
    }
    return elements;
  }
  /// Values of the nodes that this rank owns, in their order. @param values  of the held ones
  template <class Value>
  std::vector<Value> owned(std::vector<Value> values, int width) const {
    if (alone()) return values;
    std::vector<Value> own;
    own.reserve(shared_.owned().size() * width);
    for (const std::int32_t i : shared_.owned()) {
      const auto first = values.begin() + static_cast<std::ptrdiff_t>(i) * width;
      own.insert(own.end(), first, first + width);
    }
    return own;
  }

  template <int dim>
  std::int32_t num_nodes_of_all(const Mesh<dim>& part) const {
    return alone() ? part.num_nodes_total() : numbers_.num_nodes;
  }
  template <int dim>
  std::int32_t num_cells_of_all(const Mesh<dim>& part) const {
    return alone() ? part.num_cells() : numbers_.num_cells;
  }
  template <int dim>
  std::int32_t num_lines_of_all(const Mesh<dim>& part) const {
    return alone() ? part.num_lines() : numbers_.num_lines;
  }

  /// Held nodes of a group of facets or nodes, ascending, whichever rank has its facets.
  /// @throws ConfigError  see Mesh::group_nodes
  template <int dim>
  std::vector<std::int32_t> group_nodes(const Mesh<dim>& part, const std::string& group,
                                        const std::string& where) const {
    const auto found = group_nodes_.find(group);
    return found == group_nodes_.end() ? part.group_nodes(group, where) : found->second;
  }
  /// Numbers in the whole mesh of the part's facets of a group; they ascend. @pre not alone
  std::span<const std::int64_t> facet_numbers(const std::string& group) const {
    return numbers_.facets.at(group);
  }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  PartNumbers numbers_;
  SharedNodes shared_;
  std::map<std::string, std::vector<std::int32_t>> group_nodes_;  // one rank: none
};

}  // namespace gabion::fem
