// SPDX-License-Identifier: BSD-3-Clause
// Soil whose pore water drains, in explicit steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/collapse.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_fractional_step {
namespace {

const Json explicit_steps = {{"scheme", "explicit"}};

/// A layer between smooth walls that drains through its surface.
Json layer(int dim, int cells, double k) {
  Json json = saturated_box(dim, dim == 2 ? "quad4" : "hex8", cells,
                            elastic_soil("hencky_elastic", 10e6, 0.2, saturated_density));
  json["basis"] = "gimp";
  json["bodies"][0]["water"]["permeability"] = k;
  json["time_integration"] = explicit_steps;
  json.erase("newton");
  std::vector<double> middle(dim, 0.5);
  json["probes"] = {{{"name", "A"}, {"point", middle}}};
  return json;
}

template <int dim>
double water_of(const mpm::MpmSolver<dim>& solver) {
  const auto& points = solver.points();
  double sum = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) sum += points.V0[p] * points.water[p];
  return sum;
}

/// Soil under initial stress rests under its water.
TEST(FractionalStep, soil_rests_for_a_thousand_steps) {
  Json json = layer(2, 2, 1e-4);
  json["bodies"][0]["initial_stress"] = at_rest(1);
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1e-3, 1000);
  double largest = 0;
  for (const auto& u : solver->points().u) largest = std::max(largest, u.norm());
  EXPECT_LT(largest, 1e-9 / 2);
  EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), 0, 1e-4 * water_density * 9.81);
  EXPECT_LT(probe(*solver, "kinetic_energy"), 1e-12);
}

/// Water that leaves a layer and its settlement after 0.04 s.
struct Outflow {
  double out;       ///< [m^3]
  double pressure;  ///< in the middle, by the buoyant weight of 1 m
};
template <int dim>
Outflow consolidate(int cells, double dt, bool fractional) {
  Json json = layer(dim, cells, 1e-3);
  if (!fractional) json.erase("time_integration");
  const auto solver = mpm_solver<dim>(json);
  const double before = water_of(*solver);
  run_steps(*solver, dt, static_cast<int>(std::lround(0.04 / dt)));
  const double out = probe(*solver, "water_out") / water_density, lost = before - water_of(*solver);
  EXPECT_GT(out, 1e-5);
  EXPECT_NEAR(out, lost, 1e-6 * lost);
  if (fractional) {
    const double work = probe(*solver, "gravity_work");
    EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-6 * work);
  }
  const double load = (saturated_density - water_density) * 9.81;
  return {out, probe(*solver, "A.pore_pressure") / load};
}

/// Both kinds of steps solve one problem: they differ by terms of the order of dt.
TEST(FractionalStep, layer_consolidates_as_in_implicit_steps) {
  double difference[2];
  for (const bool fine : {false, true}) {
    const double dt = fine ? 2.5e-4 : 1e-3;
    const Outflow fractional = consolidate<2>(4, dt, true), implicit = consolidate<2>(4, dt, false);
    difference[fine] = std::abs(fractional.out / implicit.out - 1);
    EXPECT_NEAR(fractional.pressure, implicit.pressure, 0.01);
  }
  EXPECT_LT(difference[0], 0.05);
  EXPECT_LT(difference[1], 0.5 * difference[0]);
  const Outflow fractional = consolidate<3>(2, 1e-3, true),
                implicit = consolidate<3>(2, 1e-3, false);
  EXPECT_NEAR(fractional.out, implicit.out, 0.05 * implicit.out);
  EXPECT_NEAR(fractional.pressure, implicit.pressure, 0.01);
}

/// The limit of the step is that of dry soil, whatever the water, and the step obeys it.
TEST(FractionalStep, substeps_depend_on_the_skeleton_alone) {
  const double M = 10e6 * 0.8 / (1.2 * 0.6), h = 0.25;
  for (const double K_w : {2.2e8, 2.2e9, 2.2e11}) {
    for (const double k : {1e-9, 1e-4, 1.0}) {
      Json json = layer(2, 4, k);
      json["bodies"][0]["water"]["bulk_modulus"] = K_w;
      json["time_integration"]["courant"] = 1;
      const auto solver = mpm_solver<2>(json);
      run_steps(*solver, 0.05, 4);
      const double limit = h / std::sqrt(M / saturated_density);
      const double substep =
          solver->summary()["explicit"]["smallest_substep"].template get<double>();
      EXPECT_LE(substep, limit);
      EXPECT_DOUBLE_EQ(substep, 0.05 / std::ceil(0.05 / limit));
      for (const double p : solver->points().water) EXPECT_TRUE(std::isfinite(p));
      EXPECT_LT(std::abs(probe(*solver, "A.uy")), 2e-3) << K_w << " " << k;
    }
  }
}

