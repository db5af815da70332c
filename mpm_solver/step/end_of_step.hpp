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

/// Error of a step in time, as root mean squares over the mass.
struct StepError {
  /// Newmark's local error, dt^2 |1/6 - beta| |a' - a| [m], without the hundredth of the mass where
  /// it is largest: a few stray points do not decide it. Points in contact with an interface always
  /// count.
  double displacement = 0;
  double speed = 0;  ///< of v' [m/s]
};
/// @param motion   of nodal_motion()
/// @param touched  1 for nodes of points in contact with an interface, at the owners of the nodes
/// @note Collective.
/// @see Zienkiewicz and Xie (1991), who leave nothing out
template <int dim>
StepError step_error(const Equilibrium<dim>& equilibrium, const NodalMotion<dim>& motion,
                     std::span<const char> touched);

}  // namespace gabion::mpm
