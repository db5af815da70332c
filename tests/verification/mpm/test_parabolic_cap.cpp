// SPDX-License-Identifier: BSD-3-Clause
#include "tests/verification/mpm/sliding_cap.hpp"

namespace gabion::test {
namespace {

TEST(V22_ParabolicCap, on_a_rough_bed) {
  slide_cap({}, {.published = 0.14});
}

/// tan^2 delta is a tenth of K.
TEST(V22_ParabolicCap, on_a_smooth_bed) {
  slide_cap({.bed_angle = 10, .scheme = "explicit"}, {});
}

}  // namespace
}  // namespace gabion::test
