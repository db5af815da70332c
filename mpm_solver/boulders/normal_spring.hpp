// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace gabion::mpm {

/// Gap rates below which the factor of the restitution blends from loading to unloading, and the
/// least closing speed at surfaces that move under the force [m/s].
inline constexpr double blend_speed = 0.02;

/// (W(g_0) - W(g_1)) / (g_1 - g_0) over the stiffness, W = |g|^3 / 3 where g < 0.
inline double mean_force(double g0, double g1) {
  const double a = std::max(-g0, 0.0), b = std::max(-g1, 0.0);
  if (g0 <= 0 && g1 <= 0) return (a * a + a * b + b * b) / 3;
  if (a == 0 && b == 0) return 0;
  return (a * a * a - b * b * b) / (3 * (g1 - g0));
}

/// Share of the energy of an impact that the springs keep.
inline double kept(double e) {
  return (1 + e * e) / 2;
}

/// Factor of the mean force of a substep, at this rate of the gap: more than kept() while it closes
/// [m/s].
inline double restitution_factor(double e, double rate) {
  return kept(e) - (1 - e * e) / 2 * std::clamp(rate / blend_speed, -1.0, 1.0);
}

}  // namespace gabion::mpm
