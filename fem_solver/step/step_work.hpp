// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "fem_solver/step/equilibrium.hpp"

namespace gabion::fem {

/// Work of loads and interface forces on the free components in a step [J]: by the trapezoidal
/// rule, of mean forces F . du.
/// @note Collective, as the others.
template <int dim>
double work_of_loads(const Equilibrium<dim>& equilibrium, const BoundaryConditions<dim>& conditions,
                     const StructureState& state_n, const StructureState& trial,
                     std::span<const double> du);

/// Work of supports that move, and of all else that acts on their components [J]: of the mean
/// internal force in the step, and of the change of momentum there on the mean velocity. The
/// reactions at the ends of a step do not give it: they bear mean forces, which jump from step to
/// step, and the jumps of a ramp. With both functions kinetic and elastic energy of a linear
/// structure change by the work under the trapezoidal rule; to rounding where the accelerations of
/// supports do not reach their neighbours through a consistent mass.
/// @param trial  complete, with its velocity at the end of the step
template <int dim>
double work_of_supports(const Equilibrium<dim>& equilibrium,
                        const BoundaryConditions<dim>& conditions, const StructureState& state_n,
                        const StructureState& trial, bool dynamic);

/// Work of supports that are not at zero at time 0 while all other nodes are [J]: the elastic
/// energy of the cells beside them. Warns of it.
template <int dim>
double work_before_start(const Equilibrium<dim>& equilibrium,
                         const BoundaryConditions<dim>& conditions, const StructureState& state);

}  // namespace gabion::fem
