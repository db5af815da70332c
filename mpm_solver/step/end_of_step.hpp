// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/step/equilibrium.hpp"

namespace gabion::mpm {

/// Motion of the active nodes by their displacement in the step; without inertia nothing has a
/// velocity.
/// @param du  [m], num_nodes x dim
template <int dim>
NodalMotion<dim> nodal_motion(const Equilibrium<dim>& equilibrium, std::span<const double> du);

/// Make stresses and memory of the trial state those of the points.
/// @returns plastic work of this rank's points in the step [J]
template <int dim>
double accept_stresses(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                       MaterialPoints<dim>& points);

}  // namespace gabion::mpm
