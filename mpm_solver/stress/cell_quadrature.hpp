// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// Quadrature of the stresses over a cell: at its points, or as over the cell itself where it lies
/// inside the soil.
enum class Quadrature { points, cells };
const char* quadrature_name(Quadrature quadrature);

/// A cell holds soil, as far as CellQuadrature is concerned, where its points fill this share of
/// it.
inline constexpr double least_filling = 0.3;

/// 1 for the nodes of facets at the sides of the grid where soil may lose contact with the side: no
/// wall is there, or one that moves.
using OpenNodes = SparseList<char>;

template <int dim>
OpenNodes open_nodes(const BackgroundGrid<dim>& grid, const std::vector<WallSettings>& walls);

/// Lets the points of a cell inside the soil integrate a constant stress as the cell would,
///
///     sum_p V_p = V_cell ,   sum_p V_p grad N_ip = int_cell grad N_i dx                      (S35)
///
/// whatever places they have come to: volumes get a common factor, gradients a common change, so
/// linear fields are still met. A cell is inside when all cells around its nodes hold soil, sides
/// of the grid there have walls at rest, and its points are those of one body. It is meant for
/// linear functions, whose gradients jump from cell to cell: without it the error of a point that
/// crosses does not fall with the cell size. Refers to the grid.
/// @see Beuth, Wieckowski, Vermeer (2011), who have the volumes; Chen, Hillman, Rueter (2013) for
///      gradients
template <int dim>
class CellQuadrature {
 public:
  explicit CellQuadrature(const BackgroundGrid<dim>& grid);

  /// Change `volume` and `grad_N` of the entries of cells inside the soil.
  /// @param open   of the phase's walls
  /// @param nodes  as activated for these weights
  /// @note Collective.
  void correct(const OpenNodes& open, const MaterialPoints<dim>& points,
               const GridNodes<dim>& nodes, PointWeights<dim>& weights);
  /// Cells of this rank that the last correct() changed.
  std::int64_t num_inside() const { return num_inside_; }

 private:
  /// Entries of one body in one cell.
  struct Run {
    std::int32_t cell, first, last;
  };

  void list_runs(const MaterialPoints<dim>& points, const PointWeights<dim>& weights);
  void find_surrounded(const OpenNodes& open, const GridNodes<dim>& nodes);
  bool is_inside(std::int32_t cell, const GridNodes<dim>& nodes) const;
  std::int32_t cells_around(std::int32_t grid_node) const;
  double volume_of(std::int32_t cell) const;
  /// Means of the gradients of the cell's functions over the cell [1/m].
  using MeanGradients = std::array<Vector<dim>, max_cell_nodes>;
  MeanGradients mean_gradients(std::int32_t cell) const;
  void shift_gradients(const Run& run, const MaterialPoints<dim>& points,
                       PointWeights<dim>& weights) const;

  const BackgroundGrid<dim>& grid_;
  std::vector<std::uint16_t> cells_around_;  // of each grid node; empty: that of a box
  std::vector<double> volumes_;              // of each cell [m^3]; empty: those of a box
  std::optional<MeanGradients> of_box_;      // of any cell of a box
  std::vector<Run> runs_;
  SparseList<std::int32_t> bodies_;  // in each cell
  SparseList<double> filled_;        // of each cell [m^3]
  std::vector<char> surrounded_;  // 1 for active nodes that have soil or a wall at rest all around
  std::int64_t num_inside_ = 0;
};

}  // namespace gabion::mpm
