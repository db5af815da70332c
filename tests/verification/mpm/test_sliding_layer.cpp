// SPDX-License-Identifier: BSD-3-Clause
#include "tests/verification/mpm/sliding_layer.hpp"

namespace gabion::test {
namespace {

TEST(V15_SlidingLayer, every_basis) {
  slide<2>({}, "MPM quad4");
  slide<2>({.type = "tri3"}, "MPM tri3");
  slide<2>({.basis = "gimp"}, "MPM gimp");
  slide<2>({.basis = "bspline"}, "MPM bspline");
  slide<2>({.k0 = 0.6}, "from K0 = 0.6, MPM quad4");
}

}  // namespace
}  // namespace gabion::test
