// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mpm_solver/grid_nodes.hpp"

namespace gabion::mpm {

/// Still walls along facets of the background grid.
struct WallSettings {
  std::string group;  ///< facet group of the grid
  bool fixed = true;  ///< all components; otherwise slip: the normal component only
  std::string where;  ///< file and pointer, for messages
};

/// The directions in which a wall lets a grid node move: the range of the projector Q.
template <int dim>
class WallConditions {
 public:
  WallConditions(const Mesh<dim>& grid, const std::vector<WallSettings>& walls);

  /// Whether a wall holds this node of the grid.
  bool holds(std::int32_t grid_node) const;

  /// Collect the constrained nodes among the active ones.
  void select(const GridNodes<dim>& nodes);

  const std::vector<std::int32_t>& constrained() const { return constrained_; }  ///< active numbers
  const std::vector<Matrix<dim>>& projectors() const { return projectors_; }

  /// Remove the constrained components: x_i <- Q_i x_i, num_nodes x dim.
  void project(std::span<double> x) const;

 private:
  std::vector<std::int32_t> grid_nodes_;
  std::vector<Matrix<dim>> grid_projectors_;
  std::vector<std::int32_t> constrained_;
  std::vector<Matrix<dim>> projectors_;
};

}  // namespace gabion::mpm
