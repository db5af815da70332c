// SPDX-License-Identifier: BSD-3-Clause
// Wet soil on rigid walls: friction of the grains, walls that drain, and soil that flows.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_wet_surfaces {
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

/// A floor is as impervious under cells that are taller than wide.
TEST(WetSurfaces, floor_under_tall_cells_keeps_the_water) {
  double out[2];
  for (const int across : {2, 4}) {
    Json json = layer_on_floor(0, 0.3);
    json["bodies"][0]["mesh"] = box({0, 0.1}, {0.2, 1.1}, {across, 10}, "quad4");
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 0.05 / c_v, 4);
    out[across / 4] = probe(*solver, "water_out");
  }
  EXPECT_NEAR(out[1], out[0], 0.01 * out[0]);
}

/// Force of a slope on a block, along it and across it, beside soil elsewhere with this water.
Vector<2> force_on_block(const Json& block_water, const Json& other_water) {
  const auto soil = elastic_soil("hencky_elastic", E, nu, saturated_density);
  Json json = {{"dimension", 2},
               {"grid", box({0, -0.2}, {2, 0.4}, {20, 6}, "quad4")},
               {"basis", "gimp"},
               {"gravity", {0.5 * g, -std::sqrt(0.75) * g}},
               {"walls", {wall("right", "slip"), wall("bottom", "fixed")}},
               {"bodies",
                {body("block", box({0.43, 0}, {0.93, 0.2}, {5, 2}, "quad4"), 4, soil),
                 body("other", box({1.7, -0.2}, {2, 0.1}, {3, 3}, "quad4"), 4, soil)}},
               {"rigid_walls",
                {{{"name", "floor"},
                  {"surface", {{"polyline", {{1.6, 0.0}, {0.1, 0.0}}}, {"spacing", 1.5}}},
                  {"friction", 0.3}}}}};
  if (!block_water.is_null()) json["bodies"][0]["water"] = block_water;
  json["bodies"][1]["water"] = other_water;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 2e-3, 12);
  return {probe(*solver, "floor.fx"), probe(*solver, "floor.fy")};
}

/// Soil without water, and soil whose water does not drain, have the same friction beside soil that
/// drains.
TEST(WetSurfaces, soil_that_drains_elsewhere_changes_no_friction) {
  Json drains = pore_water;
  drains["permeability"] = 1e-6;
  for (const Json& block : {Json(), Json(pore_water)}) {
    const Vector<2> alone = force_on_block(block, pore_water);
    const Vector<2> beside = force_on_block(block, drains);
    const double coefficient = std::abs(beside[0] / beside[1]);
    if (block.is_null()) {
      EXPECT_NEAR(coefficient, 0.3, 1e-9);
    } else {
      EXPECT_LT(coefficient, 0.25);
    }
    EXPECT_LT((beside - alone).norm(), 1e-6 * alone.norm());
  }
}

/// Friction of a floor that is drawn along under soil whose water does not drain, by the
/// coefficient and the weight.
double share_that_rubs(double offset, double density, const Json& initial_stress) {
  const double mu = 0.05;
  Json json = layer_on_floor(offset, mu);
  json["rigid_walls"][0]["motion"] = {{"velocity", {1e-3, 0}}};
  Json& soil = json["bodies"][0];
  soil["water"].erase("permeability");
  soil["water"]["density"] = density;
  if (!initial_stress.is_null()) soil["initial_stress"] = initial_stress;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1, 10);
  return std::abs(probe(*solver, "floor.fx") / probe(*solver, "floor.fy")) / mu;
}

/// Laid with a water table at its top, grains bear the buoyant weight. Points of a cell share their
/// volume, so p is that of another depth in the cell.
TEST(WetSurfaces, friction_of_undrained_soil_at_rest_is_that_of_its_buoyant_weight) {
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    for (const double density : {1000.0, 1200.0}) {
      const double top = 1 + 0.1 * (1 + offset);
      const Json stress = {{"k0", 0.5}, {"surface", top}, {"water_table", top}};
      const double expected = 1 - density / saturated_density;
      EXPECT_NEAR(share_that_rubs(offset, density, stress), expected, 0.015) << offset;
    }
  }
}

/// Laid at once, its water bears the weight, and the grains next to none.
TEST(WetSurfaces, undrained_soil_laid_at_once_hardly_rubs) {
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    EXPECT_LT(share_that_rubs(offset, water_density, Json()), 0.01) << offset;
  }
}

/// Nor does it rub where it slides down a slope and spreads: impulse along the floor by mu times
/// that across it.
TEST(WetSurfaces, undrained_slide_hardly_rubs) {
  const double mu = 0.3, slope = 20 * pi / 180;
  Json sand = saturated_sand();
  sand["friction_angle"] = 33;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {4, 1}, {40, 10}, "quad4")},
               {"basis", "gimp"},
               {"gravity", {g * std::sin(slope), -g * std::cos(slope)}},
               {"bodies", {body("soil", box({0.5, 0.15}, {2.5, 0.75}, {20, 6}, "quad4"), 4, sand)}},
               {"rigid_walls",
                {{{"name", "floor"},
                  {"surface", {{"polyline", {{50, 0.15}, {-50, 0.15}}}, {"spacing", 50}}},
                  {"friction", mu}}}}};
  json["bodies"][0]["water"] = pore_water;
  const auto solver = mpm_solver<2>(json);
  double along = 0, across = 0;
  for (int step = 1; step <= 60; ++step) {
    run_steps(*solver, 2e-3, 1, step);
    along += probe(*solver, "floor.fx");
    across += probe(*solver, "floor.fy");
  }
  EXPECT_LT(std::abs(along), 0.02 * mu * std::abs(across));
}

TEST(WetSurfaces, boundary_points_at_a_seepage_face_are_refused) {
  Json json = layer_on_floor(0, 0.3);
  json["rigid_walls"][0]["method"] = "boundary_points";
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/rigid_walls/0", "\"floor\"", "facets", "impervious"});
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  EXPECT_NO_THROW(mpm_settings<2>(json));
}

/// The scene is refused whichever of the bodies comes to the surface.
TEST(WetSurfaces, drained_surface_beside_impervious_soil_is_refused) {
  Json json = layer_on_floor(0, 0);
  json["rigid_walls"][0]["drained"] = true;
  EXPECT_NO_THROW(mpm_settings<2>(json));
  json["bodies"].push_back(json["bodies"][0]);
  json["bodies"][1]["name"] = "other";
  json["bodies"][1]["mesh"] = box({0, 1.1}, {0.2, 1.3}, {2, 2}, "quad4");
  EXPECT_NO_THROW(mpm_settings<2>(json));
  json["bodies"][1]["water"]["free_surface"] = "impervious";
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/rigid_walls/0", "drained", "\"other\"", "seepage_face"});
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
}  // namespace gabion::test::test_wet_surfaces
