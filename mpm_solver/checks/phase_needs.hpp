// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Limits of the kinds of phases: explicit steps have no ghost stiffness, `tpic` or
/// `boundary_points`, fluids have no quasi-static state, ghost stiffness or pore water, and
/// strength reduction needs laws with c and phi, the basis `linear` and no interfaces.
/// @throws ConfigError
template <int dim>
void check_phase_needs(const ConfigReader& in, const MpmSettings<dim>& settings);

}  // namespace gabion::mpm
