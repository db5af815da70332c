// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/ranks/shared_nodes.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

/// The nodes of the step on this rank: those that act on one of its material points, and those that
/// its contacts and cures of small cuts need besides, numbered in the order of the grid. Each acts
/// on a material point of some rank.
template <int dim>
struct GridNodes {
  std::vector<std::int32_t> grid_node;  ///< of each active node
  SparseList<std::int32_t> active;      ///< of each grid node; -1 = not active on this rank
  std::vector<std::int32_t> of_groups;  ///< active numbers of PointWeights::group_nodes
  std::vector<Vector<dim>> x;           ///< position [m]
  std::vector<double> m;                ///< mass [kg]
  std::vector<Vector<dim>>
      v;  ///< velocity mapped from the points [m/s]; InelasticProjection changes it
  std::vector<Vector<dim>> a;   ///< acceleration mapped from the points [m/s^2]
  SharedNodes shared;           ///< with other ranks
  std::int32_t num_fields = 1;  ///< as of PointWeights
  std::int32_t num_places = 0;  ///< nodes of the grid, doubled ones counted once

  /// Active numbers of the nodes of a group.
  void list_active(const GroupNodes& group, std::int32_t* numbers) const {
    std::copy_n(of_groups.data() + group.first, group.size(), numbers);
  }
  /// Values of a nodal field at the nodes of a group, dim each. @param field  size() x dim
  void gather(const GroupNodes& group, std::span<const double> field, double* values) const {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const std::ptrdiff_t node = of_groups[group.first + i];
      for (int d = 0; d < dim; ++d) values[i * dim + d] = field[node * dim + d];
    }
  }
  /// The node of the grid at the place of an active node.
  std::int32_t place(std::int32_t i) const { return grid_node[i] % num_places; }
  /// Whether SideFields doubled it.
  bool is_doubled(std::int32_t i) const {
    if (num_fields == 1) return false;
    return grid_node[i] >= num_places || active[grid_node[i] + num_places] >= 0;
  }
  std::int32_t size() const { return static_cast<std::int32_t>(grid_node.size()); }
  /// Number of the active nodes of all ranks, each counted once.
  std::int64_t num_of_all() const { return shared.alone() ? size() : shared.num_of_all(); }
};

/// Mass of the nodes of all ranks [kg].
template <int dim>
double total_mass(const GridNodes<dim>& nodes) {
  double total = 0;
  for (std::int32_t i = 0; i < nodes.size(); ++i) total += nodes.shared.owns(i) ? nodes.m[i] : 0;
  return nodes.shared.total(total);
}

/// Number the active nodes: those of the points of this rank and the others that it needs.
/// @param others  grid nodes that are active on some rank, in any order
/// @note Collective.
template <int dim>
void activate_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                    const PointWeights<dim>& weights, std::span<const std::int32_t> others,
                    GridNodes<dim>& nodes);

/// List the active numbers of the nodes of the groups: after nodes were numbered or joined.
template <int dim>
void list_groups(const PointWeights<dim>& weights, GridNodes<dim>& nodes);

/// Number these grid nodes as the active ones. @param grid_nodes  ascending, each once
/// @note Collective.
template <int dim>
void number_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                  std::vector<std::int32_t> grid_nodes, GridNodes<dim>& nodes);

}  // namespace gabion::mpm
