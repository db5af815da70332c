// SPDX-License-Identifier: BSD-3-Clause
// Soil that begins under the steady flow of its pore water.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "mpm_solver/points/retention.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_steady_seepage {
namespace {

constexpr double g = 9.81, gamma_w = water_density * g, k = 1e-4;
constexpr int cells = 8;
constexpr double h = 1.0 / cells;

mpm::PoreWater water_of(const Json& json) {
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = 2.2e9;
  water.cavitation = json["bodies"][0]["water"].value("suction_limit", 1e12);
  water.permeability = k;
  return water;
}

/// Saturated soil between smooth walls that starts in steady flow.
Json flow_scene(int dim = 2) {
  Json json =
      saturated_box(dim, dim == 2 ? "quad4" : "hex8", dim == 2 ? cells : 3, saturated_elastic());
  json["basis"] = "gimp";
  json["analysis"] = "quasi_static";
  json["bodies"][0]["water"]["permeability"] = k;
  json["bodies"][0]["initial_stress"] = {
      {"k0", 0.5}, {"surface", 1}, {"pore_pressure", "steady_seepage"}};
  return json;
}

/// Water rises from a drained base under a head of `head` above it to the free surface.
Json rising(double head, int dim = 2) {
  Json json = flow_scene(dim);
  json["walls"][0]["drained"] = true;
  json["bodies"][0]["initial_stress"]["water_table"] = head;
  return json;
}

/// Largest difference of the pressure of a point from a function of its place, by that of a metre
/// of water.
template <int dim>
double pressure_error(const Json& json, const mpm::MpmSolver<dim>& solver,
                      const std::function<double(const Vector<dim>&)>& exact) {
  const auto& points = solver.points();
  const mpm::PoreWater water = water_of(json);
  double largest = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double found = mpm::water_pressure(water, points.water[p], points.J[p]);
    largest = std::max(largest, std::abs(found - exact(points.x[p])) / gamma_w);
  }
  return largest;
}

template <int dim>
double largest_motion(const mpm::MpmSolver<dim>& solver) {
  double largest = 0;
  for (const auto& u : solver.points().u) largest = std::max(largest, u.norm());
  return largest;
}

/// Effective vertical stress of the points against total less pressure at their depth, by the
/// total stress under the layer.
template <int dim>
double stress_error(const mpm::MpmSolver<dim>& solver,
                    const std::function<double(const Vector<dim>&)>& pressure) {
  const auto& points = solver.points();
  double largest = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double total = saturated_density * g * (1 - points.x[p][dim - 1]);
    const double found = points.tau[p][dim - 1] / points.J[p];
    const double p_w = pressure(points.x[p]);
    const double effective = -(total - p_w);
    largest = std::max(largest, std::abs(found + p_w - effective) / (saturated_density * g));
  }
  return largest;
}

/// The surface resists by a fiftieth of a cell, so the discharge is k (head - 1) / (1 + h / 50).
template <int dim>
void expect_rising_flow(double spacing) {
  const double head = 1.4, i = (head - 1) / (1 + spacing / 50);
  const Json json = rising(head, dim);
  const auto solver = mpm_solver<dim>(json);
  const std::function<double(const Vector<dim>&)> exact = [&](const Vector<dim>& x) {
    return gamma_w * (head - x[dim - 1] * (1 + i));
  };
  EXPECT_LT((pressure_error<dim>(json, *solver, exact)), 1e-6);
  EXPECT_LT(stress_error<dim>(*solver, exact), 1e-3);  // the strain of the soil
  EXPECT_NEAR(solver->summary()["initial_discharge"].template get<double>(), k * i, 1e-6 * k);
  EXPECT_LT(solver->summary()["initial_displacement"].template get<double>(), 1e-4 * spacing);
  run_steps(*solver, 10, 5);
  EXPECT_LT((pressure_error<dim>(json, *solver, exact)), 1e-4);
  EXPECT_LT(largest_motion(*solver), 1e-4 * spacing);
  EXPECT_NEAR(probe(*solver, "water_out"), 0, 1e-4 * k * i * 50 * water_density);
}

TEST(SteadySeepage, water_that_rises_to_the_surface_in_the_plane) {
  expect_rising_flow<2>(h);
}
TEST(SteadySeepage, water_that_rises_to_the_surface_in_space) {
  expect_rising_flow<3>(1.0 / 3);
}

