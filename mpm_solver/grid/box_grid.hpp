// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::mpm {

/// Equal axis-aligned rectangles or bricks in rows, nodes and cells numbered along x first, then y,
/// then z, as `box_mesh` does: all that a mesh would store follows by arithmetic, to the same bits.
template <int dim>
struct BoxGrid {
  using Index = Eigen::Matrix<int, dim, 1>;
  static constexpr CellType cell_type = dim == 2 ? CellType::quad4 : CellType::hex8;

  BoxGrid() = default;
  /// @throws ConfigError  high <= low, less than one cell, more nodes than 32-bit indices can count
  BoxGrid(const Vector<dim>& low_, const Vector<dim>& high_, const Index& num_cells_);

  Vector<dim> low, high;  ///< opposite corners [m]
  Index num_cells;        ///< along each axis
  Vector<dim> spacing;    ///< size of a cell along each axis [m]
  Vector<dim> tolerance;  ///< by the spacing: 1e-12 and the rounding of the coordinates

  std::int32_t num_cells_total() const { return num_cells.prod(); }
  std::int32_t num_nodes_total() const { return (num_cells.array() + 1).prod(); }

  /// Position by the spacing, 0 .. num_cells along each axis.
  Vector<dim> lattice_position(const Vector<dim>& x) const {
    return (x - low).cwiseQuotient(spacing);
  }
  /// Cell that contains x, or -1; on a face between two cells the lower one, as CellLocator has it.
  std::int32_t locate(const Vector<dim>& x) const;
  /// All cells that contain x, ascending: several where x lies on a facet, edge or node.
  std::vector<std::int32_t> cells_at(const Vector<dim>& x) const;
  /// Place of a cell along each axis.
  Index cell_index(std::int32_t cell) const;
  std::int32_t node(const Index& at) const;
  Vector<dim> node_position(std::int32_t node) const;  ///< [m]

  using CellNodes = std::array<std::int32_t, (1 << dim)>;
  CellNodes cell_nodes(std::int32_t cell) const;
  /// Cells before and after a cell along the axes; -1 beyond the grid.
  std::array<std::int32_t, 2 * dim> neighbours(std::int32_t cell) const;
  /// The cells that have this node.
  std::vector<std::int32_t> cells_around(std::int32_t node) const;
  int num_cells_around(std::int32_t node) const;
  bool at_side(std::int32_t cell) const;  ///< of the grid
  /// Shortest edge of a cell [m].
  double shortest_edge(std::int32_t cell) const;
  /// The facets of the sides, by the names that `box_mesh` gives them.
  FacetGroups sides() const;
};

/// The rows of a quad4 or hex8 mesh as `box_mesh` numbers it, told by every node and cell; none for
/// any other mesh.
template <int dim>
std::optional<BoxGrid<dim>> box_grid(const Mesh<dim>& mesh);

}  // namespace gabion::mpm
