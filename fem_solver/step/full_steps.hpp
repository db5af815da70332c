// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/petsc/linear_solver.hpp"
#include "fem_solver/step/equilibrium.hpp"

namespace gabion::fem {

/// Newton's method with full steps and a new matrix each, until a line search can take over. A
/// slender beam that bends in a step is stretched by it, so that |r| grows before it falls, and a
/// line search would cut all steps. If these steps do not get there, du stays.
/// @param equilibrium  of a step that has begun
/// @param linear       with its regime
/// @returns  number of steps
template <int dim>
int take_full_steps(Equilibrium<dim>& equilibrium, BlockMatrix<dim>& K, LinearSolver<dim>& linear,
                    std::vector<double>& du);

/// The settings of a solver that keeps its factor, see with_kept_factor(); for beams always a
/// direct method, since iterative ones do not suit rotations.
template <int dim>
LinearSolverSettings full_step_solver(const FemSettings<dim>& settings);

}  // namespace gabion::fem
