// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace gabion {

/// A layer or column of a material that stands under its weight.
struct WeightedColumn {
  double density = 0;         ///< [kg/m^3]
  double p_wave_modulus = 0;  ///< [Pa]
  double gravity = 0;         ///< [m/s^2]
  double height = 0;          ///< along gravity [m]

  double wave_speed() const;  ///< of P waves [m/s]
  /// Elastic, of its top, without strain to the side: rho g H^2 / (2 M) [m].
  double settlement() const;
  /// Period of its slowest vibration along gravity, 4 H / c [s].
  double period() const;
};

/// Log wave speed and settlement under the own weight, and warn where they look like units that do
/// not fit together: waves slower than 5 or faster than 20,000 m/s, a settlement of more than a
/// twentieth of the depth.
/// @param where  file and pointer of the material
void log_own_weight(const std::string& where, const WeightedColumn& column);

}  // namespace gabion
