// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/impact_damping.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::mpm {

namespace {

// Nearer to 1 both sides of the equation differ by rounding only; the series of both in a is
// right to 1e-6 of its value there.
constexpr double nearly_elastic = 1e-3;
constexpr int halvings = 200;

}  // namespace

double impact_damping(double e) {
  e = std::max(e, least_damped_restitution);
  const double first = 1.5 * (1 - e * e) / (1 + e * e * e);
  if (1 - e < nearly_elastic) return first;
  double low = 0.5 * first, high = 1 / e;
  for (int k = 0; k < halvings; ++k) {
    const double a = 0.5 * (low + high);
    if (a <= low || a >= high) break;
    const bool is_less = std::log1p(a) - std::log1p(-e * a) < a * (1 + e);
    (is_less ? low : high) = a;
  }
  return low;
}

}  // namespace gabion::mpm
