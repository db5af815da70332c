// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "fem_solver/step/equilibrium.hpp"

namespace gabion::fem {

inline bool is_zero(double x) {
  return x == 0;
}

/// Coordinates of the nodes that this rank owns [m].
template <int dim>
std::vector<double> coordinates_of(const FemSettings<dim>& settings);

/// Weight of the structure by node [N]; rotations have none.
template <int dim>
std::vector<double> gravity_forces(const FemSettings<dim>& settings,
                                   const Equilibrium<dim>& equilibrium);

/// Whether neither loads nor forces within the structure, such as pretension, act in the reference
/// state. @note Collective.
template <int dim>
bool is_without_forces(const StructureState& reference, Equilibrium<dim>& equilibrium);

}  // namespace gabion::fem
