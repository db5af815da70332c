// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/cam_clay_return.hpp"

namespace gabion {

/// Memory of a clay that has pressure P: its ellipse goes through the largest stress that it has
/// borne, its shear modulus is that of P.
/// @param P_before, q_before  P = a - p and q of that stress [Pa]
inline InternalState cam_clay_memory(const CamClayParameters& clay, double P, double P_before,
                                     double q_before) {
  const double shear = q_before / clay.critical_ratio;
  return {P_before + shear * shear / P_before, clay.shear_modulus_at(P)};
}

}  // namespace gabion
