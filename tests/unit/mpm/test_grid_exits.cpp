// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_grid_exits {
namespace {

/// A block that flies to the right, out of a grid without a wall there.
Json leaving(const std::string& grid_type, const std::string& basis = "linear") {
  return {
      {"dimension", 2},
      {"grid", box({0, 0}, {2, 2}, {8, 8}, grid_type)},
      {"basis", basis},
      {"gravity", {0, -1}},
      {"walls", {wall("top", "slip")}},
      {"bodies",
       {body("block", box({0.5, 0.5}, {1.5, 1.5}, {4, 4}, grid_type), grid_type == "quad4" ? 4 : 3,
             elastic_soil("hencky_elastic", 1e4, 0.3, 1000), {4, 0})}},
      {"newton", exact_newton}};
}

void take_steps(Solver& solver, double dt, int count) {
  InterfaceValues sent;
  for (int n = 0; n < count; ++n) {
    const StepRequest request{n + 1, 0, n * dt, dt};
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

/// The step fails before anything is accepted, in words that name point, path and side.
TEST(GridExits, a_step_that_leads_out_fails_and_names_the_side) {
  for (const char* type : {"quad4", "tri3"}) {
    const auto solver = mpm_solver<2>(leaving(type));
    take_steps(*solver, 0.03, 4);  // the front point is below 1.98 now
    const auto before = solver->points();
    expect_error<ConvergenceError>([&] { take_steps(*solver, 0.05, 1); },
                                   {"material point ", "side \"right\" (no wall)",
                                    "velocity (4, -0.12)", "\"outside\": \"remove\""});
    solver->reject_step();
    EXPECT_TRUE(same_bits(before, solver->points())) << type;
    EXPECT_EQ(solver->summary()["newton"]["failures"], Json({{"outside", 1}}));
  }
}

void expect_balance(const Json& json, const std::string& name) {
  Json removing = json;
  removing["outside"] = "remove";
  const auto solver = mpm_solver<2>(removing);
  take_steps(*solver, 0.02, 12);
  const double mass = probe(*solver, "mass"), removed = probe(*solver, "removed_mass");
  EXPECT_GT(removed, 100) << name;
  EXPECT_GT(mass, 100) << name;
  EXPECT_NEAR(mass + removed, 1000, 1e-9) << name;
  EXPECT_NEAR(probe(*solver, "removed.right.mass"), removed, 1e-9) << name;
  EXPECT_GT(probe(*solver, "removed_points"), 1) << name;
  EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-8) << name;
  EXPECT_NEAR(probe(*solver, "created_energy"), 0, 1e-8) << name;
  EXPECT_NEAR(probe(*solver, "momentum_error_x"), 0, 1e-8) << name;
  EXPECT_NEAR(probe(*solver, "momentum_error_y"), 0, 1e-8) << name;
  EXPECT_NEAR(probe(*solver, "momentum_x"), 4 * mass, 1e-8) << name;
  EXPECT_NEAR(probe(*solver, "momentum_y"), -0.24 * mass, 1e-8) << name;
}

/// In free flight the points that are left go on undisturbed, and those removed stay in the
/// balances.
TEST(GridExits, removed_points_stay_in_the_balances) {
  expect_balance(leaving("quad4"), "quad4");
  expect_balance(leaving("tri3"), "tri3");
  expect_balance(leaving("quad4", "gimp"), "gimp");
  Json tpic = leaving("quad4");
  tpic["transfer"] = {{"method", "tpic"}};
  expect_balance(tpic, "tpic");
}

TEST(GridExits, a_probe_that_leaves_is_empty) {
  Json json = leaving("quad4");
  json["outside"] = "remove";
  json["probes"] = {{{"name", "tip"}, {"point", {1.5, 1.0}}}};
  const auto solver = make_mpm(json);
  take_steps(*solver, 0.02, 12);
  EXPECT_TRUE(std::isnan(probe(*solver, "tip.ux")));
  EXPECT_GT(solver->summary()["probes_left_at"]["tip"], 0);
}

}  // namespace
}  // namespace gabion::test::test_grid_exits
