// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Inertial number of a cell, h |grad v| sqrt(rho / |tau|), at which its noise is damped half as
/// fast: below, soil deforms quasi-statically, far above it flows. @see GDR MiDi (2004)
inline constexpr double inertial_number_of_flow = 0.02;

/// Rate at which the noise of the points is damped.
struct NoiseDamping {
  double damping = 0;                        ///< d
  double dt = 0;                             ///< [s]
  double cell_size = 0;                      ///< h [m]
  std::span<const double> pool_pressures{};  ///< p_e of the points [Pa]; empty: there are no pools

  /// Share of its noise that a point loses in a step,
  ///
  ///     eta = 1 - exp(-d dt c / h / (1 + (I / inertial_number_of_flow)^2))
  ///     c^2 = |tau + J p_e| / rho ,  I = h |grad v| / c
  ///
  /// Noise of the speed c has as much kinetic energy as the stress. The kinks of a flow over a
  /// floor or at a shear band look like noise, but lie in cells of large I and persist. Points that
  /// fly without stress lose nothing. What a pool adds to the stress changes no motion under it.
  /// @param c2     c^2 [m^2/s^2]
  /// @param grad2  |grad v|^2 of the velocity mapped to the nodes [1/s^2]
  double share(double c2, double grad2) const;
};

/// Damp the velocities of the material points that their nodes do not see (FLIP's noise),
///
///     v -= (1 - S R) eta (1 - S R) v ,  R = mass-weighted mean at the nodes, S = interpolation to
///     the points ,  grad v = grad S R v
///
/// which is nearly the whole of what varies within a cell and nothing of a field of second order
/// over evenly laid points: no viscosity, unlike PIC's share. S R is symmetric in the masses, with
/// eigenvalues from 0 to 1: momentum is kept, energy falls, also where points of unequal eta meet.
/// @pre  the nodes have the masses of these weights; velocities of points, not their places, may be
///       newer. @note Collective.
/// @see Hammerquist and Nairn (2017), XPIC of order 2
template <int dim>
void damp_noise(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                const NoiseDamping& rate, MaterialPoints<dim>& points);

}  // namespace gabion::mpm
