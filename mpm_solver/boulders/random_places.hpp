// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "mpm_solver/boulders/boulders.hpp"
#include "mpm_solver/boulders/polygon.hpp"
#include "mpm_solver/boulders/random_sizes.hpp"
#include "mpm_solver/contact/sided_surface.hpp"

namespace gabion::mpm {

/// A box along the axes, or a polygon in the first two coordinates, in 3D between two heights.
template <int dim>
struct RandomRegion {
  Eigen::AlignedBox<double, dim> box;  ///< it, or that around the polygon [m]
  Polygon polygon;                     ///< in either direction, empty: the box

  double volume() const;  ///< 2D: area
  /// Whether a sphere lies in it.
  bool holds(const Vector<dim>& centre, double radius) const;
};

/// Places for spheres around boulders: in a region, apart from each other, from other boulders and
/// in front of interfaces and rigid walls as they are at time 0. One sphere is placed after the
/// other, each where the first draw has room (random sequential addition).
template <int dim>
class RandomPlaces {
 public:
  /// @param among  its boulders have their places
  /// @param apart  least distance between two surfaces [m]
  RandomPlaces(const RandomRegion<dim>& region, const BoulderScene<dim>& among, double apart);

  /// @throws ConfigError  no room after most_draws draws
  Vector<dim> draw(double radius, RandomNumbers& random);

  /// Draws without room, by reason.
  struct Rejected {
    int out_of_region = 0, at_boulder = 0, at_surface = 0;
    int total() const { return out_of_region + at_boulder + at_surface; }
  };
  const Rejected& rejected() const { return rejected_; }

  static constexpr int most_draws = 10000;

 private:
  struct Sphere {
    Vector<dim> centre;
    double radius;
  };
  int* refusal(const Sphere& sphere, Rejected& rejected) const;

  RandomRegion<dim> region_;
  double apart_;
  std::vector<Sphere> spheres_;
  std::vector<SidedSurface<dim>> surfaces_;
  Rejected rejected_;
};

}  // namespace gabion::mpm
