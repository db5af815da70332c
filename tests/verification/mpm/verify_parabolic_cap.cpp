// SPDX-License-Identifier: BSD-3-Clause
#include "tests/verification/mpm/sliding_cap.hpp"

namespace gabion::test {
namespace {

TEST(V22_ParabolicCap, finer) {
  slide_cap({.rows = 6, .dt = 1e-3}, {.published = 0.14});
  slide_cap({.rows = 12, .scheme = "explicit"}, {.half_length = 0.02, .published = 0.14}, true);
}

/// The skewness falls with H / L, what tan^2 delta takes from the spread does not.
TEST(V22_ParabolicCap, thinner) {
  slide_cap({.H = 0.025, .rows = 6, .scheme = "explicit"}, {.published = 0.1, .skewness = 0.015});
}

}  // namespace
}  // namespace gabion::test
