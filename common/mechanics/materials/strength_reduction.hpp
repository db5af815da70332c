// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/mechanics/materials/material.hpp"

namespace gabion {

/// The law with its strength divided by `factor`: c / F, tan phi / F, tan psi / F. The apex c cot
/// phi, a tension cut-off and the elastic constants stay, associated flow remains associated, and
/// psi never exceeds phi. With factor 1 it is the law itself.
/// @param factor  > 0
/// @returns nothing for a law whose strength cannot be reduced: all but `mohr_coulomb`,
///          `drucker_prager` and `tresca`, and these with softening
template <int dim>
std::optional<MaterialLaw<dim>> with_reduced_strength(const MaterialLaw<dim>& law, double factor);

}  // namespace gabion