/// Rain of half the permeability seeps down to a drained base, under suction on top.
TEST(SteadySeepage, rain_that_seeps_to_a_drained_base) {
  const double table = 0.3;
  Json json = rising(table);
  json["rain"] = {{"rate", k / 2}};
  const auto solver = mpm_solver<2>(json);
  const std::function<double(const Vector<2>&)> exact = [&](const Vector<2>& x) {
    return gamma_w * (table - x[1] / 2);
  };
  EXPECT_LT(pressure_error<2>(json, *solver, exact), 1e-5);
  EXPECT_LT(stress_error<2>(*solver, exact), 1e-3);
  EXPECT_NEAR(solver->summary()["initial_discharge"].get<double>(), k / 2, 1e-6 * k);
}

/// Soil between two heads, at its left and its right.
Json crossed(double left, double right) {
  Json json = flow_scene();
  json["pools"] = {{{"level", left}, {"to", 0.4}}, {{"level", right}, {"from", 0.6}}};
  json["walls"][1]["drained"] = json["walls"][2]["drained"] = true;
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  return json;
}

/// Heads fall linearly whatever the level of the water between the ends. Horizontal flow pushes the
/// soil along, which K0 alone does not balance.
TEST(SteadySeepage, water_that_crosses_between_two_heads) {
  const double left = 3, right = 1.5;
  for (const char* locking : {"fbar", "none"}) {
    SCOPED_TRACE(locking);
    Json json = crossed(left, right);
    json["locking"] = {{"method", locking}};
    const auto solver = mpm_solver<2>(json);
    const std::function<double(const Vector<2>&)> exact = [&](const Vector<2>& x) {
      return gamma_w * (left - (left - right) * x[0] - x[1]);
    };
    EXPECT_LT(pressure_error<2>(json, *solver, exact), 1e-5);
    const double discharge = k * (left - right);
    EXPECT_NEAR(solver->summary()["initial_discharge"].get<double>(), discharge, 1e-6 * discharge);
    EXPECT_LT(largest_motion(*solver), 1e-15);
    run_steps(*solver, 10, 3);
    EXPECT_LT(pressure_error<2>(json, *solver, exact), 1e-3);
    EXPECT_LT(largest_motion(*solver), 1e-3 * h);
  }
}

/// The same flow from the start of a run with inertia.
TEST(SteadySeepage, soil_in_flow_rests) {
  Json json = crossed(3, 1.5);
  json["analysis"] = "dynamic";
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.01, 20);
  EXPECT_LT(largest_motion(*solver), 1e-3 * h);
}

/// Water of drained walls brings the energy that seepage takes: rho_w g Q by the fall of the head.
TEST(SteadySeepage, heads_beyond_drained_walls_feed_the_dissipation) {
  const double left = 3, right = 1.5, dt = 100;
  const auto solver = mpm_solver<2>(crossed(left, right));
  run_steps(*solver, dt, 2);
  const double before = probe(*solver, "plastic_dissipation");
  const double supplied = probe(*solver, "boundary_work");
  run_steps(*solver, dt, 3, 3);
  const double power = gamma_w * k * (left - right) * (left - right);
  EXPECT_NEAR(probe(*solver, "plastic_dissipation") - before, power * 3 * dt,
              1e-3 * power * 3 * dt);
  EXPECT_NEAR(probe(*solver, "boundary_work") - supplied, power * 3 * dt, 1e-5 * power * 3 * dt);
  EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-6 * power * dt);
}

TEST(SteadySeepage, explicit_steps_book_the_same_work) {
  if (size() > 1) return;
  Json json = crossed(3, 1.5);
  json["analysis"] = "dynamic";
  json["time_integration"] = {{"scheme", "explicit"}};
  json.erase("newton");
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.01, 10);
  const double power = gamma_w * k * 1.5 * 1.5;
  EXPECT_NEAR(probe(*solver, "boundary_work"), power * 0.1, 0.02 * power * 0.1);
  EXPECT_NEAR(probe(*solver, "plastic_dissipation"), power * 0.1, 0.02 * power * 0.1);
}

