// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "mpm_solver/grid/outer_point.hpp"
#include "mpm_solver/points/pool.hpp"
#include "mpm_solver/small_cuts/weak_nodes.hpp"
#include "mpm_solver/step/soil_on_grid.hpp"

namespace gabion::mpm {

/// Pressures that are given at nodes.
struct DrainedNodes {
  std::vector<std::int32_t> nodes;  ///< active numbers, ascending
  std::vector<double> q;            ///< unknown of SeepageForces there [Pa]
};

/// Where pore water that drains leaves the soil: walls that are drained and the free surface.
/// Refers to the model.
template <int dim>
class SeepageBorders {
 public:
  explicit SeepageBorders(const SoilModel<dim>& model);

  /// Whether a body has a seepage face.
  bool open() const { return !with_seepage_face_.empty(); }
  /// Points of these bodies at which the soil ends in air, in the accepted state. @note Collective.
  std::vector<OuterPoint<dim>> free_surface(const SoilState<dim>& state, std::size_t phase);

  /// Water beyond the walls of a step.
  struct Beyond {
    std::size_t phase;        ///< number
    double time;              ///< at the end of the step [s]
    Vector<dim> gravity;      ///< then [m/s^2]
    const PoolLevels& pools;  ///< then
  };
  /// The water beyond drained walls is at rest, below the level of pools, or else the table of the
  /// soil.
  DrainedNodes drained_nodes(const GridNodes<dim>& nodes, const Beyond& beyond) const;

 private:
  const SoilModel<dim>& model_;
  std::vector<std::int32_t> with_seepage_face_;  // bodies
  std::optional<FacetSights<dim>> sights_;       // none: no surface, or no seepage face
};

}  // namespace gabion::mpm
