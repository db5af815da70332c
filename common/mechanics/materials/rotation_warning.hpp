// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "common/base/log.hpp"

namespace gabion {

/// Warns of a small-strain law (`linear_elastic`) under a large rotation, which it takes for a
/// strain of 1 - cos(angle): a block that turns freely grows. Once at 10 degrees, and again
/// whenever the angle has doubled.
class RotationWarning {
 public:
  /// @param angle  the largest so far [rad]
  /// @param what   such as "structure"
  void look(double angle, const std::string& what) {
    if (!(angle >= next_)) return;
    while (next_ <= angle) next_ *= 2;
    log::warn(
        "{}: linear_elastic has rotated by {:.0f} degrees and takes that for a strain of {:.2g} %: "
        "lengths and stresses are wrong by as much; neo_hookean and hencky_elastic bear rotations",
        what, angle * 180 / std::numbers::pi, 100 * (1 - std::cos(angle)));
  }

 private:
  double next_ = 10 * std::numbers::pi / 180;
};

}  // namespace gabion
