// SPDX-License-Identifier: BSD-3-Clause
// Free water over soil whose pore water drains.
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/contact/pool_forces.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_pools {
namespace {

constexpr double g = 9.81, gamma_w = water_density * g;
constexpr double buoyant = (saturated_density - water_density) * g;

mpm::Pool pool(double level) {
  mpm::Pool result;
  result.level = TimeFunction::constant(level);
  return result;
}

mpm::MpmSettings<2> read(const Json& json) {
  return mpm_settings<2>(json);
}

TEST(Pools, pressure_on_a_segment_is_exact_wherever_the_level_cuts_it) {
  const std::vector<mpm::Pool> pools = {pool(0.7)};
  const mpm::PoolLevels levels(pools, 0, gamma_w);
  for (const double top : {0.2, 0.7, 1.0, 3.0}) {
    const auto sums = mpm::pool_pressure_on<2>(levels, {Vector<2>(2, 0), Vector<2>(2, top)});
    const double H = 0.7, wet = std::min(top, H);
    EXPECT_NEAR(sums[0] + sums[1], gamma_w * (H * wet - wet * wet / 2), 1e-9);
    EXPECT_NEAR(sums[1] * top, gamma_w * (H * wet * wet / 2 - wet * wet * wet / 3), 1e-9);
  }
  const auto dry = mpm::pool_pressure_on<2>(levels, {Vector<2>(2, 1), Vector<2>(2, 2)});
  EXPECT_EQ(dry[0] + dry[1], 0);
}

/// A level facet under a ramp between two pools: that of a trapezium.
TEST(Pools, pressure_follows_the_level_between_pools) {
  std::vector<mpm::Pool> pools = {pool(3), pool(1)};
  pools[0].to = 1;
  pools[1].from = 3;
  const mpm::PoolLevels levels(pools, 0, 1);
  EXPECT_EQ(levels.level(2), 2);
  EXPECT_EQ(levels.slope(2), -1);
  const auto sums = mpm::pool_pressure_on<2>(levels, {Vector<2>(0, 0.5), Vector<2>(4, 0.5)});
  EXPECT_NEAR(sums[0] + sums[1], 2.5 + 3 + 0.5, 1e-12);
  const auto above = mpm::pool_pressure_on<2>(levels, {Vector<2>(0, 2), Vector<2>(4, 2)});
  EXPECT_NEAR(above[0] + above[1], 1 + 0.5, 1e-12);
}

TEST(Pools, pressure_on_triangles_is_exact) {
  const std::vector<mpm::Pool> pools = {pool(0.7)};
  const mpm::PoolLevels levels(pools, 0, gamma_w);
  double force = 0, moment = 0;
  const Vector<3> a(0, 0, 0), b(0, 1, 0), c(0, 1, 1), d(0, 0, 1);
  for (const auto& corners : {std::array{a, b, c}, std::array{a, c, d}}) {
    const auto sums = mpm::pool_pressure_on<3>(levels, corners);
    for (int k = 0; k < 3; ++k) force += sums[k], moment += sums[k] * corners[k][2];
  }
  EXPECT_NEAR(force, gamma_w * 0.49 / 2, 1e-9);
  EXPECT_NEAR(moment, gamma_w * 0.343 / 6, 1e-9);
}

/// Saturated soil at rest under a pool.
Json flooded_box(double level, const std::string& analysis = "quasi_static") {
  Json json = saturated_box(2, "quad4", 4, saturated_elastic());
  json["basis"] = "gimp";
  json["analysis"] = analysis;
  json["bodies"][0]["water"]["permeability"] = 1e-4;
  json["bodies"][0]["initial_stress"] = at_rest(level);
  json["pools"] = {{{"level", level}}};
  json["probes"] = {{{"name", "A"}, {"point", {0.4, 0.1}}}};
  return json;
}

double largest_motion(const mpm::MpmSolver<2>& solver) {
  double largest = 0;
  for (const auto& u : solver.points().u) largest = std::max(largest, u.norm());
  return largest;
}

TEST(Pools, soil_under_water_rests) {
  for (const char* analysis : {"quasi_static", "dynamic"}) {
    for (const double level : {1.0, 1.1, 1.5, 11.0}) {
      for (const char* locking : {"fbar", "none"}) {
        SCOPED_TRACE(std::string(analysis) + " " + std::to_string(level) + " " + locking);
        Json json = flooded_box(level, analysis);
        json["locking"] = {{"method", locking}};
        const auto solver = mpm_solver<2>(json);
        run_steps(*solver, 0.05, 50);
        EXPECT_LT(largest_motion(*solver), 1e-6 / 4);
        EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), 0, 1e-5 * gamma_w / 4);
        EXPECT_NEAR(probe(*solver, "water_out"), 0, 1e-6);
      }
    }
  }
}

