// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_gates {
namespace {

constexpr double k0 = 0.5, height = 0.5, weight = 9810;

/// A column at rest between the left side and a smooth gate in the middle of the grid, which the
/// second phase opens.
Json gated() {
  Json material = elastic_soil("mohr_coulomb", 1e6, 0.3, 1000);
  material["friction_angle"] = 35;
  Json soil = body("soil", box({0, 0}, {1, height}, {8, 4}, "quad4"), 4, material);
  soil["initial_stress"] = {{"k0", k0}, {"surface", height}, {"max_displacement", 1}};
  return {{"dimension", 2},
          {"grid", box({0, 0}, {2, 0.75}, {16, 6}, "quad4")},
          {"gravity", {0, -9.81}},
          {"walls", {wall("bottom", "slip"), wall("left", "slip")}},
          {"bodies", {soil}},
          {"rigid_walls",
           {{{"name", "gate"},
             {"surface", {{"polyline", {{1, 0.75}, {1, 0}}}, {"spacing", 0.125}}},
             {"friction", 0}}}},
          {"phases",
           {{{"until", 1}, {"analysis", "quasi_static"}, {"dt", 0.25}},
            {{"rigid_walls", Json::array()}, {"dt", 0.001}}}},
          {"newton", exact_newton}};
}

/// The border of the soil is on a line of the grid, give or take a hairline. The nodes beyond have
/// less mass than the least that inertia counts with, and do not give their points all the momentum
/// that they get.
constexpr double by_hairlines = 1e-4;

void take_steps(Solver& solver, double start, double dt, int count) {
  InterfaceValues sent;
  for (int n = 0; n < count; ++n) {
    const StepRequest request{n + 1, 0, start + n * dt, dt};
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

/// The gate bears an earth pressure between the active one and that at rest, from which the soil
/// comes. When the gate is gone, the soil starts from rest, and until the news of that comes to the
/// left side its momentum is that pressure times the time.
TEST(Gates, a_phase_opens_the_gate_of_a_column_at_rest) {
  const auto solver = make_mpm(gated());
  take_steps(*solver, 0, 0.25, 4);
  const double thrust = probe(*solver, "gate.fx");
  const double active = std::pow(std::tan(M_PI / 4 - 35 * M_PI / 360), 2);
  EXPECT_GT(thrust, active * weight * height * height / 2);
  EXPECT_LT(thrust, k0 * weight * height * height / 2);
  EXPECT_NEAR(probe(*solver, "wall.left.fx"), -thrust, 1e-5 * thrust);
  const double error = probe(*solver, "momentum_error_x");
  EXPECT_EQ(probe(*solver, "momentum_x"), 0);
  EXPECT_EQ(probe(*solver, "kinetic_energy"), 0);
  const double dt = 0.0005;
  for (int n = 1; n <= 4; ++n) {
    take_steps(*solver, 1 + (n - 1) * dt, dt, 1);
    EXPECT_EQ(probe(*solver, "gate.fx"), 0);
    EXPECT_EQ(probe(*solver, "gate.mz"), 0);
    EXPECT_NEAR(probe(*solver, "momentum_x"), n * dt * thrust, 1e-5 * n * dt * thrust) << n;
    EXPECT_NEAR(probe(*solver, "momentum_error_x"), error, by_hairlines * dt * thrust);
  }
  EXPECT_EQ(probe(*solver, "contact_energy"), 0);
  take_steps(*solver, 1 + 4 * dt, 0.001, 300);
  EXPECT_GT(probe(*solver, "front"), 1.05);  // through where the gate was
}

TEST(Gates, an_open_gate_stays_open_in_a_saved_state) {
  const auto through = make_mpm(gated()), first = make_mpm(gated()), second = make_mpm(gated());
  for (auto* solver : {through.get(), first.get()}) {
    take_steps(*solver, 0, 0.25, 4);
    take_steps(*solver, 1, 0.001, 3);
  }
  second->load_state(first->save_state());
  for (auto* solver : {through.get(), second.get()}) take_steps(*solver, 1.003, 0.001, 3);
  const auto a = through->probes(), b = second->probes();
  // MUMPS on several ranks adds in the order in which messages come: other last bits each time.
  const double rounding = size() == 1 ? 0 : 1e-8;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k], b[k], rounding * (1 + std::abs(b[k]))) << through->probe_names()[k];
  }
  EXPECT_NE(probe(*second, "momentum_x"), 0);
}

/// A state from before is one with the gate.
TEST(Gates, a_gate_is_there_again_in_a_state_that_has_it) {
  const auto solver = make_mpm(gated());
  take_steps(*solver, 0, 0.25, 2);
  const State early = solver->save_state();
  take_steps(*solver, 0.5, 0.25, 2);
  const auto at_rest = solver->probes();
  take_steps(*solver, 1, 0.001, 1);
  solver->load_state(early);
  take_steps(*solver, 0.5, 0.25, 2);
  EXPECT_EQ(solver->probes(), at_rest);
}

TEST(Gates, walls_that_do_not_act_cannot_be_named) {
  Json json = gated();
  json["phases"][1]["rigid_walls"] = {"gat"};
  expect_error<ConfigError>([&] { make_mpm(json); },
                            {"/phases/1/rigid_walls", "found \"gat\"", "gate"});
  json = gated();
  json["phases"][1]["until"] = 2;
  json["phases"].push_back({{"rigid_walls", {"gate"}}});
  expect_error<ConfigError>([&] { make_mpm(json); }, {"/phases/2/rigid_walls", "found \"gate\""});
}

}  // namespace
}  // namespace gabion::test::test_gates
