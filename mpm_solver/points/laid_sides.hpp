// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// A side of the cell that a point was laid in, with the row of the cell's points next to it.
template <int dim>
struct LaidSide {
  Vector<dim> normal = Vector<dim>::Zero();  ///< of length 1, into the cell
  double depth = 0;                          ///< of the point below the side [m]
  double area = 0;                           ///< of the side, the point's share by volume [m^2]
  /// Vector from the mean place of the row's points to the middle of the side, across its normal
  /// [m]. A linear traction has the resultant of its values at the points, shifted by this vector.
  Vector<dim> shift = Vector<dim>::Zero();
};

/// The sides of its cell whose row a point belongs to: it is as near to them as any point of the
/// cell. A side that is warped counts with its mean plane.
/// @param number  of the point in its body
/// @param of_rectangles_only  none of a cell whose sides do not meet at right angles, to 1e-6
template <int dim>
std::vector<LaidSide<dim>> laid_sides(const PointLayout<dim>& layout, std::int64_t number,
                                      bool of_rectangles_only = false);

/// Largest depth of the row of points next to a side, over the rectangular cells whose rows are at
/// different depths [m]; 0 where those are squares or cubes.
template <int dim>
double deepest_uneven_row(const PointLayout<dim>& layout);

}  // namespace gabion::mpm