/// The first substeps under a sudden weight take 12 to 36 iterations; a matrix that is not the
/// derivative of the balance, or factors that are not near to it, would take many more.
TEST(FractionalStep, pressures_take_few_iterations) {
  for (const int cells : {4, 16}) {
    for (const double k : {1e-9, 1e-3}) {
      const auto solver = mpm_solver<2>(layer(2, cells, k));
      run_steps(*solver, 0.5 / cells * 1e-2, 4);
      const Json found = solver->summary()["explicit"];
      EXPECT_LT(found["pressure_iterations"].get<double>() / found["substeps"].get<double>(), 40)
          << cells << " cells, k " << k;
    }
  }
}

/// A wall, whose load the water bears at first, and a front that runs into a rough surface.
Json wet_collapse() {
  Json json = collapse_scene({.basis = "gimp", .locking = "fbar"});
  Json& soil = json["bodies"][0];
  soil["mesh"] = box({0, 0}, {1.0, 1.0}, {10, 10}, "quad4");
  soil["material"] = saturated_sand();
  soil["water"] = pore_water;
  soil["water"]["permeability"] = 1e-3;
  soil["water"]["permeability_law"] = "kozeny_carman";
  Json& dry = json["bodies"][1];
  dry["mesh"] = box({1.0, 0}, {1.4, 0.6}, {4, 6}, "quad4");
  dry["material"] = saturated_sand();
  for (Json& body : json["bodies"]) body["velocity"] = {2.5, 0};
  json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
  json["walls"][1]["drained"] = true;
  json["rigid_walls"] = {
      {{"name", "step"},
       {"surface", {{"polyline", {{1.42, 0.8}, {1.42, -0.1}}}, {"spacing", 0.1}}},
       {"friction", 0.3}}};
  json.erase("newton");
  json.erase("linear_solver");
  json["time_integration"] = explicit_steps;
  return json;
}

/// Iterations, a rejected step and a cut leave nothing behind; a loaded state goes on the same.
TEST(FractionalStep, repeated_and_loaded_steps_have_the_same_bits) {
  const Json json = wet_collapse();
  const auto once = mpm_solver<2>(json), often = mpm_solver<2>(json), loaded = mpm_solver<2>(json);
  InterfaceValues sent;
  for (int n = 1; n <= 8; ++n) {
    const StepRequest request = collapse_step(n);
    once->solve_step(request, {}, sent);
    often->solve_step({n, 0, request.time, request.dt / 2}, {}, sent);
    often->reject_step();
    for (int iteration = 0; iteration < 3; ++iteration) {
      often->solve_step({n, iteration, request.time, request.dt}, {}, sent);
    }
    once->accept_step(request, true);
    often->accept_step({n, 2, request.time, request.dt}, true);
    if (n == 4) loaded->load_state(once->save_state());
    if (n > 4) run_collapse(*loaded, n, n);
    ASSERT_TRUE(same_bits(once->points(), often->points())) << n;
  }
  EXPECT_TRUE(same_bits(once->points(), loaded->points()));
  EXPECT_EQ(once->probes(), loaded->probes());
  EXPECT_EQ(once->probes(), often->probes());
  EXPECT_NE(probe(*once, "step.fx"), 0);
  EXPECT_GT(std::abs(probe(*once, "water_out")), 0.01);
}

/// Water bears a sudden load where it has no time to drain, and soil that drains takes it back.
TEST(FractionalStep, front_of_drained_soil_stays_behind) {
  double front[2];
  for (const bool drained : {false, true}) {
    Json json = collapse_scene({.basis = "gimp", .locking = "fbar"});
    json["bodies"].erase(1);
    json["bodies"][0].erase("velocity");
    json["bodies"][0]["material"] = saturated_sand();
    json["bodies"][0]["water"] = pore_water;
    json["bodies"][0]["water"]["permeability"] = drained ? 0.1 : 1e-9;
    json["probes"] = Json::array();
    json.erase("newton");
    json.erase("linear_solver");
    json["time_integration"] = explicit_steps;
    const auto solver = mpm_solver<2>(json);
    run_collapse(*solver, 1, 60);
    front[drained] = probe(*solver, "front");
    EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-3 * probe(*solver, "gravity_work"));
  }
  EXPECT_GT(front[0], 0.65);
  EXPECT_LT(front[1] - 0.6, 0.5 * (front[0] - 0.6));
}

