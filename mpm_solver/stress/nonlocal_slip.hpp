// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/stress/softening_average.hpp"

namespace gabion::mpm {

/// Set the slip of the points, internal[1], from their softening strains, internal[0], for bodies
/// whose average acts: at the start of a step, for which kbar then stays as it is. kbar has the
/// integral of kappa over the body. The balance on the nodes of the step is
///
///     sum_J [M_I delta_IJ + l^2 sum_p V_p grad N_I . grad N_J] kbar_J = sum_p V_p N_I kappa_p
///
/// with M_I = sum_p V_p N_I: no flux through the surface of the body.
/// @throws ConvergenceError  it was not solved
/// @note Collective.
template <int dim>
void set_nonlocal_slip(SofteningAverages averages, const PointWeights<dim>& weights,
                       const GridNodes<dim>& nodes, MaterialPoints<dim>& points);

}  // namespace gabion::mpm
