// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/retention.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::mpm {

bool gives_way(const PoreWater& water) {
  return water.drains() && std::isfinite(water.cavitation);
}

Retention retention_at(const PoreWater& water, double p) {
  const double K_w = water.bulk_modulus;
  Retention at;
  if (!(p < 0) || !gives_way(water)) {
    at.filled = std::exp(p / K_w);
    at.filled_slope = at.filled / K_w;
    at.borne = p;
    return at;
  }
  const double x = p / water.cavitation;
  const double S = 1 / std::sqrt(1 + x * x);
  at.saturation = S;
  at.saturation_slope = -S * S * S * x / water.cavitation;
  at.filled = S * std::exp(p / K_w);
  at.filled_slope = std::exp(p / K_w) * (at.saturation_slope + S / K_w);
  at.borne = S * p;
  at.borne_slope = S * S * S;  // S + p dS/dp
  at.mobility = S * S * S;
  at.mobility_slope = 3 * S * S * at.saturation_slope;
  if (at.mobility < Retention::least_mobility) {
    at.mobility = Retention::least_mobility;
    at.mobility_slope = 0;
  }
  return at;
}

// Newton's method for ln cosh(u) + p_cav / K_w sinh(u) = ln(pores / content), p = -p_cav sinh(u).
// The left side is convex and rises, each of its terms alone bounds u from above: from there all
// steps go down to the root.
double water_pressure(const PoreWater& water, double content, double J) {
  const double K_w = water.bulk_modulus, p_cav = water.cavitation;
  const double opened = std::log1p((water.pores(J) - content) / content);
  if (!(opened > 0) || !gives_way(water)) return -K_w * opened;
  double u =
      std::min(std::asinh(std::sqrt(std::expm1(2 * opened))), std::asinh(opened * K_w / p_cav));
  for (int i = 0; i < 200; ++i) {
    // ln cosh(u) without loss of digits at small u.
    const double half = std::sinh(u / 2);
    const double value = std::log1p(2 * half * half) + p_cav / K_w * std::sinh(u) - opened;
    const double slope = std::tanh(u) + p_cav / K_w * std::cosh(u);
    const double next = u - value / slope;
    if (!(std::abs(next - u) > 4e-16 * std::abs(next))) break;
    u = next;
  }
  return -p_cav * std::sinh(u);
}

}  // namespace gabion::mpm