/// A rigid wall beside soil through which water rises bears the water and what is left of the
/// grains.
TEST(SteadySeepage, wall_beside_soil_in_flow) {
  const double head = 1.4, i = (head - 1) / (1 + h / 50);
  Json json = rising(head);
  json["grid"] = box({0, 0}, {1 + 2 * h, 1 + 2 * h}, {cells + 2, cells + 2}, "quad4");
  json["walls"].erase(2);
  json["rigid_walls"] = {{{"name", "wall"},
                          {"surface", {{"polyline", {{1, 1.2}, {1, 0}}}, {"spacing", 0.05}}},
                          {"friction", 0}}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1, 3);
  const double water = gamma_w * (head - (1 + i) / 2);
  const double soil = 0.5 * (saturated_density * g / 2 - water);
  EXPECT_NEAR(probe(*solver, "wall.fx"), water + soil, 0.01 * (water + soil));
}

/// Permeability by Kozeny and Carman sees the pores that the stress leaves.
TEST(SteadySeepage, permeability_that_follows_the_pores) {
  Json json = rising(1.4);
  json["bodies"][0]["water"]["permeability_law"] = "kozeny_carman";
  json["bodies"][0]["material"]["young_modulus"] = 1e6;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 100, 3);
  EXPECT_LT(largest_motion(*solver), 1e-3 * h);
}

TEST(SteadySeepage, number_of_ranks_does_not_change_the_start) {
  for (const bool with_air : {false, true}) {
    Json json = crossed(3, 1.5);
    if (with_air) {
      json["pools"] = {{{"level", 0.9}, {"to", 0}}, {{"level", 0.3}, {"from", 1}}};
      json["bodies"][0]["water"]["suction_limit"] = 2 * gamma_w * h;
    }
    const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
    const auto &a = shared->points(), &b = alone->points();
    for (std::int32_t p = 0; p < a.size(); ++p) {
      const std::int32_t q = mpm::find_point(b, a.id[p]);
      ASSERT_GE(q, 0);
      EXPECT_NEAR(a.water[p], b.water[q], 1e-6);
      EXPECT_NEAR(a.J[p], b.J[q], 1e-7);
      EXPECT_LT((a.tau[p] - b.tau[q]).norm(), 1);
    }
    EXPECT_NEAR(shared->summary()["initial_discharge"].get<double>(),
                alone->summary()["initial_discharge"].get<double>(), 1e-6 * k);
  }
}

TEST(SteadySeepage, run_that_goes_on_is_the_same) {
  if (size() > 1) return;
  const Json json = rising(1.4);
  const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
             second = mpm_solver<2>(json);
  EXPECT_TRUE(same_bits<2>(first->points(), second->points()));
  run_steps(*straight, 1, 4);
  run_steps(*first, 1, 2);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, 1, 2, 3);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
}

TEST(SteadySeepage, starts_that_are_refused) {
  const std::string where = "/bodies/0/initial_stress/pore_pressure";
  const auto refused = [](const Json& json, const std::vector<std::string_view>& parts) {
    expect_error<ConfigError>([&] { mpm_solver<2>(json); }, parts);
  };
  refused(flow_scene(), {where, "sets the pressure", "drained"});  // water leaves, none comes
  Json json = flow_scene();
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  refused(json, {where, "sets the pressure"});
  json = rising(1.4);
  json["bodies"][0]["water"].erase("permeability");
  json["locking"] = {{"method", "fbar"}};
  json["walls"][0].erase("drained");
  refused(json, {where, "permeability"});
  json = rising(2.2);
  json["bodies"][0]["material"] = saturated_sand();
  refused(json, {where, "lifts", "Pa"});
  json = rising(1.4);
  json["bodies"][0]["initial_stress"]["saturation_above"] = 0.5;
  refused(json, {"/bodies/0/initial_stress/saturation_above"});
  json = rising(1.4);
  json["bodies"][0]["initial_stress"]["pore_pressure"] = "seepage";
  refused(json, {where, "seepage", "steady_seepage"});
  json = rising(1.4);
  json["bodies"][0].erase("water");
  json["walls"][0].erase("drained");
  json["bodies"][0]["initial_stress"].erase("water_table");
  refused(json, {where, "water"});
  json = rising(1.4);
  json["bodies"].push_back(json["bodies"][0]);
  json["bodies"][1]["name"] = "other";
  json["bodies"][1]["mesh"] = box({0, 1}, {1, 1 + h}, {cells, 1}, "quad4");
  json["bodies"][1].erase("initial_stress");
  refused(json, {"/bodies/1/initial_stress/pore_pressure", "all bodies"});
}

}  // namespace
}  // namespace gabion::test::test_steady_seepage
