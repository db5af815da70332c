// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/points/pore_water.hpp"

namespace gabion::mpm {

/// Whether water drains and cavitates under suction: of the pores the share
///
///     S = (1 + (p / p_cav)^2)^(-1/2)  for p < 0, else 1
///
/// stays full (van Genuchten 1980, n = 2, nothing held back), the rest gets air. S is smooth at p =
/// 0 and falls forever: soil that opens under suction has a pressure at any volume. The share S of
/// the pressure acts on the grains (Bishop 1959), whose suction stays below p_cav.
bool gives_way(const PoreWater& water);

/// Functions of the pressure p of such water, smooth for all p; S = 1 for other water.
struct Retention {
  double saturation = 1;        ///< S
  double saturation_slope = 0;  ///< dS/dp [1/Pa]
  double filled = 1;            ///< content by pores, S exp(p / K_w)
  double filled_slope = 0;      ///< [1/Pa]
  double borne = 0;             ///< pressure that acts on the grains, S p [Pa]
  double borne_slope = 1;
  double mobility = 1;        ///< share that the mobility keeps, S^3, at least least_mobility
  double mobility_slope = 0;  ///< [1/Pa]

  static constexpr double least_mobility = 1e-4;
};
Retention retention_at(const PoreWater& water, double p);

/// Pressure of water that drains with this content. @pre content > 0, admits(J) [Pa]
double water_pressure(const PoreWater& water, double content, double J);

}  // namespace gabion::mpm
