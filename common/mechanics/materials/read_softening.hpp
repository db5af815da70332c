// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/softening_soil.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion {

/// Keys of "softening" beside the law mohr_coulomb or, without friction, tresca.
KeyTable softening_keys(bool frictional);

/// The virgin soil that softens.
struct VirginSoil {
  double cohesion = 0;        ///< [Pa]
  double friction_angle = 0;  ///< [degrees]; Tresca: 0
  double dilation_angle = 0;  ///< [degrees]
};

/// Read what softening_keys() lists into curve, by_slip, relaxation_time and rate_gain; checks all
/// parameters.
/// @param parameters  the rest of them is set
void read_softening(ConfigReader in, const VirginSoil& virgin, SofteningParameters& parameters);

}  // namespace gabion
