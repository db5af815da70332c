// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "fem_solver/materials/hardening.hpp"

namespace gabion::fem {

/// Keys of the yield stress and its hardening, kinematic too, of these laws.
std::vector<Key> yield_keys(const std::vector<std::string>& laws);

/// Read what yield_keys() list but "kinematic_modulus".
/// @throws ConfigError  both or neither of "yield_stress" and "yield_table"; a table that falls,
/// ...
Hardening read_hardening(ConfigReader& in);

/// Warn of values that look like another unit.
/// @param E    Young's modulus [Pa]
/// @param H_k  kinematic modulus [Pa]
void check_yield(const ConfigReader& in, const Hardening& hardening, double E, double H_k);

}  // namespace gabion::fem