/// Forces on walls of the grid: the base carries soil and water, a side the thrust of both.
TEST(Pools, walls_of_the_grid_carry_soil_and_water) {
  const double level = 1.5;
  const auto solver = mpm_solver<2>(flooded_box(level));
  run_steps(*solver, 1, 1);
  const double base = buoyant + gamma_w * level;
  EXPECT_NEAR(probe(*solver, "wall.bottom.fy"), -base, 1e-3 * base);
  const double side = 0.5 * buoyant / 2 + gamma_w * (level * 1.25 - 1.25 * 1.25 / 2);
  EXPECT_NEAR(probe(*solver, "wall.right.fx"), side, 1e-2 * side);
}

/// Force and moment about its foot of a wall beside soil and water, wherever it cuts a cell.
TEST(Pools, wall_beside_soil_and_water) {
  const double h = 0.25, level = 1.25;
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    SCOPED_TRACE(offset);
    const double x = 1 + offset * h;
    Json json = flooded_box(level);
    json["grid"] = box({0, 0}, {1.5, 1.5}, {6, 6}, "quad4");
    json["bodies"][0]["mesh"] = box({0, 0}, {x, 1}, {offset > 0 ? 5 : 4, 4}, "quad4");
    json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
    json["rigid_walls"] = {{{"name", "wall"},
                            {"surface", {{"polyline", {{x, level}, {x, 0}}}, {"spacing", 0.05}}},
                            {"moment_about", {x, 0}},
                            {"friction", 0}}};
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 0.05, 20);
    const double water = gamma_w * level * level / 2;
    const double soil = 0.5 * buoyant / 2;
    EXPECT_NEAR(probe(*solver, "wall.fx"), water + soil, 0.01 * (water + soil));
    const double moment = water * level / 3 + soil / 3;
    EXPECT_NEAR(std::abs(probe(*solver, "wall.mz")), moment, 0.01 * moment);
  }
}

/// The water presses on a surface of a structure before soil reaches it.
TEST(Pools, surface_that_soil_has_not_reached) {
  const double level = 1.25, x = 1.7;
  for (const bool explicit_steps : {false, true}) {
    Json json = flooded_box(level, "dynamic");
    json["grid"] = box({0, 0}, {2, 1.5}, {8, 6}, "quad4");
    json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
    json["interfaces"] = {
        {{"name", "wall"}, {"surface", {{"polyline", {{x, 1.5}, {x, 0}}}, {"spacing", 0.05}}}}};
    if (explicit_steps) {
      json["time_integration"] = {{"scheme", "explicit"}};
      json.erase("newton");
    }
    const auto solver = mpm_solver<2>(json);
    InterfaceValues sent;
    const StepReport report = solver->solve_step({1, 0, 0, 1e-3}, {}, sent);
    EXPECT_TRUE(report.interface_active);
    double force = 0;
    for (std::size_t i = 0; i < sent.at("wall").size(); i += 2) force += sent.at("wall")[i];
    const double thrust = gamma_w * level * level / 2;
    EXPECT_NEAR(force, thrust, 1e-3 * thrust) << explicit_steps;
  }
}

/// A level that rises and falls slowly leaves the grains as they were.
TEST(Pools, level_rises_and_falls) {
  Json json = flooded_box(1.25);
  json["pools"] = {{{"table", {{0, 1.25}, {10, 3}, {20, 1.25}}}}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1, 1);
  const double before = probe(*solver, "A.effective_stress_yy");
  run_steps(*solver, 1, 9, 2);
  const double rise = gamma_w * 1.75;
  EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), rise, 1e-3 * rise);
  EXPECT_NEAR(probe(*solver, "A.effective_stress_yy"), before, 1e-3 * rise);
  run_steps(*solver, 1, 12, 11);
  EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), 0, 1e-3 * rise);
  EXPECT_LT(largest_motion(*solver), 1e-4 / 4);
  const double energy = probe(*solver, "energy_balance");
  EXPECT_NEAR(energy, 0, 1e-3 * std::abs(probe(*solver, "boundary_work")) + 1e-9);
}

