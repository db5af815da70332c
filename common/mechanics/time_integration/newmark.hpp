// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/base/config_reader.hpp"

namespace gabion {

/// Newmark's family in the displacement increment du of a step, with Bossak's averaging of inertia:
///
///     a' = du / (beta dt^2) - v / (beta dt) - (1 / (2 beta) - 1) a
///     v' = v + dt [(1 - gamma) a + gamma a']
///     (1 - alpha_B) M a' + alpha_B M a + f_int' = f_ext'
///
/// alpha_B = 0: trapezoidal rule. alpha_B in [-1/3, 0): second order with high-frequency damping,
/// gamma = 1/2 - alpha_B, beta = (1 - alpha_B)^2 / 4.
/// @see Newmark (1959); Wood, Bossak, Zienkiewicz (1980)
struct NewmarkBossak {
  double alpha_bossak = 0;
  double beta = 0.25;
  double gamma = 0.5;

  static NewmarkBossak bossak(double alpha);

  double acceleration(double du, double v, double a, double dt) const {
    return du / (beta * dt * dt) - v / (beta * dt) - (0.5 / beta - 1) * a;
  }
  double velocity(double a_new, double v, double a, double dt) const {
    return v + dt * ((1 - gamma) * a + gamma * a_new);
  }
  /// Inertia per unit mass, (1 - alpha_B) a' + alpha_B a.
  double inertia(double a_new, double a) const {
    return (1 - alpha_bossak) * a_new + alpha_bossak * a;
  }
  /// d(inertia)/d(du) per unit mass.
  double inertia_slope(double dt) const { return (1 - alpha_bossak) / (beta * dt * dt); }
};

/// Read {"scheme": "newmark" | "bossak", "alpha": -0.1}; newmark is the trapezoidal rule.
NewmarkBossak read_newmark_bossak(ConfigReader in);

}  // namespace gabion
