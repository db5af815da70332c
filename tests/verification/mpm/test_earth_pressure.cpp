// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/support/cut_steps.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double H = 1, density = 2000, g = 10;

Json sand(double E, double friction, double dilation = 0) {
  Json soil = elastic_soil("mohr_coulomb", E, 0.3, density);
  soil["friction_angle"] = friction;
  soil["dilation_angle"] = dilation;
  return soil;
}

/// Soil of height H and width H / 2 between smooth walls, with one row of free cells above.
template <int dim>
Json soil_box(const std::string& type, int cells, int points_per_cell, const Json& material,
              int wide) {
  const double h = H / cells;
  std::vector<double> low(dim, 0.0), high(dim, wide * h), top(dim, wide * h), gravity(dim, 0.0);
  std::vector<int> count(dim, wide), grid_count(dim, wide);
  high[dim - 1] = H;
  top[dim - 1] = H + h;
  count[dim - 1] = cells;
  grid_count[dim - 1] = cells + 1;
  gravity[dim - 1] = -g;
  Json json = {{"dimension", dim},
               {"grid", box(low, top, grid_count, type)},
               {"basis", "linear"},
               {"gravity", gravity},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies", {body("soil", box(low, high, count, type), points_per_cell, material)}},
               {"newton", exact_newton}};
  if (dim == 3) {
    json["walls"].push_back(wall("front", "slip"));
    json["walls"].push_back(wall("back", "slip"));
  }
  json["bodies"][0]["initial_stress"] = {{"k0", 0.5}, {"surface", H}};
  return json;
}

double width(int dim, int cells) {
  return dim == 3 ? static_cast<double>(cells / 2) / cells * H : 1;
}

/// V12: a K0 start is in balance, stays so, and presses on the wall with K0 rho g H^2 / 2.
template <int dim>
void check_k0(const std::string& type, int points_per_cell) {
  const int cells = dim == 3 ? 4 : 8;
  Json json = soil_box<dim>(type, cells, points_per_cell, sand(1e8, 30), cells / 2);
  json["locking"] = {{"method", "none"}};  // means over patches are 1e-5 h off
  const auto solver = mpm_solver<dim>(json);
  const double h = H / cells;
  const double force = 0.5 * density * g * H * H / 2 * width(dim, cells);
  verify({.id = "V12",
          .what = "K0 box, initial displacement over h, MPM " + type,
          .exact = 0,
          .computed = static_cast<double>(solver->summary().at("initial_displacement")) / h,
          .measure = Measure::absolute_error,
          .bound = 1e-6});
  EXPECT_NEAR(probe(*solver, "wall.right.fx"), force, 0.005 * force) << type;
  run_steps(*solver, 1e-3, 20);
  double settlement = 0;
  for (const auto& u : solver->points().u) settlement = std::max(settlement, u.norm());
  verify({.id = "V12",
          .what = "K0 box, largest displacement in 20 dynamic steps over h, MPM " + type,
          .exact = 0,
          .computed = settlement / h,
          .measure = Measure::absolute_error,
          .bound = 2e-6});
  verify({.id = "V12",
          .what = "K0 box, force on the wall, MPM " + type,
          .exact = force,
          .computed = probe(*solver, "wall.right.fx"),
          .bound = 0.005,
          .unit = "N"});
}

/// The K0 box with F-bar, whose groups have one pressure each: the pressure on the wall is still
/// that of K0.
void check_k0_of_groups(const std::string& type, const std::string& basis, int points_per_cell) {
  Json json = soil_box<2>(type, 8, points_per_cell, sand(1e8, 30), 4);
  json["basis"] = basis;
  json["bodies"][0]["initial_stress"]["max_displacement"] = 1e-3;
  json["locking"] = {{"method", "fbar"}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1e-3, 20);
  verify({.id = "V12",
          .what = "K0 box, force on the wall, F-bar, MPM " + type + " " + basis,
          .exact = 0.5 * density * g * H * H / 2,
          .computed = probe(*solver, "wall.right.fx"),
          .bound = 0.005,
          .unit = "N"});
}

TEST(V12_InitialStress, k0_box_with_averaged_volumes) {
  check_k0_of_groups("quad4", "linear", 4);
  check_k0_of_groups("quad4", "gimp", 4);
  check_k0_of_groups("quad4", "bspline", 4);
  check_k0_of_groups("tri3", "linear", 3);
}

TEST(V12_InitialStress, k0_box_stays_where_it_is) {
  check_k0<2>("quad4", 4);
  check_k0<2>("tri3", 3);
  check_k0<3>("hex8", 8);
  check_k0<3>("tet4", 4);
}

/// Mass of the column is what the closed form of its density carries: the floor bears s exp(s / C).
TEST(V12_InitialStress, mass_and_volume_are_those_of_compressed_soil) {
  const Json json = soil_box<2>("quad4", 16, 4, sand(1e6, 30), 8);
  const auto solver = mpm_solver<2>(json);
  const double lambda = 1e6 * 0.3 / (1.3 * 0.4), mu = 1e6 / 2.6, k0 = 0.5;
  const double C = (3 * lambda + 2 * mu) / (1 + 2 * k0);
  const double load = density * g * H, s = C * (std::sqrt(1 + 2 * load / C) - 1);
  verify({.id = "V12",
          .what = "weight of a soft column with K0 stress, 16 cells, MPM quad4",
          .exact = s * std::exp(s / C) * H / 2,
          .computed = probe(*solver, "mass") * g,
          .bound = 1e-5,
          .unit = "N"});
  EXPECT_GT(probe(*solver, "mass"), 1.007 * density * H * H / 2);
  EXPECT_NEAR(probe(*solver, "wall.bottom.fy"), -probe(*solver, "mass") * g, 2e-4 * load);
  double volume = 0;
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    volume += points.V0[p] * points.J[p];
    EXPECT_NEAR(points.m[p], density * points.V0[p], 1e-12);
  }
  EXPECT_NEAR(volume, H * H / 2, 1e-12);
}

/// V13: smooth wall moved by 0.005 H, uniform limit state: F = K rho g H^2 / 2. The wall's
/// displacement is 0.005 of the soil's width too: cells see the volume before it, which is half of
/// the error.
void check_rankine(double phi, double direction) {
  Json json = soil_box<2>("quad4", 10, 4, sand(2e7, phi), 10);
  json["analysis"] = "quasi_static";
  json["walls"][2]["motion"] = {{"velocity", {direction * 0.005 * H, 0}}};
  json["bodies"][0]["initial_stress"]["k0"] = 0.7;
  const auto solver = mpm_solver<2>(json);
  run_with_cuts(*solver, {.end = 1, .dt = 0.05, .dt_min = 1e-3});
  const double sine = std::sin(phi * M_PI / 180);
  const double K = direction > 0 ? (1 - sine) / (1 + sine) : (1 + sine) / (1 - sine);
  const double force = K * density * g * H * H / 2;
  verify({.id = "V13",
          .what = std::string(direction > 0 ? "active" : "passive") +
                  " force on a smooth wall, phi " + std::to_string(static_cast<int>(phi)) +
                  " deg, MPM quad4",
          .exact = force,
          .computed = probe(*solver, "wall.right.fx"),
          .bound = 0.02,
          .unit = "N"});
}

TEST(V13_EarthPressure, rankine_active_and_passive) {
  for (const double phi : {19.8, 30.0}) {
    for (const double direction : {1.0, -1.0}) check_rankine(phi, direction);
  }
}

}  // namespace
}  // namespace gabion::test
