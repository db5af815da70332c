// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fem_solver/fem_config.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// The wider one of the crack of a state and an earlier one: mean width over the points of a cell.
/// @param earlier  kept where no crack of the state is wider
/// @param time     of the state [s]
/// @note Collective.
template <int dim>
WidestCrack wider_crack(const FemSettings<dim>& settings, const CellIntegrals<dim>& cells,
                        const StructureState& state, double time, const WidestCrack& earlier);

Json describe(const WidestCrack& crack, int dim);

}  // namespace gabion::fem
