// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Share that `damping` a crossing takes in so many crossings, whole or not.
double damped_share(double damping, double crossings);

/// Damp the velocities of the material points that their nodes do not see (FLIP's noise),
///
///     v -= (1 - S R) eta (1 - S R) v ,  R = mass-weighted mean at the nodes, S = interpolation to
///     the points
///
/// which is nearly the whole of what varies within a cell and nothing of a field of second order
/// over evenly laid points: no viscosity, unlike PIC's share. S R is symmetric in the masses, with
/// eigenvalues from 0 to 1: momentum is kept, energy falls, also where points of unequal eta meet.
/// @param share  eta of each point, from 0 to 1
/// @pre  the nodes have the masses of these weights; velocities of points, not their places, may be
///       newer. @note Collective.
/// @see Hammerquist and Nairn (2017), XPIC of order 2
template <int dim>
void damp_noise(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                std::span<const double> share, MaterialPoints<dim>& points);

}  // namespace gabion::mpm
