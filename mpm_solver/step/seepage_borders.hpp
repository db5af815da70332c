// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "mpm_solver/grid/outer_point.hpp"
#include "mpm_solver/points/pool.hpp"
#include "mpm_solver/small_cuts/weak_nodes.hpp"
#include "mpm_solver/step/soil_on_grid.hpp"
#include "mpm_solver/stress/seepage_inlets.hpp"

namespace gabion::mpm {

/// Pressures that are given at nodes.
struct DrainedNodes {
  std::vector<std::int32_t> nodes;  ///< active numbers, ascending
  std::vector<double> q;            ///< unknown of SeepageForces there [Pa]
  std::vector<double> p;            ///< pressure there [Pa]
};

/// Borders through which pore water leaves the soil: drained walls and the free surface.
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
  /// Sides of the grid through which water is given to the soil, or taken.
  std::vector<FedSide> fed_sides(std::size_t phase) const;
  /// Volume of rain by area across it, along gravity [m/s].
  Vector<dim> rain_at(double time) const;

 private:
  const SoilModel<dim>& model_;
  std::vector<std::int32_t> with_seepage_face_;  // bodies
  std::optional<FacetSights<dim>> sights_;       // none: no surface, or no seepage face
};

}  // namespace gabion::mpm
