// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mpm_solver/step/linear_system.hpp"

namespace gabion::mpm {

/// Start of Newton's method.
struct FirstGuess {
  std::vector<double> du;  ///< [m], num_nodes x dim
  std::int64_t linear_iterations = 0;
};

/// The first guess: free flight; quasi-static: rest, but for the motion of walls, which spreads
/// over the soil by the stiffness at the start. Where elastic waves cross many cells in a step,
/// flight and rest are tried and the smaller residual decides: there the guess matters more than
/// its cost.
/// @param wave_speed  largest of the bodies [m/s]
/// @note Collective.
template <int dim>
FirstGuess first_guess(Equilibrium<dim>& equilibrium, LinearSystem<dim>& system, double wave_speed,
                       PhaseTimes& times);

}  // namespace gabion::mpm
