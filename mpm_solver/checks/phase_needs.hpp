// SPDX-License-Identifier: BSD-3-Clause
// What phases ask of the other settings.
#pragma once

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Refuse what explicit steps cannot do. @throws ConfigError
template <int dim>
void check_explicit(const ConfigReader& in, const MpmSettings<dim>& settings);

/// Refuse strength reduction with laws whose strength cannot be reduced, elastic ones excepted, and
/// with interfaces. @throws ConfigError
template <int dim>
void check_strength_reduction(const ConfigReader& in, const MpmSettings<dim>& settings);

}  // namespace gabion::mpm
