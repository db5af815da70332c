// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::mpm {

/// Equal axis-aligned rectangles or bricks in rows, nodes and cells numbered along x first, then y,
/// then z: where a point lies follows by arithmetic.
template <int dim>
struct BoxGrid {
  using Index = Eigen::Matrix<int, dim, 1>;

  Vector<dim> low;        ///< corner with the smallest coordinates [m]
  Vector<dim> spacing;    ///< size of a cell along each axis [m]
  Index num_cells;        ///< along each axis
  Vector<dim> tolerance;  ///< by the spacing: 1e-12 and the rounding of the coordinates

  /// Position by the spacing, 0 .. num_cells along each axis.
  Vector<dim> lattice_position(const Vector<dim>& x) const {
    return (x - low).cwiseQuotient(spacing);
  }
  /// Cell that contains x, or -1; on a face between two cells the lower one, as CellLocator has it.
  std::int32_t locate(const Vector<dim>& x) const;
  /// Place of a cell along each axis.
  Index cell_index(std::int32_t cell) const;
  std::int32_t node(const Index& at) const;
};

/// The rows of a quad4 or hex8 mesh as `box_mesh` numbers it, told by every node and cell; none for
/// any other mesh.
template <int dim>
std::optional<BoxGrid<dim>> box_grid(const Mesh<dim>& mesh);

}  // namespace gabion::mpm
