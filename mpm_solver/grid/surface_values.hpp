// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/grid/axis_basis.hpp"
#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// The functions of one material point at its surface under gimp or bspline
/// (docs/theory/interface.md (I9)): a traction there is in balance with the same stress in all
/// points of a regular row, wherever the lines of the grid cut it. Functions that are merely
/// continued from the point give nodes that the soil hardly reaches half the force that its stress
/// requires.
///
/// gimp: linear functions averaged over the side of the domain: around the place e = -l n, over the
/// part of the domain half lengths l (1 - |n|) along the axes. bspline: the Taylor series to the
/// surface, e = -R n, its second term as the rule of the points integrates: one point for each
/// length 2 R |n| from the knot behind.
template <int dim>
class SurfaceValues {
 public:
  /// @param p  a point in the grid
  SurfaceValues(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points, std::int32_t p);
  /// @param n       unit vector from the surface into the soil
  /// @param R       distance of the surface [m]
  /// @param[out] w  values of the point's nodes, in their order in PointWeights; they add up to one
  ///                and reproduce the place
  /// @returns e, where that is, seen from the point [m]
  Vector<dim> at(const Vector<dim>& n, double R, double* w) const;

 private:
  std::array<double, 3> along(int d, double e, double rest) const;

  Basis basis_;
  Vector<dim> t_;        // position by the spacing
  Vector<dim> l_;        // gimp: half lengths by the spacing, inside the grid
  Vector<dim> spacing_;  // [m]
  typename BoxGrid<dim>::Index cell_, num_cells_;
  AxisValues axes_[dim];
};

}  // namespace gabion::mpm
