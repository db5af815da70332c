// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace gabion::mpm {

/// Factor of a load that comes gradually: `from` up to `start`, `to` from start + duration on,
/// between them
///
///     from + (to - from) s  (linear)   or   from + (to - from) s^2 (3 - 2 s)  (smooth),
///
/// s = (t - start) / duration. With duration 0 it is `to` at all times.
struct LoadRamp {
  double start = 0;     ///< [s]
  double duration = 0;  ///< [s] >= 0
  bool smooth = false;  ///< without a kink at both ends
  double from = 0;
  double to = 1;

  double at(double time) const {
    if (duration <= 0) return to;
    const double s = std::clamp((time - start) / duration, 0.0, 1.0);
    return from + (to - from) * (smooth ? s * s * (3 - 2 * s) : s);
  }
  /// Whether it changes right after this time.
  bool runs(double time) const { return from != to && time >= start && time < start + duration; }
};

}  // namespace gabion::mpm
