// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion::fem {

/// Damping C = mass M + stiffness K
struct RayleighFactors {
  double mass = 0;       ///< [1/s]
  double stiffness = 0;  ///< [s]
  std::string where;     ///< place in the config, for errors; empty: none is given
};

KeyTable rayleigh_keys();

/// Read "rayleigh" of this object, none where it is missing.
RayleighFactors read_rayleigh(ConfigReader& in);

}  // namespace gabion::fem