/// Sand that loses its wall falls in the same way under any depth of water.
TEST(Pools, motion_does_not_depend_on_the_level) {
  std::vector<double> kinetic;
  for (const double level : {1.25, 50.0}) {
    Json json = flooded_box(level, "dynamic");
    json["grid"] = box({0, 0}, {2, 1.25}, {8, 5}, "quad4");
    json["walls"] = {wall("bottom", "fixed"), wall("left", "slip")};
    json["bodies"][0]["material"] = saturated_sand();
    json["bodies"][0]["water"]["permeability"] = 1;
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 5e-3, 40);
    kinetic.push_back(probe(*solver, "kinetic_energy"));
    EXPECT_GT(kinetic.back(), 20);
  }
  EXPECT_NEAR(kinetic[1], kinetic[0], 0.01 * kinetic[0]);
}

/// Soil free of stress that is laid under water bears its buoyant weight in the end, whatever the
/// depth of the water, and its momentum is that of all forces.
TEST(Pools, soil_laid_under_water_bears_its_buoyant_weight) {
  Json json = flooded_box(1);
  json["bodies"][0].erase("initial_stress");
  json["pools"] = {{{"level", 4}}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 100, 6);
  // The point is in the lowest cell, which has the strain of its middle.
  EXPECT_NEAR(probe(*solver, "A.effective_stress_yy"), -buoyant * 0.875, 1e-3 * buoyant);
  EXPECT_NEAR(probe(*solver, "A.pore_pressure"), gamma_w * (4 - 0.0625), 1e-4 * gamma_w);
  EXPECT_NEAR(probe(*solver, "momentum_error_y"), 0, 1e-9 * gamma_w * 600);
}

/// A dam of columns up to the line of Dupuit (1863) between two levels.
struct Dam {
  double left = 1, right = 0.5, length = 2, k = 1e-4;
  double top(double x) const {
    return std::sqrt(left * left - (left * left - right * right) * x / length);
  }
  double discharge() const { return k * (left * left - right * right) / (2 * length); }
};

Json dam_scene(const Dam& dam) {
  const int columns = 20;
  const double h = dam.length / columns;
  Json json = {{"dimension", 2},
               {"grid", box({-h, 0}, {dam.length + h, 1.2}, {columns + 2, 12}, "quad4")},
               {"basis", "gimp"},
               {"analysis", "quasi_static"},
               {"gravity", {0, -g}},
               {"walls", {wall("bottom", "fixed")}},
               {"bodies", Json::array()},
               {"pools", {{{"level", dam.left}, {"to", 0}}, {{"level", dam.right}, {"from", 2}}}},
               {"newton", exact_newton}};
  for (int c = 0; c < columns; ++c) {
    const double top = dam.top((c + 0.5) * h);
    Json column =
        body("column" + std::to_string(c),
             box({c * h, 0}, {(c + 1) * h, top}, {1, static_cast<int>(10 * top + 0.999)}, "quad4"),
             4, elastic_soil("hencky_elastic", 1e9, 0.3, saturated_density));
    column["water"] = pore_water;
    column["water"]["permeability"] = dam.k;
    json["bodies"].push_back(column);
  }
  return json;
}

/// Integral over the height of the head of a column's points [m^2].
double sum_of_heads(const mpm::MpmSolver<2>& solver, int column) {
  const auto& points = solver.points();
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = 2.2e9;
  water.cavitation = 1e9;
  double sum = 0;
  for (std::int32_t p = points.body_starts[column]; p < points.body_starts[column + 1]; ++p) {
    const double pressure = water.at(points.water[p], points.J[p]).p;
    sum += points.V0[p] * points.J[p] / 0.1 * pressure / gamma_w;
  }
  return sum;
}

