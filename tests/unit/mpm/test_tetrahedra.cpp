// SPDX-License-Identifier: BSD-3-Clause
// Soil on boxes of tetrahedra as they are cut by default.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/cut_steps.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_tetrahedra {
namespace {

constexpr double density = 2000, g = 10;

Json sand(double E) {
  Json soil = elastic_soil("mohr_coulomb", E, 0.3, density);
  soil["friction_angle"] = 30;
  return soil;
}

/// Points of bricks would lie on the faces of six tetrahedra a brick, some of which hold none then:
/// the surface of the soil had no equilibrium.
TEST(Tetrahedra, soil_with_initial_stress_stays_before_a_rigid_wall) {
  constexpr int n = 4;
  constexpr double h = 1.0 / n;
  Json json = {
      {"dimension", 3},
      {"analysis", "quasi_static"},
      {"grid", box({0, 0, 0}, {1 + 2 * h, 2 * h, 1 + h}, {n + 2, 2, n + 1}, "tet4")},
      {"gravity", {0, 0, -g}},
      {"walls",
       {wall("bottom", "slip"), wall("left", "slip"), wall("front", "slip"), wall("back", "slip")}},
      {"bodies", {body("soil", box({0, 0, 0}, {1, 2 * h, 1}, {n, 2, n}, "hex8"), 8, sand(2e7))}},
      {"rigid_walls",
       {{{"name", "wall"},
         {"surface",
          {{"mesh", box({1, -h, -h}, {1 + h, 3 * h, 1 + 2 * h}, {1, 4, n + 3}, "hex8")},
           {"groups", {"left"}}}},
         {"friction", 0.3}}}}};
  json["bodies"][0]["initial_stress"] = {{"k0", 0.5}, {"surface", 1}, {"max_displacement", 0.3}};
  const auto solver = make_mpm(json);
  run_steps(*solver, 0.1, 2);
  const double thrust = 0.5 * density * g / 2 * 2 * h;
  EXPECT_NEAR(probe(*solver, "wall.fx"), thrust, 0.01 * thrust);
}

/// A column that spreads to both sides: six tetrahedra a brick push it to one of them.
TEST(Tetrahedra, a_column_spreads_to_both_sides_alike) {
  Json json = {{"dimension", 3},
               {"grid", box({-1.5, 0, 0}, {1.5, 0.5, 1.25}, {12, 2, 5}, "tet4")},
               {"gravity", {0, 0, -g}},
               {"walls", {wall("bottom", "fixed"), wall("front", "slip"), wall("back", "slip")}},
               {"bodies",
                {body("soil", box({-0.5, 0, 0}, {0.5, 0.5, 1}, {4, 2, 4}, "hex8"), 8, sand(1e5))}}};
  const auto solver = mpm_solver<3>(json);
  run_with_cuts(*solver, {.end = 0.2, .dt = 0.01, .dt_min = 1e-4});
  const auto& points = solver->points();
  double sum = 0, mass = 0, largest = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    sum += points.m[p] * points.u[p][0];
    mass += points.m[p];
    largest = std::max(largest, std::abs(points.u[p][0]));
  }
  EXPECT_GT(largest, 0.05);
  EXPECT_LT(std::abs(sum / mass), 1e-4 * largest);
}

}  // namespace
}  // namespace gabion::test::test_tetrahedra
