// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"

namespace gabion::mpm {

/// Finds material points that a step carries out of the background grid.
template <int dim>
class GridExits {
 public:
  explicit GridExits(const BackgroundGrid<dim>& grid);

  struct Exit {
    std::int32_t point = -1;  ///< of this rank; -1: none leaves
    Vector<dim> x;            ///< where it would be [m]
  };
  using Refuse = std::function<bool(const Exit& exit)>;
  /// The first point of this rank that the increment du [m], num_nodes x dim, would carry out and
  /// that is to be refused. Only points in cells at the edge, or with a long displacement, are
  /// looked at.
  Exit first(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
             const GridNodes<dim>& nodes, std::span<const double> du, const Refuse& refuse) const;

  /// Facet groups of the side through which the straight path from a place in a cell to one outside
  /// leaves the grid, by name; empty: that side has none.
  std::vector<std::string> sides(const Vector<dim>& from, std::int32_t cell,
                                 const Vector<dim>& to) const;

 private:
  bool at_edge(std::int32_t cell) const;
  double distance(std::span<const std::int32_t> facets, const Vector<dim>& x) const;

  const BackgroundGrid<dim>& grid_;
  std::vector<bool> at_edge_;        // of each stored cell: has a node of an outer facet
  double safe_distance_;             // [m] that does not carry a point out of an inner cell
  std::vector<std::int32_t> outer_;  // facets
  double longest_ = 0;               // diagonal of a cell [m]
};

}  // namespace gabion::mpm
