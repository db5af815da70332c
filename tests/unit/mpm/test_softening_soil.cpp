// SPDX-License-Identifier: BSD-3-Clause
// Soil that softens with the slip, in whole scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_softening_soil {
namespace {

constexpr double speed = 0.05, peak = 1e4, residual = 3e3, slip = 0.01;

/// Clay between two rough plates, 1 m long and 0.5 m high, sheared along a row of its cells.
Json sheared_clay(int cells) {
  Json clay = elastic_soil("tresca", 5e6, 0.45, 2000);
  clay["cohesion"] = peak;
  clay["softening"] = {{"slip", slip}, {"residual_cohesion", residual}};
  Json top = wall("top", "fixed");
  top["motion"] = {{"velocity", {speed, 0}}};
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"grid", box({0, 0}, {1.5, 0.5}, {3 * cells, cells}, "quad4")},
          {"walls", {wall("bottom", "fixed"), top}},
          {"bodies",
           {body("soil", box({0.25, 0}, {1.25, 0.5}, {2 * cells, cells}, "quad4"), 4, clay)}}};
}

struct Shearing {
  double largest = 0, last = 0;  // force of the plate [N]
  double work = 0;               // [J]
};

Shearing shear(Solver& solver, double dt, int steps) {
  Shearing result;
  double before = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(solver, dt, 1, n);
    const double force = std::abs(probe(solver, "wall.top.fx"));
    result.work += 0.5 * (before + force) * speed * dt;
    result.largest = std::max(result.largest, force);
    before = result.last = force;
  }
  return result;
}

/// The work of a slip surface does not depend on the cells: about residual d + (peak - residual)
/// slip after a slip d.
TEST(SofteningSoil, work_of_a_slip_surface_on_two_grids) {
  const auto coarse = mpm_solver<2>(sheared_clay(4)), fine = mpm_solver<2>(sheared_clay(8));
  const Shearing a = shear(*coarse, 0.004, 150), b = shear(*fine, 0.004, 150);
  EXPECT_NEAR(a.work, b.work, 0.03 * b.work);
  EXPECT_NEAR(b.work, residual * 0.03 + (peak - residual) * slip, 0.1 * b.work);
  for (const Shearing& of : {a, b}) {
    EXPECT_GT(of.largest, 0.8 * peak);
    EXPECT_LT(of.largest, peak);
    EXPECT_NEAR(of.last, residual, 0.3 * residual);
  }
}

TEST(SofteningSoil, restart) {
  const auto straight = mpm_solver<2>(sheared_clay(4)), first = mpm_solver<2>(sheared_clay(4)),
             second = mpm_solver<2>(sheared_clay(4));
  run_steps(*straight, 0.01, 24);
  run_steps(*first, 0.01, 14);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, 0.01, 10, 15);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
  double most = 0;
  for (const auto& internal : straight->points().internal) most = std::max(most, internal[1]);
  EXPECT_GT(most, 0.1 * slip);  // it slipped
}

/// Clay whose strength grows with the rate, in a block that slides: yielded points enter other cells
/// and share the volumes of their groups at once.
TEST(SofteningSoil, clay_with_a_rate_flows_through_cells) {
  for (const char* scheme : {"bossak", "explicit"}) {
    Json json = sheared_clay(4);
    json.erase("analysis");
    json["time_integration"] = {{"scheme", scheme}};
    json["grid"] = box({0, 0}, {3, 0.75}, {24, 6}, "quad4");
    json["walls"] = {wall("bottom", "slip")};
    json["gravity"] = {0, -9.81};
    json["bodies"][0]["velocity"] = {3, 0};
    Json& clay = json["bodies"][0]["material"];
    clay["cohesion"] = 1e3;
    clay["softening"]["residual_cohesion"] = 5e2;
    clay["softening"]["rate_gain"] = 0.1;
    clay["softening"]["reference_rate"] = 1e-3;
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 1e-3, 120);
    EXPECT_GT(probe(*solver, "plastic_dissipation"), 0) << scheme;
    const double mass = probe(*solver, "mass");
    EXPECT_NEAR(probe(*solver, "momentum_x"), 3 * mass, 1e-6 * mass) << scheme;
  }
}

TEST(SofteningSoil, explicit_steps_soften_too) {
  Json json = sheared_clay(4);
  json.erase("analysis");
  json["time_integration"] = {{"scheme", "explicit"}};
  const auto solver = mpm_solver<2>(json);
  const Shearing of = shear(*solver, 0.004, 150);
  EXPECT_GT(of.largest, 0.8 * peak);
  EXPECT_LT(of.last, 0.5 * peak);
}

TEST(SofteningSoil, strength_that_falls_too_fast_is_refused) {
  Json json = sheared_clay(4);
  json["bodies"][0]["material"]["softening"]["slip"] = 1e-5;
  expect_error<ConfigError>([&] { mpm_solver<2>(json); },
               {"/bodies/0/material/softening", "times as fast", "slips", "cells", "modulus"});
}

}  // namespace
}  // namespace gabion::test::test_softening_soil
