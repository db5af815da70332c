// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mpm_solver/grid/cell_owners.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

/// The border of the soil, for the groups of points whose volumes are averaged under splines
/// (docs/theory/soil.md, F-bar). Along each axis on which a cell has a neighbour without points,
/// its points form a group for each half of it. The knots of splines lie in the middle of cells.
/// The mean over a whole cell would not see the motion of the splines beyond the border, in the
/// half cell before it.
///
/// Cells at the sides of the grid count as borders only where a neighbour in the grid is empty:
/// there are no splines beyond a side. Refers to the grid.
template <int dim>
class SoilBorder {
 public:
  /// @param occupied  1 for the cells of this rank that hold a point of any body
  /// @note Collective: ranks learn of the occupied cells beside their own ones.
  SoilBorder(const CellOwners<dim>& owners, SparseList<char> occupied);

  /// Number of parts of a cell: halves along each axis.
  static constexpr int num_parts = 1 << dim;
  /// Bit d: the cell has a neighbour without points along axis d.
  int axes(std::int32_t cell) const;

 private:
  void exchange(const CellOwners<dim>& owners);

  const BoxGrid<dim>& box_;
  SparseList<char> occupied_;
};

/// Bit d: x lies in the upper half of the cell along axis d.
template <int dim>
int part_of_cell(const BoxGrid<dim>& box, std::int32_t cell, const Vector<dim>& x);

/// 1 for each cell of the grid with a point of this rank, else 0. @pre all points are in the grid
template <int dim>
SparseList<char> cells_with_points(const BackgroundGrid<dim>& grid,
                                   const MaterialPoints<dim>& points);

/// Part the groups of cells at the border into their halves.
/// @param[in,out] weights  `point` and `groups` as sorted by cell
template <int dim>
void split_groups(const SoilBorder<dim>& border, const BoxGrid<dim>& box,
                  const MaterialPoints<dim>& points, PointWeights<dim>& weights);

}  // namespace gabion::mpm
