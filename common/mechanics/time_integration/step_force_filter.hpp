// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "common/mechanics/time_integration/newmark.hpp"

namespace gabion {

/// M^-1 F of a mean force F on a few nodes gives velocities to waves that are much shorter than the
/// step takes in, and damping or contact then make energy of them. In place of y = M^-1 (F - F_o)
/// the corrections of NewmarkBossak, and the c - 1 in its balance, may take N y = F - F_o,
///
///     N = (1 - s) M + s A (beta dt^2 / (1 - alpha_m)) ,   A the matrix of the step.
///
/// Slow motion, that of rigid bodies included, sees no difference of second order, and a linear
/// structure takes no more energy than F . du if s is at most that of this function: 1 / H, H the
/// transfer function from F to du, has no negative real part on the unit circle
/// (docs/theory/structure.md, (T13)). 0 with the trapezoidal rule, 1 with rho_inf = 0.
inline double step_force_filter(const NewmarkBossak& scheme) {
  const double delta = -scheme.alpha_m;
  return std::min(
      1.0, delta * (scheme.gamma + 0.5 * delta * delta) * (1 - scheme.alpha_m) / scheme.beta);
}

/// Whether structures without damping take N, too: with rho_inf = 0, where N is A and c is 1.
inline bool step_force_is_implicit(const NewmarkBossak& scheme) {
  return scheme.alpha_m == -1 && scheme.alpha_f == 0;
}

}  // namespace gabion
