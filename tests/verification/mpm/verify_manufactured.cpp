// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/verification/mpm/manufactured_orders.hpp"

namespace gabion::test {
namespace {

ManufacturedBox square(int n) {
  return {{0, 0}, {1, 1}, {n, n}, "quad4"};
}

ManufacturedBox slab(int n) {
  return {{0, 0, 0}, {1, 1, 1.0 / n}, {n, n, 1}, "hex8", 8};
}

TEST(V3_AxisAlignedWaves, small_3d) {
  const OrderStudy<3> study{"V3", "A = 1e-4, 3D", axis_aligned_waves<3>(1e-4), slab};
  order_in_h(study, {8, 16}, 40, {"linear", 0.017, 1.9});
}

TEST(V3_AxisAlignedWaves, small) {
  const OrderStudy<2> study{"V3", "A = 1e-4", axis_aligned_waves<2>(1e-4), square};
  order_in_dt(study, 32, {10, 20}, 1.85);
}

TEST(V3_AxisAlignedWaves, large) {
  for (const Expected& expected :
       {Expected{"linear", 0.48, {}, cells_are_crossed}, Expected{"gimp", 0.01, 1.9},
        Expected{"bspline", 0.034, 0.8, points_are_uneven}}) {
    const OrderStudy<2> study{"V3", "A = 0.05", axis_aligned_waves<2>(0.05), square,
                              expected.basis};
    order_in_h(study, {8, 16, 32}, 100, expected);
  }
}

/// The ring lies in a square of the same material that rests.
ManufacturedBox square_with_ring(int n) {
  return {{-1.25, -1.25}, {1.25, 1.25}, {n, n}, "quad4", 4, "fixed"};
}

/// The body acceleration jumps at the edges of the ring, which cut through cells: below order 2.
TEST(V4_Vortex, small) {
  for (const Expected& expected : {Expected{"linear", 0.039, 1.4}, Expected{"gimp", 0.035, 1.75},
                                   Expected{"bspline", 0.065, 2.25}}) {
    const OrderStudy<2> study{"V4", "G = 1e-3", vortex<2>(1e-3), square_with_ring, expected.basis};
    order_in_h(study, {10, 20, 40}, 100, expected);
  }
}

TEST(V4_Vortex, small_in_dt) {
  const OrderStudy<2> study{"V4", "G = 1e-3", vortex<2>(1e-3), square_with_ring};
  order_in_dt(study, 40, {4, 8}, 1.8);
}

TEST(V4_Vortex, large) {
  for (const Expected& expected :
       {Expected{"linear", 0.75, {}, shear_is_large}, Expected{"gimp", 0.57, {}, shear_is_large},
        Expected{"bspline", 0.51, {}, shear_is_large}}) {
    const OrderStudy<2> study{"V4", "G = 0.5", vortex<2>(0.5), square_with_ring, expected.basis};
    order_in_h(study, {10, 20, 40}, 100, expected);
  }
}

}  // namespace
}  // namespace gabion::test
