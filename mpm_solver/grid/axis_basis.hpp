// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace gabion::mpm {

/// Values along one axis of a BoxGrid at one place: nodes first .. first + count - 1. The basis in
/// the plane and in space is their product. All functions are non-negative inside the grid, add up
/// to one and reproduce the coordinate.
struct AxisValues {
  int first = 0;
  int count = 2;
  double N[3] = {};
  double dN[3] = {};  ///< by t
};

/// A domain that reaches beyond a node by less than this, by the spacing, does so by rounding: the
/// next node, whose value would be below 1e-24, is left out.
inline constexpr double reach_by_rounding = 1e-12;

/// Linear functions.
/// @param t     position by the spacing, in the cell
/// @param cell  0 .. num_cells - 1, cell <= t <= cell + 1
inline AxisValues linear_values(double t, int cell) {
  const double s = t - cell;
  return {cell, 2, {1 - s, s}, {-1, 1}};
}

/// Half length of the domain that gimp_values takes, by the spacing: it stays inside the grid.
inline double gimp_half_length(double t, double l, int num_cells) {
  return std::min({l, t, num_cells - t});
}

/// Linear functions averaged over the domain t - l .. t + l of a point, and the averages'
/// derivatives,
///
///     N_i = 1 / (2 l) int_{t - l}^{t + l} hat(r - i) dr
///
/// The half length l is cut to the distance from the end of the grid, so that the domain stays
/// inside.
/// @param l          half length of the domain by the spacing, 0 <= l <= 1/2
/// @param num_cells  of the axis
/// @see   Bardenhagen, Kober (2004)
inline AxisValues gimp_values(double t, double l, int cell, int num_cells) {
  l = gimp_half_length(t, l, num_cells);
  const bool reaches_before = cell > 0 && t - l < cell - reach_by_rounding;
  const bool reaches_after = cell + 1 < num_cells && t + l > cell + 1 + reach_by_rounding;
  if (!reaches_before && !reaches_after) return linear_values(t, cell);
  const int node = reaches_before ? cell : cell + 1;  // between the two cells
  const double a = t - l - node, b = t + l - node;    // the domain's ends, from there
  const double before = a * a / (4 * l), after = b * b / (4 * l);
  const double d_before = a / (2 * l), d_after = b / (2 * l);
  return {
      node - 1, 3, {before, 1 - before - after, after}, {d_before, -d_before - d_after, d_after}};
}

/// Quadratic B-splines centred at the nodes. At the end of the grid the spline of the node beyond
/// is given to the last two, N_0 += 2 N_-1, N_1 -= N_-1, which continues a linear field: the half
/// cell at the wall is linear, and the node on the wall alone carries its value.
/// @see   Steffen, Kirby, Berzins (2008)
inline AxisValues bspline_values(double t, int cell, int num_cells) {
  const int node = t - cell < 0.5 ? cell : cell + 1;
  const double z = t - node;
  if (node == 0) return linear_values(t, 0);
  if (node == num_cells) return linear_values(t, num_cells - 1);
  if (std::abs(z) > 0.5 - reach_by_rounding) return linear_values(t, cell);
  return {node - 1,
          3,
          {0.5 * (0.5 - z) * (0.5 - z), 0.75 - z * z, 0.5 * (0.5 + z) * (0.5 + z)},
          {z - 0.5, -2 * z, z + 0.5}};
}

}  // namespace gabion::mpm
