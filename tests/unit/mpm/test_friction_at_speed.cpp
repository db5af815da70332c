// SPDX-License-Identifier: BSD-3-Clause
// Friction of surfaces that falls with the speed of sliding: its keys, and a block in space.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_friction_at_speed {
namespace {

/// A block of 1 m that slides at 2 m/s over a floor, in the direction of the angle.
Json sliding_block(double angle) {
  const double v = 2;
  return {{"dimension", 3},
          {"grid", box({0, 0, 0}, {4, 4, 2}, {8, 8, 4}, "hex8")},
          {"gravity", {0, 0, -9.81}},
          {"bodies",
           {body("block", box({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}, {2, 2, 2}, "hex8"), 8,
                 elastic_soil("neo_hookean", 1e8, 0.2, 1000),
                 {v * std::cos(angle), v * std::sin(angle), 0})}},
          {"time_integration", {{"scheme", "bossak"}}},
          {"rigid_walls",
           {{{"name", "floor"},
             {"surface",
              {{"mesh", box({0, 0, 0}, {4, 4, 0.5}, {1, 1, 1}, "hex8")}, {"groups", {"top"}}}},
             {"friction", 0.5},
             {"friction_at_speed", 0.15},
             {"weakening_speed", 0.6}}}}};
}

/// In the plane: exp(v / v_c) = (exp(v_0 / v_c) + b / a) exp(-a t / v_c) - b / a, a = g mu_r,
/// b = g (mu_s - mu_r).
TEST(FrictionAtSpeed, block_in_space) {
  const double a = 9.81 * 0.15, b = 9.81 * 0.35, v_c = 0.6, t = 0.5;
  const double exact = v_c * std::log((std::exp(2 / v_c) + b / a) * std::exp(-a * t / v_c) - b / a);
  for (const double angle : {0.0, 0.7}) {
    const auto solver = make_mpm(sliding_block(angle));
    run_steps(*solver, 0.01, 50);
    const double mass = probe(*solver, "mass");
    EXPECT_NEAR(probe(*solver, "momentum_x") / mass, exact * std::cos(angle), 0.02 * exact);
    EXPECT_NEAR(probe(*solver, "momentum_y") / mass, exact * std::sin(angle), 0.02 * exact);
    EXPECT_LT(probe(*solver, "created_energy"), 1e-4 * 0.5 * mass * 4);  // of the landing
  }
}

/// Nothing is remembered of the speed.
TEST(FrictionAtSpeed, goes_on_from_a_checkpoint) {
  for (const std::string scheme : {"bossak", "explicit"}) {
    Json json = sliding_block(0.7);
    json["time_integration"]["scheme"] = scheme;
    const auto through = make_mpm(json), again = make_mpm(json);
    run_steps(*through, 0.01, 10);
    again->load_state(through->save_state());
    run_steps(*through, 0.01, 10, 11);
    run_steps(*again, 0.01, 10, 11);
    for (const std::string name : {"momentum_x", "momentum_y", "floor.fx", "contact_friction"}) {
      EXPECT_EQ(probe(*through, name), probe(*again, name)) << name << " " << scheme;
    }
  }
}

void expect_refused(const Json& change, const std::vector<std::string_view>& parts) {
  Json json = sliding_block(0);
  json["rigid_walls"][0].merge_patch(change);
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

TEST(FrictionAtSpeed, wrong_values) {
  expect_refused({{"friction_at_speed", 0.6}},
                 {"/rigid_walls/0/friction_at_speed", "0.6", "at most", "0.5"});
  expect_refused({{"friction_at_speed", -0.1}},
                 {"/rigid_walls/0/friction_at_speed", "-0.1", ">= 0"});
  expect_refused({{"weakening_speed", 0}}, {"/rigid_walls/0/weakening_speed", "0", "> 0"});
  expect_refused({{"weakening_speed", nullptr}}, {"/rigid_walls/0/weakening_speed", "missing"});
  expect_refused({{"friction_at_speed", nullptr}},
                 {"/rigid_walls/0/weakening_speed", "allowed only with", "friction_at_speed"});
  expect_refused({{"friction", nullptr}},
                 {"/rigid_walls/0/friction_at_speed", "allowed only with", "friction"});
  expect_refused({{"method", "boundary_points"}},
                 {"/rigid_walls/0/friction_at_speed", "allowed only with", "facets"});
}

}  // namespace
}  // namespace gabion::test::test_friction_at_speed
