// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/mesh/boundary.hpp"
#include "mpm_solver/grid/box_grid.hpp"
#include "mpm_solver/grid/cell_locator.hpp"
#include "mpm_solver/grid/cell_patches.hpp"

namespace gabion::mpm {

/// Basis functions of the nodes that carry the points: linear on any mesh; on a BoxGrid also those
/// of axis_basis.hpp.
enum class Basis { linear, gimp, bspline };
const char* basis_name(Basis basis);

/// The nodes of a cell or the cells beside it.
class CellList {
 public:
  CellList() = default;
  template <class List>
  explicit CellList(const List& list) : size_(list.size()) {
    for (std::size_t i = 0; i < size_; ++i) values_[i] = list[i];
  }
  std::size_t size() const { return size_; }
  const std::int32_t* begin() const { return values_.data(); }
  const std::int32_t* end() const { return values_.data() + size_; }
  std::int32_t operator[](std::size_t i) const { return values_[i]; }

 private:
  std::size_t size_ = 0;
  std::array<std::int32_t, max_cell_nodes> values_;
};

/// Cells of any shape, which have to be stored, and where a position lies in them.
template <int dim>
struct StoredCells {
  explicit StoredCells(Mesh<dim> mesh_) : mesh(std::move(mesh_)), locator(mesh) {}

  Mesh<dim> mesh;
  CellLocator<dim> locator;
};

/// The background grid: cells that stay where they are, and their basis. A box is never stored: all
/// values follow by arithmetic.
template <int dim>
struct BackgroundGrid {
  /// A grid without cells.
  BackgroundGrid() = default;
  explicit BackgroundGrid(const BoxGrid<dim>& box_, Basis basis_ = Basis::linear);
  /// A mesh that is a BoxGrid is taken as one; its facet groups are kept.
  /// @throws Error  gimp or bspline on a mesh that is no BoxGrid
  explicit BackgroundGrid(Mesh<dim> mesh, Basis basis_ = Basis::linear);

  CellType cell_type = BoxGrid<dim>::cell_type;
  std::optional<BoxGrid<dim>> box;
  /// Cells of a grid that is no box; copies share it, since it never changes.
  std::shared_ptr<const StoredCells<dim>> stored;
  FacetGroups facet_groups;
  Basis basis = Basis::linear;
  CellPatches patches;  ///< cells whose points form one group; empty: each cell for itself
  /// Cells at the border of the soil have a group for each half (SoilBorder): bspline with F-bar.
  bool splits_border = false;

  std::int32_t num_cells() const { return box ? box->num_cells_total() : stored->mesh.num_cells(); }
  std::int32_t num_nodes_total() const {
    return box ? box->num_nodes_total() : stored->mesh.num_nodes_total();
  }
  int nodes_per_cell() const { return num_nodes(cell_type); }
  bool is_simplex() const { return nodes_per_cell() == dim + 1; }

  CellList cell(std::int32_t c) const {
    return box ? CellList(box->cell_nodes(c)) : CellList(stored->mesh.cell(c));
  }
  Vector<dim> node(std::int32_t n) const {
    return box ? box->node_position(n) : stored->mesh.nodes[n];
  }
  /// Positions of the nodes of a cell [m]. @param[out] x  nodes_per_cell()
  void corners(std::int32_t c, Vector<dim>* x) const;
  /// The cell on the other side of each facet of a cell; -1 outside.
  CellList neighbours(std::int32_t c) const;
  /// Nodes of a facet of a cell, normal outward.
  CellList facet(std::int32_t c, int f) const;

  /// The cell that holds x, sought from the cell `hint` on; -1 outside the grid.
  std::int32_t locate(const Vector<dim>& x, std::int32_t hint) const {
    return box ? box->locate(x) : stored->locator.locate(x, hint);
  }
  /// All cells that contain x, ascending: several where x lies on a facet, edge or node.
  std::vector<std::int32_t> cells_at(const Vector<dim>& x) const {
    return box ? box->cells_at(x) : stored->locator.cells_at(x);
  }
  /// Reference coordinates of x in a cell, see CellLocator.
  Vector<dim> local_coordinates(std::int32_t c, const Vector<dim>& x) const;

  /// The first cell of the cell's patch; without patches the cell itself.
  std::int32_t first_of_patch(std::int32_t c) const {
    return patches.size() > 0 ? patches.first_of[c] : c;
  }
  /// Place that decides which rank has the points of a cell: the centre of the cell, or of the
  /// first cell of its patch [m].
  Vector<dim> home(std::int32_t c) const;
};

/// Shortest distance between two nodes of a cell [m].
template <int dim>
double shortest_edge(const BackgroundGrid<dim>& grid, std::int32_t cell);

/// Mean of shortest_edge() over the cells [m].
template <int dim>
double mean_cell_size(const BackgroundGrid<dim>& grid);

/// Box along the axes around all nodes [m].
template <int dim>
Eigen::AlignedBox<double, dim> bounding_box(const BackgroundGrid<dim>& grid);

template <int dim>
double cell_volume(const BackgroundGrid<dim>& grid, std::int32_t cell);

/// @param facets  num_facets x num_nodes(facet_type(cell_type)) grid nodes
template <int dim>
std::vector<FacetGeometry<dim>> facet_geometry(const BackgroundGrid<dim>& grid,
                                               std::span<const std::int32_t> facets);

}  // namespace gabion::mpm
