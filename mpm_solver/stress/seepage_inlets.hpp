// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "mpm_solver/grid/outer_point.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// A side of the grid, a box, through which a given volume of water enters the soil.
struct FedSide {
  int axis = 0;       ///< across the side
  bool high = false;  ///< at the upper end of the axis
  double rate = 0;    ///< volume by time and area, negative: water is drawn out [m/s]
};

/// Places at sides of the grid where water enters the soil whatever its pressure: at the points
/// next to a side, between which and the side no other one has room. Valid for one step.
template <int dim>
class SeepageInlets {
 public:
  /// Data of the step.
  struct Step {
    Vector<dim> gravity = Vector<dim>::Zero();  ///< at its end [m/s^2]
    double dt = 0;                              ///< [s]
  };
  /// @pre points with domains
  SeepageInlets(const StressParts<dim>& parts, const BackgroundGrid<dim>& grid,
                std::span<const FedSide> sides, const Step& step);

  /// Water that enters at a group.
  struct Fed {
    double volume = 0;   ///< less what is drawn out [m^3]
    double leaving = 0;  ///< what is drawn out [m^3]
    double work = 0;     ///< of the pressure there on `volume` [J]
  };
  /// Take what enters at a group from the volumes that are missing at the nodes.
  /// @param q       unknowns of the group's nodes, as of SeepageForces [Pa]
  /// @param active  their numbers
  /// @param r       num_nodes [m^3]
  Fed add(const CellGroup& group, const double* q, const std::int32_t* active,
          std::vector<double>& r) const;

 private:
  struct Inlet {
    std::int32_t entry = 0;
    std::array<double, dim == 2 ? 9 : 27> w = {};  // of the nodes of the entry
    double at_rest = 0;                            // pressure that q leaves out there [Pa]
    double volume = 0;                             // in the step [m^3]
  };

  const PointWeights<dim>& weights_;
  std::vector<Inlet> inlets_;  // ascending entries
};

/// Area of the surface of a point. Of each column or row of the points' domains, whichever is
/// steeper to the surface, one point is at the surface, so the areas seen along an axis add up to
/// the whole. Points without domains are cubes.
template <int dim>
double surface_area(const MaterialPoints<dim>& points, const OuterPoint<dim>& at);

}  // namespace gabion::mpm