/// Discharge per width by Girinskii's potential: the flow through a section is -k d/dx of the
/// integral of p / (rho_w g) over its height, where p = 0 on top.
TEST(Pools, dam_between_two_levels_lets_through_what_dupuit_has) {
  const Dam dam;
  const auto solver = mpm_solver<2>(dam_scene(dam));
  run_steps(*solver, 1e6, 3);
  const double found = dam.k * (sum_of_heads(*solver, 5) - sum_of_heads(*solver, 14)) / 0.9;
  EXPECT_NEAR(found, dam.discharge(), 0.05 * dam.discharge());
  const double left = sum_of_heads(*solver, 0), right = sum_of_heads(*solver, 19);
  EXPECT_NEAR(left, dam.left * dam.left / 2, 0.05 * left);
  EXPECT_NEAR(right, dam.right * dam.right / 2, 0.15 * right);
  const double before = probe(*solver, "water_out");
  run_steps(*solver, 1e6, 1, 4);
  EXPECT_NEAR(probe(*solver, "water_out") - before, 0, 1e-6 * dam.discharge() * 1e6 * 1000);
}

TEST(Pools, run_that_goes_on_is_the_same) {
  Json json = flooded_box(1.25, "dynamic");
  json["pools"] = {{{"table", {{0, 1.25}, {1, 3}}}}};
  const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
             second = mpm_solver<2>(json);
  run_steps(*straight, 0.05, 8);
  run_steps(*first, 0.05, 3);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, 0.05, 5, 4);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
}

TEST(Pools, settings_that_are_refused) {
  const auto refused = [](const Json& change, const std::vector<std::string_view>& parts) {
    Json json = flooded_box(1.5);
    json.merge_patch(change);
    expect_error<ConfigError>([&] { read(json); }, parts);
  };
  EXPECT_NO_THROW(read(flooded_box(1.5)));
  refused({{"pools", Json::array()}}, {"/bodies/0/initial_stress/water_table", "1.5", "pools"});
  refused({{"pools", {{{"level", 1.4}}}}}, {"/bodies/0/initial_stress/water_table", "1.4"});
  refused({{"pools", {Json::object()}}}, {"/pools/0/level", "exactly one"});
  refused({{"pools", {{{"level", 1.5}, {"from", 1}}}}}, {"/pools/0/from", "none"});
  refused({{"pools", {{{"level", 1.5}, {"to", 1}}}}}, {"/pools/0/to", "none"});
  refused({{"pools", {{{"level", 1.5}, {"to", 1}}, {{"level", 1.5}, {"from", 1}}}}},
          {"/pools/1/from", "more than 1"});
  refused({{"pools", {{{"table", {{1, 1.5}, {1, 2}}}}}}}, {"/pools/0/table/1", "increasing"});
  refused({{"gravity", {1, -9.81}}}, {"/gravity", "last axis"});
  Json json = flooded_box(1);
  json["locking"] = {{"method", "fbar"}};
  json["bodies"][0]["water"].erase("permeability");
  expect_error<ConfigError>([&] { read(json); }, {"/bodies/0/water", "permeability", "pools"});
}

/// A wall of 0.1 m, whose top is off by `lean`, with pools that end at `to` and begin 0.02 m
/// beyond.
/// @returns what reading it says
std::string said_of_wall(double lean, double left, double right, double to = 0.54) {
  Json json = flooded_box(1);
  json["pools"] = {{{"level", left}, {"to", to}}, {{"level", right}, {"from", to + 0.02}}};
  const Json corners = {{0.6, 1}, {0.6 + lean, 2}, {0.5 + lean, 2}, {0.5, 1}, {0.6, 1}};
  json["rigid_walls"] = {
      {{"name", "gate"}, {"surface", {{"polyline", corners}, {"spacing", 0.1}}}}};
  testing::internal::CaptureStderr();
  read(json);
  return testing::internal::GetCapturedStderr();
}

/// Below a face that leans over water the level of a pool would be that of the other side.
TEST(Pools, wall_that_leans_between_pools_is_named) {
  for (const double lean : {-0.3, -0.04, 0.04, 0.3}) {
    expect_parts(said_of_wall(lean, 1.5, 1.2),
                 {"/rigid_walls/0/surface", "\"gate\" leans over water", "between pools 0 and 1"});
  }
  const std::string upright = said_of_wall(0, 1.5, 1.2), nearly = said_of_wall(1e-4, 1.5, 1.2),
                    dry = said_of_wall(0.3, 1, 1), in_one_pool = said_of_wall(0.3, 1.5, 1.2, 5);
  for (const std::string& said : {upright, nearly, dry, in_one_pool}) {
    EXPECT_EQ(said.find("leans"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace gabion::test::test_pools
