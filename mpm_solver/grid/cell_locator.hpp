// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::mpm {

/// Finds the cell that contains a point: walks from a guess over the facets, and searches bins of
/// equal size when the walk leaves the mesh or the guess is of no use.
///
/// A point is in a cell when its distance from the outside of each facet is at least
/// -(1e-12 h + 16 eps X); h is the height of the cell over the facet and X the largest coordinate
/// of the mesh. A point in the interior of a cell has one answer, whatever the guess; a point
/// within a thousand tolerances of a facet goes to the lowest of the cells that contain it.
template <int dim>
class CellLocator {
 public:
  /// Keeps a reference to the mesh, which must outlive the locator and must not change.
  /// @throws ConfigError  a cell without positive volume, a facet with more than two cells
  explicit CellLocator(const Mesh<dim>& mesh);

  /// Cell that contains x, or -1. @param hint  cell to start from; -1 when there is none
  std::int32_t locate(const Vector<dim>& x, std::int32_t hint) const;

  /// All cells that contain x, ascending: several where x lies on a facet, edge or node.
  std::vector<std::int32_t> cells_at(const Vector<dim>& x) const;

  /// Reference coordinates of x in a cell. Affine cells (simplices, parallelograms, bricks):
  /// direct, valid outside the cell too; other quads and hexes: Newton's method.
  /// @throws Error  Newton's method finds none (a point far from a distorted cell)
  Vector<dim> local_coordinates(std::int32_t cell, const Vector<dim>& x) const;

  /// The cell on the other side of each facet of a cell; -1 outside.
  std::span<const std::int32_t> neighbours(std::int32_t cell) const;

 private:
  /// xi = inverse (x - origin); for cells that are not affine, the linear part at the centre.
  struct Map {
    Vector<dim> origin;
    Matrix<dim> inverse;
    double tolerance;  ///< of the relative distances of `nearest_facet`
  };
  struct Nearest {
    int facet;
    double distance;  ///< to the facet by the cell's height, negative outside
  };

  void make_maps();
  void make_bins();
  void fill_bins(const std::vector<std::pair<Vector<dim>, Vector<dim>>>& boxes);
  Eigen::Matrix<int, dim, 1> bin_of(const Vector<dim>& x) const;
  Vector<dim> affine_coordinates(std::int32_t cell, const Vector<dim>& x) const;
  bool newton_coordinates(std::int32_t cell, const Vector<dim>& x, Vector<dim>& xi) const;
  Nearest nearest_facet(const Vector<dim>& xi) const;
  Nearest nearest_facet(std::int32_t cell, const Vector<dim>& x) const;
  std::int32_t walk(const Vector<dim>& x, std::int32_t cell) const;
  std::int32_t search_bins(const Vector<dim>& x) const;
  bool in_bounds(const Vector<dim>& x) const;
  /// Cells whose bounds, a little widened, share the bin of x, ascending. @pre in_bounds(x)
  std::span<const std::int32_t> candidates(const Vector<dim>& x) const;
  bool contains(std::int32_t cell, const Vector<dim>& x) const;

  const Mesh<dim>& mesh_;
  bool simplex_;
  int facets_per_cell_;
  std::vector<Map> maps_;
  std::vector<char> affine_;
  std::vector<std::int32_t> neighbours_;

  Vector<dim> low_, high_;  // of the mesh, widened by the tolerance
  Vector<dim> bins_per_length_;
  Eigen::Matrix<int, dim, 1> num_bins_;
  std::vector<std::int32_t> bin_starts_;
  std::vector<std::int32_t> bin_cells_;  // of each bin, ascending
};

}  // namespace gabion::mpm
