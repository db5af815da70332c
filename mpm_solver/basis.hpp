// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/cell_locator.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "mpm_solver/material_points.hpp"

namespace gabion::mpm {

/// The background grid: a mesh that stays where it is, and where a position lies in it.
template <int dim>
struct BackgroundGrid {
  explicit BackgroundGrid(Mesh<dim> mesh_) : mesh(std::move(mesh_)), locator(mesh) {}
  BackgroundGrid(const BackgroundGrid&) = delete;  // locator refers to mesh
  BackgroundGrid& operator=(const BackgroundGrid&) = delete;
  BackgroundGrid(BackgroundGrid&&) = delete;
  BackgroundGrid& operator=(BackgroundGrid&&) = delete;
  ~BackgroundGrid() = default;

  Mesh<dim> mesh;
  CellLocator<dim> locator;
};

/// Mean over the cells of the shortest distance between two nodes of a cell [m].
template <int dim>
double mean_cell_size(const Mesh<dim>& mesh);

/// The points of one body that lie in one cell: entries first .. last of PointWeights.
struct CellGroup {
  std::int32_t cell = 0;
  std::int32_t body = 0;
  std::int32_t first = 0;
  std::int32_t last = 0;
};

/// Shape functions of the grid at the material points, taken at the accepted positions and kept
/// through the step. Entries are sorted by body, cell and point.
template <int dim>
struct PointWeights {
  int nodes_per_cell = 0;
  bool constant_gradient =
      false;  ///< triangles and tetrahedra: gradients of the group's first entry hold
  std::vector<std::int32_t> point;  ///< of each entry
  std::vector<double> N;            ///< num_entries x nodes_per_cell
  std::vector<Vector<dim>> grad_N;  ///< [1/m], as N; filled for the first entry of a group only
                                    ///< when constant_gradient
  std::vector<CellGroup> groups;
  std::vector<std::int32_t> body_groups;  ///< first group of each body, and the number of groups

  const double* N_of(std::int32_t entry) const {
    return N.data() + static_cast<std::size_t>(entry) * nodes_per_cell;
  }
  const Vector<dim>* grad_of(std::int32_t entry) const {
    return grad_N.data() + static_cast<std::size_t>(entry) * nodes_per_cell;
  }
};

/// Find the cell of each point (starting from the cell it was in) and evaluate the basis there.
/// @throws Error  a point lies outside the grid; names id and position of the first one
template <int dim>
void locate_points(const BackgroundGrid<dim>& grid, MaterialPoints<dim>& points);
template <int dim>
void evaluate_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                    PointWeights<dim>& weights);

}  // namespace gabion::mpm
