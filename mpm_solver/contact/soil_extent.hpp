// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "mpm_solver/contact/index_table.hpp"
#include "mpm_solver/contact/soil_surface.hpp"

namespace gabion::mpm {

/// Where the soil of a step is, found once for all contacts of the step. Refers to the points and
/// weights of the soil, whose positions do not change in the step.
template <int dim>
class SoilExtent {
 public:
  using Box = Eigen::AlignedBox<double, dim>;

  /// @note Collective over soil.comm.
  explicit SoilExtent(const SoilSurface<dim>& soil);

  /// Largest speed of a point or a node of any rank [m/s].
  double fastest() const { return fastest_; }
  /// Edge of a cube of the volume of the largest point of any rank [m].
  double widest() const { return widest_; }

  /// The groups of the weights that have points of this rank in a box, ascending; and groups whose
  /// own box alone meets it. An infinite box has all groups.
  std::vector<std::int32_t> groups_in(const Box& box) const;

 private:
  using Index = typename IndexTable<dim>::Key;
  void find_boxes() const;
  Index cube_of(const Vector<dim>& x) const;

  const MaterialPoints<dim>& points_;
  const PointWeights<dim>& weights_;
  double fastest_ = 0, widest_ = 0;
  Box all_;  // around all points of this rank
  // Found when they are first asked for.
  mutable std::vector<Box> boxes_;  // around the points of each group
  mutable double cube_ = 0;         // edge of the cubes in which the middles of boxes_ are [m]
  mutable Vector<dim> half_ = Vector<dim>::Zero();  // the largest half lengths of boxes_ [m]
  mutable IndexTable<dim> cubes_;
  mutable std::vector<std::int32_t> starts_, in_cubes_;  // groups of each cube
};

}  // namespace gabion::mpm
