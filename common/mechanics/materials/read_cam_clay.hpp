// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/materials/cam_clay_return.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion {

/// Keys of a material with the law cam_clay, besides density and poisson_ratio.
std::vector<Key> cam_clay_keys();

/// Read them and poisson_ratio. The slopes of the file are those of the laboratory, by Cauchy
/// stress; with tau = J sigma the slope by Kirchhoff stress is slope / (1 - slope).
CamClayParameters read_cam_clay(ConfigReader& in);

}  // namespace gabion
