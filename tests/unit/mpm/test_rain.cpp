// SPDX-License-Identifier: BSD-3-Clause
// How much rain falls on soil, and what is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_rain {
namespace {

constexpr double rate = 1e-7, pi = 3.14159265358979324;

/// A square of 1 m in a corner of walls, its top and its right side in air.
/// @param cells  of the body along x and y
Json square(const std::string& basis, const std::vector<int>& cells, double slope = 0) {
  Json json = {
      {"dimension", 2},
      {"grid", box({0, 0}, {1.5, 1.5}, {6, 6}, "quad4")},
      {"basis", basis},
      {"analysis", "quasi_static"},
      {"gravity", {-9.81 * std::sin(slope), -9.81 * std::cos(slope)}},
      {"walls", {wall("bottom", "fixed"), wall("left", "slip")}},
      {"bodies", {body("soil", box({0, 0}, {1, 1}, cells, "quad4"), 4, saturated_elastic())}},
      {"locking", {{"method", "fbar"}}},
      {"rain", {{"rate", rate}}}};
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = 1e-6;
  return json;
}

/// Mass of the rain by what falls on a metre in the step.
double fallen(const Json& json, double dt) {
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, dt, 1);
  return (probe(*solver, "rain_in") + probe(*solver, "rain_run_off")) / (rate * dt * water_density);
}

/// Normals of the points beside an edge are tilted: those of the 8 points along a side see a
/// percent more or less of it.
TEST(Rain, falls_on_what_is_seen_along_gravity) {
  for (const char* basis : {"gimp", "bspline"}) {
    SCOPED_TRACE(basis);
    for (const double degrees : {0.0, 20.0, 45.0, 70.0}) {
      SCOPED_TRACE(degrees);
      const double slope = degrees * pi / 180;
      EXPECT_NEAR(fallen(square(basis, {4, 4}, slope), 10), std::cos(slope) + std::sin(slope),
                  0.015);
    }
  }
  // Cells that are not square.
  EXPECT_NEAR(fallen(square("gimp", {4, 8}), 10), 1, 0.025);
  EXPECT_NEAR(fallen(square("gimp", {8, 4}), 10), 1, 0.025);
}

TEST(Rain, stops_and_begins) {
  Json json = square("gimp", {4, 4});
  json["rain"] = {{"table", {{10, 0}, {20, rate}, {30, 0}}}};
  const auto solver = mpm_solver<2>(json);
  const auto all = [&] { return probe(*solver, "rain_in") + probe(*solver, "rain_run_off"); };
  run_steps(*solver, 10, 1);
  EXPECT_EQ(all(), 0);
  run_steps(*solver, 10, 1, 2);
  EXPECT_NEAR(all(), rate * 10 * water_density, 0.02 * rate * 10 * water_density);
  const double until_then = all();
  run_steps(*solver, 10, 1, 3);
  EXPECT_EQ(all(), until_then);
}

void refuse(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { mpm_settings<2>(json); }, parts);
}

TEST(Rain, is_refused_where_no_soil_takes_it) {
  Json json = square("gimp", {4, 4});
  json["bodies"][0]["water"].erase("permeability");
  refuse(json, {"/rain", "without soil that takes it in", "\"permeability\""});
  json["bodies"][0].erase("water");
  refuse(json, {"/rain", "without soil that takes it in"});
  json = square("gimp", {4, 4});
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  refuse(json, {"/rain", "\"seepage_face\""});
  json = square("gimp", {4, 4});
  json["gravity"] = {0, 0};
  refuse(json, {"/rain", "gravity"});
}

TEST(Rain, has_one_rate_that_is_possible) {
  Json json = square("gimp", {4, 4});
  for (const auto& [rain, part] : std::vector<std::pair<Json, const char*>>{
           {{{"rate", -1e-9}}, "/rain/rate"},
           {{{"rate", 20}}, "/rain/rate"},
           {{{"table", {{0, 0}, {10, 20}}}}, "/rain/table/1"},
           {{{"table", {{0, 0}, {10, -1e-9}}}}, "/rain/table/1"},
           {{{"table", {{10, 0}, {10, 1e-9}}}}, "/rain/table/1"},
           {{{"rate", rate}, {"table", {{0, 0}}}}, "exactly one"},
           {Json::object(), "exactly one"}}) {
    json["rain"] = rain;
    refuse(json, {part});
  }
}

}  // namespace
}  // namespace gabion::test::test_rain
