// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"

namespace gabion::mpm {

/// What becomes of a material point that leaves the background grid.
enum class Outside { error, remove };

/// Looks out for material points that a step carries out of the background grid.
template <int dim>
class GridExits {
 public:
  explicit GridExits(const BackgroundGrid<dim>& grid);

  struct Exit {
    std::int32_t point = -1;  ///< of this rank; -1: none leaves
    Vector<dim> x;            ///< where it would be [m]
  };
  /// The first point of this rank that the increment du [m], num_nodes x dim, would carry out. Only
  /// points in cells at the edge, or with a long way to go, are looked at.
  Exit first(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
             const GridNodes<dim>& nodes, std::span<const double> du) const;

  /// Facet group of the grid whose facet is nearest to x, by centres; empty when there is none.
  std::string nearest_group(const Vector<dim>& x) const;

 private:
  const BackgroundGrid<dim>& grid_;
  std::vector<bool> at_edge_;  // of each cell: has a node of an outer facet
  double safe_distance_;       // [m] that does not carry a point out of an inner cell
};

}  // namespace gabion::mpm
