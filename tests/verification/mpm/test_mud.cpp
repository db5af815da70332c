// SPDX-License-Identifier: BSD-3-Clause
// Mud that falls between two walls.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double density = 1800, g = 9.81, half = 0.05;  // [kg/m^3], [m/s^2], half of the gap [m]
constexpr double yield_stress = 200, consistency = 200;  // [Pa], [Pa s^n]

constexpr int cells = 10;  // across the gap

/// A column that falls between walls to which it sticks.
struct Column {
  std::string scheme;
  double flow_index = 1;
  double length = 1.2;  // [m]
};

/// Mean speed after 0.3 s [m/s].
double mean_speed(const Column& column) {
  const double h = 2 * half / cells;
  const auto rows = [h](double height) { return static_cast<int>(std::lround(height / h)); };
  Json mud = elastic_soil("herschel_bulkley", 3e5, 0.45, density);
  mud["yield_stress"] = yield_stress;
  mud["consistency"] = consistency;
  mud["flow_index"] = column.flow_index;
  const double above = 0.1;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {2 * half, column.length + 2 * above},
                            {cells, rows(column.length + 2 * above)}, "quad4")},
               {"walls", {wall("left", "fixed"), wall("right", "fixed")}},
               {"gravity", {0, -g}},
               {"bodies",
                {body("mud",
                      box({0, above}, {2 * half, above + column.length},
                          {cells, rows(column.length)}, "quad4"),
                      4, mud)}}};
  if (column.scheme == "explicit") json["time_integration"] = {{"scheme", "explicit"}};
  const auto solver = make_mpm(json);
  run_steps(*solver, 2e-3, 150);
  return -probe(*solver, "momentum_y") / probe(*solver, "mass");
}

/// Steady flow: the shear stress rho g z grows from the middle, z < z_p = tau_y / (rho g) is a
/// plug,
///
///     u_plug = n / (n + 1) (rho g / K)^(1/n) (H - z_p)^(1 + 1/n)
///     mean = u_plug [1 - n / (2 n + 1) (H - z_p) / H]
double steady_speed(double n) {
  const double plug = yield_stress / (density * g), sheared = half - plug;
  const double u =
      n / (n + 1) * std::pow(density * g / consistency, 1 / n) * std::pow(sheared, 1 + 1 / n);
  return u * (1 - n / (2 * n + 1) * sheared / half);
}

/// The ends of the column, which no mud holds from beyond, count as the inverse of its length.
void verify_flow(const std::string& scheme, double n) {
  const double shorter = mean_speed({scheme, n, 0.6}), longer = mean_speed({scheme, n, 1.2});
  verify({.id = "mud",
          .what =
              fmt::format("N4, column between rough walls, flow index {}, {} steps, 10 cells: mean "
                          "speed, extrapolated in the length of the column",
                          n, scheme),
          .exact = steady_speed(n),
          .computed = 2 * longer - shorter,
          .bound = 0.01,
          .unit = "m/s"});
}

TEST(MudBetweenWalls, has_its_plug_and_flow_curve) {
  verify_flow("explicit", 1);
  verify_flow("explicit", 0.5);
  verify_flow("implicit", 1);
}

}  // namespace
}  // namespace gabion::test
