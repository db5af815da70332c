// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "coupler/coupler_config.hpp"

namespace gabion {

/// Warnings of tolerances of coupler.json that are below the rounding of positions x = X + u on
/// these surfaces, 4 eps max|X|.
/// @param file    coupler.json, for the messages
/// @returns       a warning each, with file, JSON pointer, found, and the rounding
std::vector<std::string> rounding_warnings(const CouplingSettings& coupling,
                                           const std::vector<InterfaceMesh>& surfaces,
                                           const std::string& file);

}  // namespace gabion
