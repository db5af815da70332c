// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"

namespace gabion::mpm {

/// U_xx, U_yy (U_zz) of the right stretch tensor U, F = R U: the stretch of the material fibres
/// along the axes, whatever the rotation.
/// @see Charlton, Coombs, Augarde (2017)
template <int dim>
Vector<dim> axis_stretches(const Matrix<dim>& F);

/// Carry the domains of the points through an accepted step,
///
///     l_d <- s U_dd l_d ,  U that of F = 1 + sum_i du_i (x) grad N_i ,  prod_d (s U_dd) = det F
///
/// so a domain keeps the volume of its point, and shear does not widen it. Nothing happens to
/// points without domains.
/// @param du  displacement increment of the active nodes [m]   num_nodes x dim
template <int dim>
void deform_points(const GridNodes<dim>& nodes, std::span<const double> du,
                   const PointWeights<dim>& weights, MaterialPoints<dim>& points);

}  // namespace gabion::mpm
