// SPDX-License-Identifier: BSD-3-Clause
// Soil above its water table, which air has entered.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/points/retention.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double H = 1, n0 = 0.4, g = 9.81, rho_w = 1000, h_c = 0.25, density = 1990;
constexpr int cells = 20;

Json column(const std::string& basis) {
  const double h = H / cells;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {h, H + 2 * h}, {1, cells + 2}, "quad4")},
               {"basis", basis},
               {"analysis", "quasi_static"},
               {"gravity", {0, -g}},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("soil", box({0, 0}, {h, H}, {1, cells}, "quad4"), 4,
                      elastic_soil("hencky_elastic", 1e9, 0.2, density))}},
               {"locking", {{"method", "fbar"}}}};
  json["bodies"][0]["water"] = {
      {"porosity", n0}, {"permeability", 1e-3}, {"suction_limit", rho_w * g * h_c}};
  json["walls"][0]["drained"] = true;
  return json;
}

/// A column full of water whose base is drained at p = 0. In the end water is at rest,
/// p = -rho_w g y, and the pores hold n0 h_c asinh(H / h_c) of it.
TEST(VW27_Suction, column_that_drains_at_its_base) {
  for (const char* basis : {"gimp", "bspline"}) {
    const auto solver = mpm_solver<2>(column(basis));
    const auto& points = solver->points();
    double m_start = 0, m_end = 0;
    for (const double m : points.m) m_start += m;
    run_steps(*solver, 100, 60);
    run_steps(*solver, 1e4, 60, 61);
    mpm::PoreWater water;
    water.porosity = n0;
    water.bulk_modulus = 2.2e9;
    water.permeability = 1e-3;
    water.cavitation = rho_w * g * h_c;
    double error = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      m_end += points.m[p];
      const double pressure = water_pressure(water, points.water[p], points.J[p]);
      error = std::max(error, std::abs(pressure / (rho_w * g * H) + points.x[p][1] / H));
    }
    const std::string what = fmt::format("column that drains at its base, {}, 20 cells: ", basis);
    verify({.id = "VW27",
            .what = what + "largest error of the pressure over that of the column",
            .exact = 0,
            .computed = error,
            .measure = Measure::absolute_error,
            .bound = 0.01});
    const double left = n0 * rho_w * (H - h_c * std::asinh(H / h_c)) * H / cells;
    verify({.id = "VW27",
            .what = what + "water that left",
            .exact = left,
            .computed = probe(*solver, "water_out"),
            .bound = 0.01,
            .unit = "kg/m"});
    verify({.id = "VW27",
            .what = what + "water that left minus loss of stored water, over water that left",
            .exact = 0,
            .computed = (m_start - m_end - probe(*solver, "water_out")) / left,
            .measure = Measure::absolute_error,
            .bound = 1e-9});
  }
}

}  // namespace
}  // namespace gabion::test
