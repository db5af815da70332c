// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gabion {

/// Treatment of the volume that opens while the material is at its isotropic tension limit.
enum class ApexVolume {
  gap,    ///< kept in MaterialState::gap: must close before the pressure changes again
  forget  ///< recompression builds pressure at once, in the larger volume
};

}  // namespace gabion
