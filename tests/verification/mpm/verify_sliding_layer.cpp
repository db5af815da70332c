// SPDX-License-Identifier: BSD-3-Clause
#include "tests/verification/mpm/sliding_layer.hpp"

namespace gabion::test {
namespace {

TEST(V15_SlidingLayer, in_space) {
  slide<3>({.type = "hex8"}, "MPM hex8");
  slide<3>({.type = "hex8", .basis = "gimp"}, "MPM gimp 3D");
  slide<3>({.type = "hex8", .basis = "bspline"}, "MPM bspline 3D");
}

}  // namespace
}  // namespace gabion::test
