// SPDX-License-Identifier: BSD-3-Clause
// Modified Cam-Clay in whole scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_clay_soil {
namespace {

constexpr double density = 1800, g = 10, height = 4, attraction = 2e3, k0 = 0.55, ocr = 2;
constexpr double compression = 0.09, swelling = 0.012, poisson_ratio = 0.3;

/// Level ground between smooth walls.
Json level_ground(const std::string& scheme) {
  const Json clay = {{"law", "cam_clay"},
                     {"density", density},
                     {"poisson_ratio", poisson_ratio},
                     {"compression_index", compression},
                     {"swelling_index", swelling},
                     {"critical_state_ratio", 1.1},
                     {"reference_pressure", 5e4},
                     {"attraction", attraction}};
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {2, 5}, {4, 10}, "quad4")},
               {"gravity", {0, -g}},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies", {body("soil", box({0, 0}, {2, height}, {4, 8}, "quad4"), 4, clay)}}};
  json["bodies"][0]["initial_stress"] = {{"k0", k0}, {"ocr", ocr}, {"surface", height}};
  if (scheme == "explicit") json["time_integration"] = {{"scheme", "explicit"}};
  return json;
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

/// Largest displacement of a point [m].
double most_moved(const mpm::MpmSolver<2>& solver) {
  double most = 0;
  for (const auto& u : solver.points().u) most = std::max(most, u.norm());
  return most;
}

/// Cauchy stress of the weight above, K0 after unloading, and an ellipse through the stress before.
TEST(ClaySoil, begins_with_its_weight_and_its_preconsolidation) {
  const auto solver = mpm_solver<2>(level_ground("implicit"));
  const auto& points = solver->points();
  const double k = swelling / (1 - swelling);  // by Kirchhoff stress
  const double now = ocr * k0 - (ocr - 1) * poisson_ratio / (1 - poisson_ratio);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double s = -points.tau[p][1], depth = height - points.x[p][1];
    const double P = attraction + s * (1 + 2 * now) / 3;
    EXPECT_NEAR(points.tau[p][0], -now * s, 1e-9 * s);
    EXPECT_NEAR(points.J[p], std::pow(P / 5e4, -k), 1e-12);
    const double b = (1 + 2 * now) / 3;
    EXPECT_NEAR(s * (1 + k) - k * attraction / b * std::log1p(b * s / attraction),
                density * g * depth, 1e-9 * s);
    const double P_nc = attraction + ocr * s * (1 + 2 * k0) / 3, q = ocr * s * (1 - k0) / 1.1;
    EXPECT_NEAR(points.internal[p][0], P_nc + q * q / P_nc, 1e-9 * P_nc);
    EXPECT_NEAR(points.internal[p][1], 1.5 * 0.4 / 1.3 * P / k, 1e-9 * P / k);
  }
}

TEST(ClaySoil, level_ground_stays_at_rest) {
  for (const std::string scheme : {"implicit", "explicit"}) {
    const auto solver = mpm_solver<2>(level_ground(scheme));
    run_steps(*solver, 0.01, 20);
    EXPECT_LT(most_moved(*solver), 1e-3) << scheme;
  }
}

/// The longest explicit step is that of the pressure, which is far above the reference pressure.
TEST(ClaySoil, explicit_steps_follow_the_stiffness) {
  Json json = level_ground("explicit");
  json["bodies"][0]["material"]["reference_pressure"] = 3e3;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.05, 20);
  EXPECT_LT(most_moved(*solver), 1e-3);
}

TEST(ClaySoil, a_side_that_is_taken_away_yields_and_restarts) {
  Json json = level_ground("implicit");
  json["walls"].erase(2);
  json["bodies"][0]["mesh"] = box({0, 0}, {1, height}, {2, 8}, "quad4");
  json["bodies"][0]["initial_stress"]["max_displacement"] = 10;
  const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
             second = mpm_solver<2>(json);
  run_steps(*straight, 0.01, 20);
  run_steps(*first, 0.01, 12);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, 0.01, 8, 13);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  const auto& history = straight->points().history;
  EXPECT_TRUE(std::ranges::any_of(history, [](const auto& h) { return h.plastic_strain > 1e-3; }));
}

TEST(ClaySoil, saturated_ground_stays_at_rest) {
  Json json = level_ground("implicit");
  json["bodies"][0]["water"] = {{"porosity", 0.5}};
  json["bodies"][0]["initial_stress"]["water_table"] = height;
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.01, 10);
  EXPECT_LT(most_moved(*solver), 1e-3);
}

TEST(ClaySoil, refusals) {
  Json json = level_ground("implicit");
  json["bodies"][0].erase("initial_stress");
  expect_refused(json, {"/bodies/0/initial_stress", "found none", "cam_clay", "pressure"});
  for (const auto& [key, bad] : {std::pair{"swelling_index", 0.09},
                                 {"swelling_index", 0.0},
                                 {"compression_index", 1.0},
                                 {"critical_state_ratio", 3.0},
                                 {"critical_state_ratio", 0.0},
                                 {"reference_pressure", 0.0},
                                 {"attraction", 0.0}}) {
    json = level_ground("implicit");
    json["bodies"][0]["material"][key] = bad;
    expect_refused(json, {std::string("/bodies/0/material/") + key});
  }
  json = level_ground("implicit");
  json["bodies"][0]["material"]["young_modulus"] = 1e6;
  expect_refused(json, {"/bodies/0/material/young_modulus"});
  json = level_ground("implicit");
  json["bodies"][0]["initial_stress"]["k0"] = "jaky";
  EXPECT_NO_THROW(make_mpm(json));
}

}  // namespace
}  // namespace gabion::test::test_clay_soil
