// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

/// Memory of what grows with the soil [bytes], sums over the ranks, as large as in an implicit
/// step: material points, their weights on the nodes, their trial state, nodes, the values of the
/// stiffness with PETSc's list of their columns, its pattern, the preconditioner. On several ranks
/// the stiffness stands for its own parts and for PETSc's rows.
/// @note Collective.
template <int dim>
Json memory_by_field(const SoilModel<dim>& model, const SoilState<dim>& state,
                     const SoilStep<dim>& step);

}  // namespace gabion::mpm