/// A pool presses on the soil under it and on nothing else.
TEST(FractionalStep, soil_rests_under_a_pool) {
  for (const double level : {1.0, 1.5, 11.0}) {
    Json json = layer(2, 4, 1e-4);
    json["bodies"][0]["initial_stress"] = at_rest(level);
    json["pools"] = {{{"level", level}}};
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 1e-2, 50);
    for (const auto& u : solver->points().u) EXPECT_LT(u.norm(), 1e-8 / 4) << level;
    EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), 0, 1e-3 * water_density * 9.81);
    EXPECT_NEAR(probe(*solver, "water_out"), 0, 1e-6);
    EXPECT_NEAR(probe(*solver, "momentum_error_y") / (saturated_density * 9.81 * 0.5), 0, 1e-9);
  }
}

/// A level that rises over soil does what it does in implicit steps: the water that comes in, small
/// beside the pressure, differs by terms of the order of dt.
TEST(FractionalStep, level_that_rises_is_as_in_implicit_steps) {
  double difference[2];
  for (const bool fine : {false, true}) {
    double pressure[2], in[2];
    for (const bool fractional : {false, true}) {
      Json json = layer(2, 4, 1e-3);
      if (!fractional) json.erase("time_integration");
      json["bodies"][0]["initial_stress"] = at_rest(1.2);
      json["pools"] = {{{"table", {{0, 1.2}, {0.1, 2.2}}}}};
      const auto solver = mpm_solver<2>(json);
      const double before = water_of(*solver);
      run_steps(*solver, fine ? 5e-4 : 1e-3, fine ? 200 : 100);
      pressure[fractional] = probe(*solver, "A.pore_pressure");
      in[fractional] = -probe(*solver, "water_out") / water_density;
      EXPECT_NEAR((water_of(*solver) - before) / in[fractional], 1, 1e-3);
      EXPECT_NEAR(probe(*solver, "energy_balance") / probe(*solver, "boundary_work"), 0, 1e-6);
      EXPECT_NEAR(probe(*solver, "momentum_error_y") / (water_density * 9.81), 0, 1e-8);
    }
    EXPECT_NEAR(pressure[1], pressure[0], 0.003 * pressure[0]);
    difference[fine] = in[1] - in[0];
  }
  EXPECT_NEAR(difference[1] / difference[0], 0.5, 0.02);
}

/// Soil whose water hangs over a base that drains takes weak rain as a whole, strong rain up to
/// what it lets through (VW5).
TEST(FractionalStep, rain_is_that_of_implicit_steps) {
  for (const double rate : {0.5, 3.0}) {
    double taken[2], off[2];
    for (const bool fractional : {false, true}) {
      Json json = layer(2, 4, 2e-3);
      if (!fractional) json.erase("time_integration");
      json["walls"][0]["drained"] = true;
      json["rain"] = {{"table", {{0.3, 0}, {0.301, rate * 2e-3}}}};
      const auto solver = mpm_solver<2>(json);
      run_steps(*solver, 1e-3, 500);
      taken[fractional] = probe(*solver, "rain_in");
      off[fractional] = probe(*solver, "rain_run_off");
      EXPECT_NEAR((taken[fractional] + off[fractional]) / (rate * 2e-3 * water_density), 0.2, 1e-3);
    }
    EXPECT_GT(taken[0], 0.1);
    EXPECT_NEAR(taken[1], taken[0], 0.01 * taken[0]) << rate;
    EXPECT_EQ(off[0] > 0.1, rate > 1);
    EXPECT_EQ(off[1] > 0.1, rate > 1);
  }
}

TEST(FractionalStep, what_it_does_not_do_is_refused) {
  Json json = layer(2, 4, 1e-4);
  json["bodies"][0]["water"]["suction_limit"] = 1e4;
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/bodies/0/water/suction_limit", "explicit", "implicit"});
}

}  // namespace
}  // namespace gabion::test::test_fractional_step
