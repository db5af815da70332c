// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/fem/concrete_bar.hpp"
#include "tests/unit/fem/energy_balance.hpp"

namespace gabion::test {
namespace {

/// A cracked cell leaves at a width of 0.1 mm, where its crack has taken most of its energy: 10 J
/// on a height of 0.1 m.
TEST(FailingConcrete, cell_leaves_when_its_crack_is_wide) {
  const TemporaryMesh mesh(strip(0.5, 0.1, 5));
  Json json = pulled_strip(mesh.path(), 5, 4e-4);
  json["materials"][0]["failure_crack_width"] = 1e-4;
  json["materials"][0]["fade_steps"] = 1;
  const auto solver = fem_solver<2>(json);
  const int steps = 80;
  int n = 0;
  while (probe(*solver, "failed_cells") == 0 && n < steps) advance(*solver, ++n, 1.0 / steps);
  ASSERT_LT(n, steps);
  EXPECT_EQ(probe(*solver, "failed_cells"), 1);
  EXPECT_GT(probe(*solver, "crack_width_weak"), 1e-4);
  EXPECT_LT(probe(*solver, "crack_width_weak"), 1.2e-4);
  EXPECT_GT(probe(*solver, "failed_energy"), 0);
  EXPECT_LT(probe(*solver, "damage_work"), 10);
  EXPECT_GT(probe(*solver, "damage_work"), 8);
  EXPECT_NEAR(imbalance(*solver), 0, 0.1);
}

}  // namespace
}  // namespace gabion::test
