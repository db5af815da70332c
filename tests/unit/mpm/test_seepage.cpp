// SPDX-License-Identifier: BSD-3-Clause
// Soil whose pore water drains, in whole scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_seepage {
namespace {

constexpr double pi = 3.14159265358979324;

/// Part of Terzaghi's column (1923), one-dimensional consolidation under a sudden load q.
/// @param z  distance from the drained end, by the height
/// @returns p / q
double terzaghi_pressure(double z, double T) {
  double sum = 0;
  for (int i = 0; i < 200; ++i) {
    const double l = (2 * i + 1) * pi / 2;
    sum += 2 / l * std::sin(l * z) * std::exp(-l * l * T);
  }
  return sum;
}
/// Settlement by its final value.
double terzaghi_degree(double T) {
  double sum = 1;
  for (int i = 0; i < 200; ++i) {
    const double l = (2 * i + 1) * pi / 2;
    sum -= 2 / (l * l) * std::exp(-l * l * T);
  }
  return sum;
}

/// A column of soil between smooth walls under a heavy plate, with next to no weight of its own;
/// its base is drained.
struct Column {
  int cells = 10;
  std::string basis = "gimp", locking = "fbar";
  double T = 0.1;
  int steps = 50;
  double load = 10e3, K_w = 2.2e9;
};
constexpr double column_E = 10e6, column_nu = 0.2, column_k = 9.81e-7;
constexpr double column_M = 11.1111111e6, column_cv = column_M * 1e-10;

Json column_scene(const Column& column) {
  const double h = 1.0 / column.cells, g = 1e-3;
  const Json plate_material = elastic_soil("hencky_elastic", 1e9, 0, column.load / (g * h));
  Json json = {
      {"dimension", 2},
      {"grid", box({0, 0}, {h, 1 + 2 * h}, {1, column.cells + 2}, "quad4")},
      {"basis", column.basis},
      {"analysis", "quasi_static"},
      {"gravity", {0, -g}},
      {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
      {"bodies",
       {body("soil", box({0, 0}, {h, 1}, {1, column.cells}, "quad4"), 4,
             elastic_soil("hencky_elastic", column_E, column_nu, saturated_density)),
        body("plate", box({0, 1}, {h, 1 + h}, {1, 1}, "quad4"), 4, plate_material)}},
      {"locking", {{"method", column.locking}}},
      {"probes",
       {{{"name", "top"}, {"point", {h / 2, 1}}}, {{"name", "middle"}, {"point", {h / 2, 0.5}}}}}};
  json["walls"][0]["drained"] = true;
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = column_k;
  json["bodies"][0]["water"]["bulk_modulus"] = column.K_w;
  return json;
}

mpm::PoreWater column_water(const Column& column) {
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = column.K_w;
  water.cavitation = 1e9;
  return water;
}

struct Isochrone {
  double pressure_error = 0;   ///< largest difference of p / q
  double degree = 0;           ///< settlement by its final value
  double lost = 0;             ///< water of the points and out of them, by what went out
  double energy_missing = 0;   ///< of the energy balance, by the work of gravity
  double impulse_missing = 0;  ///< of the balance of momentum, by the impulse of the load
};

Isochrone consolidate(const Column& column) {
  const auto solver = mpm_solver<2>(column_scene(column));
  const auto water = [&] {
    const auto& points = solver->points();
    double sum = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) sum += points.V0[p] * points.water[p];
    return sum;
  };
  const double before = water();
  run_steps(*solver, column.T / column_cv / column.steps, column.steps);
  const auto& points = solver->points();
  const mpm::PoreWater pores = column_water(column);
  Isochrone result;
  double strain = 0, height = 0;
  for (std::int32_t p = points.body_starts[0]; p < points.body_starts[1]; ++p) {
    const double z = points.x[p][1];
    const double pressure = pores.at(points.water[p], points.J[p]).p / column.load;
    result.pressure_error =
        std::max(result.pressure_error, std::abs(pressure - terzaghi_pressure(z, column.T)));
    strain += points.V0[p] * (1 - points.J[p]);
    height += points.V0[p];
  }
  result.degree = strain / height * column_M / column.load;
  const double out = probe(*solver, "water_out") / water_density;
  result.lost = (before - water() - out) / out;
  result.energy_missing = probe(*solver, "energy_balance") / probe(*solver, "gravity_work");
  result.impulse_missing =
      probe(*solver, "momentum_error_y") / (column.load / column.cells * column.T / column_cv);
  return result;
}

TEST(Seepage, column_under_a_load_consolidates_as_terzaghi_has_it) {
  for (const char* basis : {"gimp", "bspline"}) {
    for (const char* locking : {"fbar", "none"}) {
      SCOPED_TRACE(std::string(basis) + " " + locking);
      const Column column{.basis = basis, .locking = locking};
      const Isochrone at = consolidate(column);
      EXPECT_LT(at.pressure_error, 0.01);
      EXPECT_NEAR(at.degree, terzaghi_degree(column.T), 0.01);
      EXPECT_NEAR(at.lost, 0, 1e-9);
      EXPECT_NEAR(at.energy_missing, 0, 2e-3);  // of the trapezoidal rule
      EXPECT_NEAR(at.impulse_missing, 0, 1e-9);
    }
  }
}

TEST(Seepage, error_of_the_isochrone_falls_with_cells_and_steps) {
  const auto error = [](int cells, int steps) {
    return consolidate({.cells = cells, .steps = steps, .load = 1e3, .K_w = 2.2e11}).pressure_error;
  };
  const double coarse = error(5, 40), fine = error(10, 160);
  EXPECT_GT(std::log2(coarse / fine), 1.8) << coarse << " " << fine;
}

/// Pressures do not alternate in the first step after a load jumps, however short it is.
TEST(Seepage, first_step_after_a_jump_has_no_oscillation) {
  for (const double T : {1e-7, 1e-3}) {
    const Column column{.T = T, .steps = 1};
    const auto solver = mpm_solver<2>(column_scene(column));
    run_steps(*solver, T / column_cv, 1);
    const auto& points = solver->points();
    const mpm::PoreWater pores = column_water(column);
    for (std::int32_t p = points.body_starts[0]; p < points.body_starts[1]; ++p) {
      EXPECT_LT(pores.at(points.water[p], points.J[p]).p, 1.02 * column.load) << T;
    }
  }
}

/// Splines at borders do not integrate a weight exactly, so soil settles a little, wet or dry.
TEST(Seepage, soil_rests_under_its_water_table) {
  for (const char* analysis : {"quasi_static", "dynamic"}) {
    for (const char* basis : {"gimp", "bspline"}) {
      SCOPED_TRACE(std::string(analysis) + " " + basis);
      Json json = saturated_box(2, "quad4", 4, saturated_elastic());
      json["basis"] = basis;
      json["analysis"] = analysis;
      json["walls"][1]["drained"] = true;
      json["bodies"][0]["water"]["permeability"] = 1e-4;
      json["bodies"][0]["initial_stress"] = at_rest(1);
      json["probes"] = {{{"name", "A"}, {"point", {0.4, 0.1}}}};
      const auto solver = mpm_solver<2>(json);
      run_steps(*solver, 0.05, 20);
      double largest = 0;
      for (const auto& u : solver->points().u) largest = std::max(largest, u.norm());
      const bool splines = std::string(basis) == "bspline";
      EXPECT_LT(largest, (splines ? 1e-4 : 1e-6) / 4);
      EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), 0,
                  (splines ? 0.02 : 1e-5) * water_density * 9.81 / 4);
    }
  }
}

