// SPDX-License-Identifier: BSD-3-Clause
// Soil whose pore water drains on rigid walls: friction of the grains, walls that drain, and soil
// that flows.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test {
namespace {

constexpr double pi = 3.14159265358979324;
constexpr double E = 10e6, nu = 0.2, M = 11.1111111e6, g = 9.81, c_v = M * 1e-10;

/// A layer 1 m deep between smooth walls on a floor of facets, laid at once.
Json layer_on_floor(double offset, double friction) {
  const double h = 0.1, low = h * (1 + offset);
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {2 * h, 1 + 4 * h}, {2, 14}, "quad4")},
               {"basis", "gimp"},
               {"analysis", "quasi_static"},
               {"gravity", {0, -g}},
               {"walls", {wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("soil", box({0, low}, {2 * h, low + 1}, {2, 10}, "quad4"), 4,
                      elastic_soil("hencky_elastic", E, nu, saturated_density))}},
               {"rigid_walls",
                {{{"name", "floor"},
                  {"surface", {{"polyline", {{50, low}, {-50, low}}}, {"spacing", 50}}},
                  {"friction", friction}}}}};
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = 9.81e-7;
  return json;
}

/// Excess pressure under a layer that drains on top, by that at the start.
double excess_below(double T) {
  double sum = 0;
  for (int i = 0; i < 200; ++i) {
    const double l = (2 * i + 1) * pi / 2;
    sum += 2 / (l * l) * std::exp(-l * l * T);
  }
  return sum;
}

/// The floor is drawn along under the layer, and takes the friction of what the grains bear: next
/// to none at the start, that of the buoyant weight in the end.
TEST(WetSurfaces, friction_is_that_of_the_effective_stress) {
  const double mu = 0.05;
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    Json json = layer_on_floor(offset, mu);
    json["rigid_walls"][0]["motion"] = {{"velocity", {1e-3, 0}}};
    const auto solver = mpm_solver<2>(json);
    const int steps = 50;
    const double dt = 0.5 / c_v / steps;
    int done = 0;
    for (const int step : {10, 20, 50}) {
      run_steps(*solver, dt, step - done, done + 1);
      done = step;
      const double T = 0.5 * step / steps;
      const double expected = mu * (1 - water_density / saturated_density) * (1 - excess_below(T));
      const double found = probe(*solver, "floor.fx") / probe(*solver, "floor.fy");
      EXPECT_NEAR(std::abs(found), expected, 0.02 * mu) << offset << " " << T;
    }
  }
}

/// Where the floor drains, water has no pressure against it, and all of the weight rubs.
TEST(WetSurfaces, friction_of_a_floor_that_drains_is_that_of_the_total_stress) {
  const double mu = 0.05;
  Json json = layer_on_floor(1.0 / 3, mu);
  json["rigid_walls"][0]["motion"] = {{"velocity", {1e-3, 0}}};
  json["rigid_walls"][0]["drained"] = true;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.01 / c_v, 5);
  const double found = probe(*solver, "floor.fx") / probe(*solver, "floor.fy");
  EXPECT_NEAR(std::abs(found), mu, 1e-3 * mu);
}

/// A floor that drains takes the water as air would, and leaves less than half of the excess.
TEST(WetSurfaces, floor_that_drains) {
  Json json = layer_on_floor(1.0 / 3, 0);
  const auto closed = mpm_solver<2>(json);
  json["rigid_walls"][0]["drained"] = true;
  const auto open = mpm_solver<2>(json);
  for (const auto& solver : {closed.get(), open.get()}) run_steps(*solver, 0.1 / c_v / 20, 20);
  EXPECT_GT(probe(*open, "water_out"), 2 * probe(*closed, "water_out"));
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = 2.2e9;
  water.cavitation = 1e9;
  double below = 0;
  const auto& points = open->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    if (points.x[p][1] > 0.1 * 4 / 3 + 0.05) continue;
    below = std::max(below, water.at(points.water[p], points.J[p]).p);
  }
  EXPECT_LT(below, 0.15 * saturated_density * g);
}

TEST(WetSurfaces, drained_surface_without_water_is_refused) {
  Json json = layer_on_floor(0, 0);
  json["rigid_walls"][0]["drained"] = true;
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/rigid_walls/0", "drained", "seepage_face"});
}

/// Sand that slumps as its water drains: nodes on which hardly any soil weighs do not keep Newton's
/// method from its end, whatever the permeability. Points that change cells share their strain and
/// keep their pressure, which changes the mass of their water by a share of p / K_w.
TEST(WetSurfaces, wet_sand_flows) {
  for (const char* basis : {"gimp", "bspline"}) {
    for (const double k : {1e-5, 1e-3}) {
      for (const char* surface : {"seepage_face", "impervious"}) {
        SCOPED_TRACE(std::string(basis) + " " + std::to_string(k) + " " + surface);
        Json json = {
            {"dimension", 2},
            {"grid", box({0, 0}, {2, 0.8}, {20, 8}, "quad4")},
            {"basis", basis},
            {"gravity", {0, -g}},
            {"walls", {wall("left", "slip"), wall("bottom", "fixed"), wall("right", "slip")}},
            {"bodies",
             {body("sand", box({0, 0}, {1, 0.5}, {10, 5}, "quad4"), 4, saturated_sand())}}};
        json["bodies"][0]["material"]["young_modulus"] = 5e6;
        json["bodies"][0]["water"] = {
            {"porosity", 0.4}, {"bulk_modulus", 2e8}, {"permeability", k}};
        json["bodies"][0]["water"]["free_surface"] = surface;
        const auto solver = mpm_solver<2>(json);
        const double mass = probe(*solver, "mass");
        EXPECT_NO_THROW(run_steps(*solver, 4e-3, 90));
        const double out = probe(*solver, "water_out");
        EXPECT_EQ(out > 0, surface == std::string("seepage_face"));
        EXPECT_NEAR(probe(*solver, "mass") + out, mass, 1e-8 * mass);
      }
    }
  }
}

}  // namespace
}  // namespace gabion::test
