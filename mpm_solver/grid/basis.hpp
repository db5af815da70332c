// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Largest number of nodes that act on the points of one cell: splines of a cell's two halves,
/// or domains that reach into the cells on both sides.
template <int dim>
inline constexpr int max_group_nodes = dim == 2 ? 16 : 64;

/// The points of one body that lie in one cell or in one patch of cells, which `cell` (the first of
/// the patch) stands for: entries first .. last of PointWeights. `first_node` and `num_nodes` name
/// the nodes that act on any of them in PointWeights::group_nodes.
struct CellGroup {
  std::int32_t cell = 0;
  std::int32_t body = 0;
  std::int32_t first = 0;
  std::int32_t last = 0;
  std::int32_t first_node = 0;
  std::int32_t num_nodes = 0;
};

/// The grid nodes of a group, and where they begin in PointWeights::group_nodes.
struct GroupNodes : std::span<const std::int32_t> {
  std::int32_t first = 0;
};

/// Basis functions at the material points, taken at the accepted positions and kept
/// through the step. Entries are sorted by body, (patch,) cell and point; entry e has the values
/// starts[e] .. starts[e + 1], one for each node that acts on its point.
template <int dim>
struct PointWeights {
  /// Triangles and tetrahedra with the linear basis, not in patches: all entries of a group have
  /// the group's nodes in their order, and the gradients of its first entry hold for all.
  bool constant_gradient = false;
  /// All nodes of a group act on each of its points, in their order: as many as a cell has corners.
  bool whole_cells = false;
  std::vector<std::int32_t> point;  ///< of each entry
  /// Stress-free volume over which each entry's stress is summed: V0 of its point, unless
  /// CellQuadrature changed it [m^3].
  std::vector<double> volume;
  std::vector<std::int32_t> starts;  ///< first value of each entry, and the number of values
  std::vector<std::uint8_t> local;   ///< of each value: its node's number within the group
  std::vector<double> N;             ///< of each value
  std::vector<Vector<dim>> grad_N;   ///< of each value [1/m]
  std::vector<CellGroup> groups;
  std::vector<std::int32_t> group_nodes;  ///< grid nodes of the groups
  std::vector<std::int32_t> body_groups;  ///< first group of each body, and the number of groups
  std::int32_t num_capped = 0;            ///< gimp: points whose domain would be wider than a cell
  /// Number of fields at the grid nodes: 2 where SideFields doubled some nodes, whose second
  /// numbers follow all first ones.
  std::int32_t num_fields = 1;

  /// Room for num_nodes values of each entry; no nodes of groups yet.
  void resize(std::int32_t num_entries, int num_nodes) {
    starts.resize(static_cast<std::size_t>(num_entries) + 1);
    for (std::int32_t e = 0; e <= num_entries; ++e) starts[e] = e * num_nodes;
    N.resize(static_cast<std::size_t>(num_entries) * num_nodes);
    grad_N.resize(N.size());
    local.resize(N.size());
    group_nodes.clear();
  }
  int num_nodes(std::int32_t entry) const { return starts[entry + 1] - starts[entry]; }
  const std::uint8_t* local_of(std::int32_t entry) const { return local.data() + starts[entry]; }
  const double* N_of(std::int32_t entry) const { return N.data() + starts[entry]; }
  const Vector<dim>* grad_of(std::int32_t entry) const { return grad_N.data() + starts[entry]; }
  GroupNodes nodes_of(const CellGroup& group) const {
    return {{group_nodes.data() + group.first_node, static_cast<std::size_t>(group.num_nodes)},
            group.first_node};
  }
};

template <int dim>
class SoilBorder;

/// Find the cell of each point, starting from the cell it was in.
/// @returns the points outside the grid, ascending; their cell is -1
template <int dim>
std::vector<std::int32_t> find_cells(const BackgroundGrid<dim>& grid, MaterialPoints<dim>& points);

/// Evaluate the basis at the points.
/// @pre the points are located; gimp: they have domains
/// @param border  where the soil ends, for a grid that splits_border; else null
template <int dim>
void evaluate_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                    PointWeights<dim>& weights, const SoilBorder<dim>* border = nullptr);

}  // namespace gabion::mpm
