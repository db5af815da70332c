// SPDX-License-Identifier: BSD-3-Clause
// Pore water that a given flux brings through walls of the grid.
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/points/retention.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_inflow {
namespace {

constexpr double pi = 3.14159265358979324;
constexpr double E = 10e6, nu = 0.2, k = 9.81e-7;
constexpr double M = 11.1111111e6, kappa = 1e-10, c_v = M * kappa;
constexpr double q = 1e-7;  // [m/s]

/// A column of 10 cells, free on top, into whose base water flows.
Json column_scene(int dim = 2) {
  const int cells = 10;
  const double h = 1.0 / cells;
  std::vector<double> low(dim, 0.0), high(dim, h), top(dim, h), gravity(dim, 0.0);
  std::vector<int> count(dim, 1), grid_count(dim, 1);
  high[dim - 1] = 1;
  top[dim - 1] = 1 + 2 * h;
  count[dim - 1] = cells;
  grid_count[dim - 1] = cells + 2;
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json json = {{"dimension", dim},
               {"grid", box(low, top, grid_count, type)},
               {"basis", "gimp"},
               {"analysis", "quasi_static"},
               {"gravity", gravity},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("soil", box(low, high, count, type), 1 << dim,
                      elastic_soil("hencky_elastic", E, nu, saturated_density))}}};
  if (dim == 3) {
    json["walls"].push_back(wall("front", "slip"));
    json["walls"].push_back(wall("back", "slip"));
  }
  json["walls"][0]["inflow"] = q;
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = k;
  json["bodies"][0]["water"]["bulk_modulus"] = 2.2e11;
  return json;
}

template <int dim>
double content(const mpm::MpmSolver<dim>& solver) {
  const auto& points = solver.points();
  double sum = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) sum += points.V0[p] * points.water[p];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm());
  return sum;
}

/// Pressure by q H / kappa at the distance z from the base, by the height H: that of a bar whose
/// end is heated (Carslaw, Jaeger 1959, section 3.8).
double exact(double z, double T) {
  double sum = 1 - z;
  for (int i = 0; i < 200; ++i) {
    const double l = (2 * i + 1) * pi / 2;
    sum -= 2 / (l * l) * std::cos(l * z) * std::exp(-l * l * T);
  }
  return sum;
}

/// Largest difference of the pressure from the exact one, by q H / kappa.
template <int dim>
double error(const mpm::MpmSolver<dim>& solver, double T) {
  const auto& points = solver.points();
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = 2.2e11;
  water.cavitation = 1e12;
  double largest = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double found = mpm::water_pressure(water, points.water[p], points.J[p]) * kappa / q;
    largest = std::max(largest, std::abs(found - exact(points.x[p][dim - 1], T)));
  }
  return largest;
}

template <int dim>
void expect_column_fills() {
  const auto solver = mpm_solver<dim>(column_scene(dim));
  const double before = content(*solver), area = dim == 2 ? 0.1 : 0.01;
  const double T = 0.2;
  const int steps = 40;
  const double dt = T / c_v / steps;
  run_steps(*solver, dt, steps);
  EXPECT_LT(error(*solver, T), 0.01);
  // What came in is stored or gone; the sum of what came in is water_out without what left.
  const double stored = content(*solver) - before;
  EXPECT_NEAR(probe(*solver, "water_out") / water_density, -stored, 1e-7 * stored);
  EXPECT_LT(stored, q * area * T / c_v);
  run_steps(*solver, 1e3 / c_v, 1, steps + 1);
  EXPECT_LT(error(*solver, 1e3), 0.003);  // the surface lies a fiftieth of a cell farther
  // In steady flow the work on the water that comes in is what seepage takes.
  const double taken = probe(*solver, "plastic_dissipation"),
               supplied = probe(*solver, "boundary_work"), at = 1e3 / c_v;
  run_steps(*solver, at, 1, steps + 2);
  const double power = q * q / kappa * area;
  EXPECT_NEAR(probe(*solver, "plastic_dissipation") - taken, power * at, 0.005 * power * at);
  EXPECT_NEAR(probe(*solver, "boundary_work") - supplied, power * at, 0.005 * power * at);
}

TEST(Inflow, column_fills_as_a_heated_bar_warms_in_the_plane) {
  expect_column_fills<2>();
}
TEST(Inflow, column_fills_as_a_heated_bar_warms_in_space) {
  expect_column_fills<3>();
}

/// Only the part of a wall that soil touches lets water in; all of it stays where nothing drains.
TEST(Inflow, volume_is_that_of_the_area_that_soil_touches) {
  for (const double rate : {1e-5, -1e-5}) {
    for (const char* locking : {"fbar", "none"}) {
      Json json = column_scene();
      json["grid"] = box({0, 0}, {1, 1}, {4, 4}, "quad4");
      json["bodies"][0]["mesh"] = box({0, 0}, {0.85, 0.6}, {4, 3}, "quad4");
      json["bodies"][0]["water"]["free_surface"] = "impervious";
      json["walls"] = {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")};
      json["walls"][1]["inflow"] = rate;
      json["walls"][2]["inflow"] = 1e-3;  // no soil there
      json["locking"] = {{"method", locking}};
      const auto solver = mpm_solver<2>(json);
      const double before = content(*solver);
      run_steps(*solver, 10, 1);
      const double in = rate * 0.6 * 10;
      EXPECT_NEAR(content(*solver) - before, in, 1e-7 * std::abs(in));
      EXPECT_NEAR(probe(*solver, "water_out"), -in * water_density, 1e-12 * std::abs(in * 1e3));
    }
  }
}

TEST(Inflow, settings_that_are_refused) {
  const auto refused = [](const Json& json, const std::vector<std::string_view>& parts) {
    expect_error<ConfigError>([&] { mpm_settings<2>(json); }, parts);
  };
  Json json = column_scene();
  json["walls"][0]["drained"] = true;
  refused(json, {"/walls/0/inflow", "drained"});
  json = column_scene();
  json["basis"] = "bspline";
  refused(json, {"/walls/0/inflow", "bspline", "gimp"});
  json = column_scene();
  json["bodies"][0].erase("water");
  refused(json, {"/walls/0/inflow", "permeability"});
  json = column_scene();
  json["analysis"] = "dynamic";
  json["time_integration"] = {{"scheme", "explicit"}};
  refused(json, {"/walls/0/inflow", "explicit"});
  json = column_scene();
  json["walls"][0] = {{"group", "bottom"}, {"condition", "outflow"}, {"inflow", q}};
  refused(json, {"/walls/0/inflow"});
  json = column_scene();
  json["walls"][0]["inflow"] = 2;
  refused(json, {"/walls/0/inflow", "found 2"});
}

}  // namespace
}  // namespace gabion::test::test_inflow
