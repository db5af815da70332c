// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/fem/concrete_bar.hpp"
#include "tests/unit/fem/energy_balance.hpp"

namespace gabion::test {
namespace {

/// A cracked cell leaves at a width of 0.1 mm, where its crack still carries a little.
TEST(FailingCells, crack_that_is_wide_enough_opens_for_good) {
  const TemporaryMesh mesh(strip(0.5, 0.1, 5));
  Json json = pulled_strip(mesh.path(), 5, 4e-4);
  json["materials"][0]["failure_crack_width"] = 1e-4;
  json["materials"][0]["fade_steps"] = 1;
  const auto solver = fem_solver<2>(json);
  const int steps = 80;
  for (int n = 1; n <= steps; ++n) {
    advance(*solver, n, 1.0 / steps);
    EXPECT_LT(imbalance(*solver), 1e-3) << n;
  }
  EXPECT_EQ(probe(*solver, "failed_cells"), 1);
  EXPECT_NEAR(probe(*solver, "reaction_left_x"), 0, 1e-3);
  EXPECT_LT(probe(*solver, "damage_work"), 100 * 0.1);
  EXPECT_GT(probe(*solver, "damage_work"), 0.8 * 100 * 0.1);
}

}  // namespace
}  // namespace gabion::test
