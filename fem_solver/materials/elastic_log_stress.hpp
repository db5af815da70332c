// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/elastic.hpp"
#include "fem_solver/materials/log_strain.hpp"

namespace gabion::fem {

// The elastic laws as functions of the logarithmic strain, for cells that enhance it.

template <int dim>
void log_stress(const NeoHookean<dim>& law, const Symmetric<dim>& E, LogStress<dim>& out);
template <int dim>
void log_stress(const HenckyElastic<dim>& law, const Symmetric<dim>& E, LogStress<dim>& out);
/// Stress of the law of small strain, where E is the symmetric part of H.
template <int dim>
void log_stress(const LinearElastic<dim>& law, const Symmetric<dim>& E, LogStress<dim>& out);

}  // namespace gabion::fem
