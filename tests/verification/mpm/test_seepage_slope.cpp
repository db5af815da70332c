// SPDX-License-Identifier: BSD-3-Clause
// Layers of sand on rough beds that are too steep for them, with seepage parallel to the bed, or
// wholly under a pool.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81, H = 1, length = 40, phi = 32;
constexpr double dry_density = saturated_density - porosity * water_density;
constexpr double ramp = 0.1;                 // of the pull along the layer [s]
constexpr double from = 0.14, until = 0.24;  // time in which the acceleration is measured [s]

/// Axes along and across the layer, whose pressures do not change along it: the pull is a force on
/// the points, gravity acts across.
struct Slope {
  double degrees;
  std::optional<double> pool = std::nullopt;  ///< its level over the bed, seen across [m]
  std::string basis = "gimp";
  double wet = 1;  ///< share of the layer below the water table; soil above it is dry
  int rows = 4;    ///< of cells

  double b() const { return degrees * std::numbers::pi / 180; }
};

mpm::MpmSettings<2> settings_of(const Slope& slope) {
  const double h = H / slope.rows, table = slope.wet * H;
  constexpr int along = 160;
  Json soil = elastic_soil("mohr_coulomb", 1e7, 0.3, saturated_density);
  soil["friction_angle"] = phi;
  const int wet_rows = static_cast<int>(std::lround(slope.wet * slope.rows));
  Json wet = body("wet", box({0, 0}, {length, table}, {along, wet_rows}, "quad4"), 4, soil);
  wet["water"] = pore_water;
  wet["water"]["permeability"] = 1e-5;
  wet["initial_stress"] = {{"k0", 1},
                           {"surface", H},
                           {"water_table", slope.pool.value_or(table)},
                           {"max_displacement", 0.01}};
  Json json = {{"dimension", 2},
               {"basis", slope.basis},
               {"grid", box({0, 0}, {length, H + h}, {along, slope.rows + 1}, "quad4")},
               {"gravity", {0, -g * std::cos(slope.b())}},
               {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
               {"locking", {{"method", "fbar"}}},
               {"bodies", {wet}}};
  if (slope.wet < 1) {
    soil["density"] = dry_density;
    Json dry =
        body("dry", box({0, table}, {length, H}, {along, slope.rows - wet_rows}, "quad4"), 4, soil);
    dry["initial_stress"] = {{"k0", 1}, {"surface", H}, {"max_displacement", 0.01}};
    json["bodies"].push_back(dry);
  }
  if (slope.pool) json["pools"] = {{{"level", *slope.pool}}};
  auto settings = mpm_settings<2>(json);
  // A level pool pulls back with the weight of the water that the layer displaces.
  const double share = slope.pool ? 1 - water_density / saturated_density : 1;
  const double pull = share * g * std::sin(slope.b());
  settings.body_acceleration = [pull](const Vector<2>&, double time) -> Vector<2> {
    return pull * std::min(1.0, time / ramp) * Vector<2>::Unit(0);
  };
  return settings;
}

/// Mean velocity along the layer, middle tenth, above the row of cells that shears.
double speed(const mpm::MaterialPoints<2>& points) {
  double momentum = 0, mass = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<2> X = points.x[p] - points.u[p];
    if (std::abs(X[0] / length - 0.5) > 0.05 || X[1] < 0.5 * H) continue;
    momentum += points.m[p] * points.v[p][0];
    mass += points.m[p];
  }
  return momentum / mass;
}

double acceleration(const Slope& slope) {
  mpm::MpmSolver<2> solver(comm(), settings_of(slope), "");
  constexpr double dt = 4e-3;
  const int first = static_cast<int>(std::lround(from / dt)),
            last = static_cast<int>(std::lround(until / dt));
  run_steps(solver, dt, first);
  const double before = speed(solver.points());
  run_steps(solver, dt, last - first, first + 1);
  return (speed(solver.points()) - before) / ((last - first) * dt);
}

/// The bed bears the share R = 1 - rho_w / rho of the normal stress, and sand of constant volume
/// shears under sin(phi) of it (Davis 1968): a = g (sin b - R sin phi cos b).
TEST(VW29_SeepageSlope, acceleration_of_a_layer_that_slides) {
  constexpr double R = 1 - water_density / saturated_density;
  for (const auto& slope :
       {Slope{.degrees = 20}, Slope{.degrees = 25}, Slope{.degrees = 25, .basis = "bspline"}}) {
    verify({.id = "VW29",
            .what = fmt::format("P10, seepage along a slope of {:g} deg, {}: acceleration",
                                slope.degrees, slope.basis),
            .exact = g * (std::sin(slope.b()) -
                          R * std::sin(phi * std::numbers::pi / 180) * std::cos(slope.b())),
            .computed = acceleration(slope),
            .bound = 0.01,
            .unit = "m/s^2"});
  }
}

/// Where the table is at half the depth, R = 1 - m rho_w / (m rho + (1 - m) rho_dry). Pressure and
/// weight of the row of cells that shears are those of its middle, an error in proportion to the
/// cell.
TEST(VW29_SeepageSlope, acceleration_of_a_layer_below_a_water_table) {
  constexpr double m = 0.5;
  constexpr double R = 1 - m * water_density / (m * saturated_density + (1 - m) * dry_density);
  const Slope coarse{.degrees = 25, .wet = m, .rows = 6}, fine{.degrees = 25, .wet = m, .rows = 12};
  verify({.id = "VW29",
          .what = "P10, seepage along a slope of 25 deg below a table at half the depth, 6 and 12 "
                  "rows of cells, extrapolated: acceleration",
          .exact = g * (std::sin(fine.b()) -
                        R * std::sin(phi * std::numbers::pi / 180) * std::cos(fine.b())),
          .computed = 2 * acceleration(fine) - acceleration(coarse),
          .bound = 0.02,
          .unit = "m/s^2"});
}

/// Under a pool the layer slides where it would dry, under its buoyant weight.
TEST(VW30_SubmergedSlope, slides_as_when_dry) {
  for (const double level : {1.0, 1.5, 10.0}) {
    const Slope slope{.degrees = 30, .pool = level};
    verify({.id = "VW30",
            .what = fmt::format(
                "P11, layer of 1 m under a pool up to {:g} m on 30 deg: acceleration", level),
            .exact = (1 - water_density / saturated_density) * g *
                     (std::sin(slope.b()) -
                      std::sin(phi * std::numbers::pi / 180) * std::cos(slope.b())),
            .computed = acceleration(slope),
            .bound = 0.01,
            .unit = "m/s^2"});
  }
  const Slope flat{.degrees = 25, .pool = 1.5};
  verify({.id = "VW30",
          .what = "P11, the same on 25 deg, where it stays: acceleration over the pull",
          .exact = 0,
          .computed = acceleration(flat) / (g * std::sin(flat.b())),
          .measure = Measure::absolute_error,
          .bound = 0.01});
}

}  // namespace
}  // namespace gabion::test
