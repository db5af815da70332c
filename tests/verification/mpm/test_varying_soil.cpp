// SPDX-License-Identifier: BSD-3-Clause
// VA20: soil whose constants vary in space.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mpm_solver/parameters/random_field.hpp"
#include "tests/support/cut_steps.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double H = 1, density = 2000, g = 10;

Json by_depth(double at_top, double at_bottom) {
  return {{"by_depth", {{0, at_top}, {H, at_bottom}}}, {"below", H}};
}

/// Soil of height and width H between smooth walls of the grid, with one row of free cells above.
Json soil_box(int cells, const Json& material) {
  const double h = H / cells;
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"grid", box({0, 0}, {H, H + h}, {cells, cells + 1}, "quad4")},
          {"basis", "linear"},
          {"gravity", {0, -g}},
          {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
          {"bodies", {body("soil", box({0, 0}, {H, H}, {cells, cells}, "quad4"), 4, material)}},
          {"newton", exact_newton}};
}

/// A smooth wall moved by 0.005 H: each depth has Rankine's stress with the cohesion c_0 + k d that
/// it has there, K rho g d -+ 2 c sqrt(K).
void check_rankine(const std::string& law, double phi, double c_0, double k, double direction) {
  Json material = elastic_soil(law, 2e7, 0.3, density);
  if (law == "mohr_coulomb") material["friction_angle"] = phi;
  material["cohesion"] = by_depth(c_0, c_0 + k * H);
  Json json = soil_box(10, material);
  json["walls"][2]["motion"] = {{"velocity", {direction * 0.005 * H, 0}}};
  json["bodies"][0]["initial_stress"] = {{"k0", 0.7}, {"surface", H}};
  const auto solver = mpm_solver<2>(json);
  run_with_cuts(*solver, {.end = 1, .dt = 0.05, .dt_min = 1e-3});
  const double sine = std::sin(phi * M_PI / 180);
  const double K = direction > 0 ? (1 - sine) / (1 + sine) : (1 + sine) / (1 - sine);
  const double of_cohesion = (2 * c_0 * H + k * H * H) * std::sqrt(K);
  verify({.id = "VA20",
          .what = std::string(direction > 0 ? "active" : "passive") + " force of " + law +
                  " whose cohesion grows with depth on a smooth wall, MPM quad4",
          .exact = K * density * g * H * H / 2 - direction * of_cohesion,
          .computed = probe(*solver, "wall.right.fx"),
          .bound = 0.02,
          .unit = "N"});
}

TEST(VA20_VaryingSoil, rankine_with_cohesion_by_depth) {
  check_rankine("mohr_coulomb", 19.8, 1e3, 9e3, -1);
  check_rankine("mohr_coulomb", 19.8, 0, 3e3, 1);
  check_rankine("tresca", 0, 5e3, 5e3, -1);
}

/// Settlement of the surface of a column whose modulus grows with depth, E = E_0 + k d: the
/// integral rho g / k [H - E_0 / k ln(1 + k H / E_0)], with second order in the size of the cells.
TEST(VA20_VaryingSoil, settlement_with_modulus_by_depth) {
  constexpr double E_0 = 1e9, k = 9e9;
  const double exact = density * g / k * (H - E_0 / k * std::log(1 + k * H / E_0));
  std::vector<double> errors;
  for (const int cells : {8, 16, 32}) {
    Json material = elastic_soil("linear_elastic", 1, 0, density);
    material["young_modulus"] = by_depth(E_0, E_0 + k * H);
    Json json = soil_box(cells, material);
    json["small_cuts"] = {{"method", "none"}};
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 1, 1);
    const auto& points = solver->points();
    double top = 0, below = 0;  // of the two highest rows of points, extended to the surface
    double y_top = 0, y_below = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const double y = points.x[p][1] - points.u[p][1];
      if (y > y_top + 1e-6) {
        y_below = y_top;
        below = top;
        y_top = y;
        top = points.u[p][1];
      }
    }
    const double surface = top + (top - below) * (H - y_top) / (y_top - y_below);
    errors.push_back(std::abs(-surface / exact - 1));
    if (cells < 32) continue;
    verify({.id = "VA20",
            .what = "settlement of a column whose modulus grows tenfold with depth, 32 cells",
            .exact = exact,
            .computed = -surface,
            .bound = 2e-3,
            .unit = "m"});
  }
  verify({.id = "VA20",
          .what = "the same, order in the size of the cells",
          .exact = 2,
          .computed = std::log2(errors[1] / errors[2]),
          .measure = Measure::order,
          .bound = 1.8});
}

/// Statistics of a random field over many scales of fluctuation.
TEST(VA20_VaryingSoil, random_field) {
  const Vector<2> theta(10, 1);
  const mpm::RandomLattice<2> lattice({Vector<2>(0, 0), Vector<2>(4000, 400)}, theta / 4);
  const auto z = mpm::normal_field<2>(lattice, theta, mpm::CountedRandom(1, "soil/cohesion"));
  const mpm::Lognormal law = mpm::Lognormal::of(1e4, 0.3);
  const auto [nx, ny] = lattice.count;
  const auto n = static_cast<double>(z.size());
  double sum = 0, squares = 0, along = 0, across = 0;
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      const double x = law.at(z[i * ny + j]) / 1e4;
      sum += x / n;
      squares += x * x / n;
      if (i + 4 < nx) along += z[i * ny + j] * z[(i + 4) * ny + j] / ((nx - 4.0) * ny);
      if (j + 4 < ny) across += z[i * ny + j] * z[i * ny + j + 4] / (nx * (ny - 4.0));
    }
  }
  const auto row = [](const std::string& what, double exact, double computed, double bound) {
    verify({.id = "VA20",
            .what = what,
            .exact = exact,
            .computed = computed,
            .measure = Measure::absolute_error,
            .bound = bound});
  };
  row("random field, lognormal: mean over that wanted", 1, sum, 0.005);
  row("random field, lognormal: coefficient of variation", 0.3,
      std::sqrt(squares - sum * sum) / sum, 0.005);
  row("random field: correlation over the horizontal scale of fluctuation", std::exp(-2), along,
      0.02);
  row("random field: correlation over the vertical scale of fluctuation", std::exp(-2), across,
      0.02);
}

}  // namespace
}  // namespace gabion::test
