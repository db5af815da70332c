// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Requirements of bodies with fields of their own: a box grid whose nodes can be counted for each
/// group, no pore water that drains, and surfaces of the method `facets`.
/// @throws ConfigError
template <int dim>
void check_group_needs(const ConfigReader& in, const MpmSettings<dim>& settings);

}  // namespace gabion::mpm