/// Without time to drain the water bears what undrained soil has it bear.
TEST(Seepage, water_that_hardly_drains_is_that_of_undrained_soil) {
  Json json = column_scene({.cells = 4, .load = 100e3});
  json["walls"][0].erase("drained");
  const auto draining = mpm_solver<2>(json);
  json["bodies"][0]["water"].erase("permeability");
  const auto undrained = mpm_solver<2>(json);
  for (const auto& solver : {undrained.get(), draining.get()}) run_steps(*solver, 0.1, 1);
  for (const char* quantity : {"middle.pore_pressure", "middle.effective_stress_yy", "middle.uy"}) {
    const double expected = probe(*undrained, quantity);
    EXPECT_NEAR(probe(*draining, quantity), expected, 2e-3 * std::abs(expected)) << quantity;
  }
}

/// A closed box under a gravity that is suddenly there: p / (rho g d) = Q / (M + Q), with no motion
/// of water (Skempton, 1954).
TEST(Seepage, confined_load_is_shared_by_the_stiffnesses) {
  Json json = column_scene({.cells = 4});
  json["walls"][0].erase("drained");
  json["bodies"][0]["water"]["bulk_modulus"] = 88e6;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1, 1);
  const double Q = 88e6 / 0.4;
  const double expected = 10e3 * Q / (Q + column_M);
  EXPECT_NEAR(probe(*solver, "middle.pore_pressure"), expected, 2e-3 * expected);
}

void expect_refused(const Json& change, const std::vector<std::string_view>& parts) {
  Json json = column_scene({});
  json.merge_patch(change);
  expect_error<ConfigError>([&] { mpm_settings<2>(json); }, parts);
}

TEST(Seepage, settings_that_are_refused) {
  expect_refused({{"basis", "linear"}}, {"/bodies/0/water/permeability", "linear", "gimp"});
  Json json = column_scene({});
  json["bodies"][0]["water"]["permeability"] = 2;
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/bodies/0/water/permeability", "found 2", "(0, 1]"});
  json = column_scene({});
  json["bodies"][0]["points_per_cell"] = 1;
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/bodies/0/points_per_cell", "found 1", "at least 4"});
  json = column_scene({});
  json["bodies"][0]["water"]["cavitation_pressure"] = 0;
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/bodies/0/water/cavitation_pressure", "permeability"});
  json = column_scene({});
  json["bodies"][0]["water"].erase("permeability");
  json["locking"] = {{"method", "fbar"}};
  expect_error<ConfigError>([&] { mpm_settings<2>(json); }, {"/walls/0", "drained"});
}

}  // namespace
}  // namespace gabion::test::test_seepage
