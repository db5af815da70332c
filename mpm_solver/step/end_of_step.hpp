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

/// Error of a step in time.
struct StepError {
  /// Newmark's local error, dt^2 |1/6 - beta| |a' - a| [m]: its mean over the mass, so that a few
  /// stray points do not rule it. What presses on an interface counts in full, by its root mean
  /// square: |a' - a|^2 = (sum_free m_i |a'_i - a_i| / M)^2 + sum_touched m_i |a'_i - a_i|^2 / M.
  double displacement = 0;
  double speed = 0;  ///< root mean square of v' over the mass [m/s]
};
/// @param motion   of nodal_motion()
/// @param touched  1 for nodes of points that touch an interface, at the owners of the nodes
/// @note Collective.
/// @see Zienkiewicz and Xie (1991), who take the root mean square everywhere
template <int dim>
StepError step_error(const Equilibrium<dim>& equilibrium, const NodalMotion<dim>& motion,
                     std::span<const char> touched);

}  // namespace gabion::mpm
