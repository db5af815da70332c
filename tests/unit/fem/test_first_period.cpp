// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_solver/step/first_period.hpp"
#include "tests/unit/fem/beam_scene.hpp"

namespace gabion::test::test_first_period {
namespace {

/// Ten trusses of the string of test_line_cells.cpp, 7.1002 Hz.
Json string_scene(const std::string& file) {
  Json material = line_material("truss", 1e9, 1e-3, 500);
  material["pretension"] = 1e4;
  Json json = line_scene(2, file, material);
  json["supports"] = {{{"group", "low"}}, {{"group", "high"}}};
  return json;
}

double period_of(const Json& json, double dt) {
  const auto settings = fem_settings<2>(json);
  fem::StructureStep<2> step(settings, comm());
  return fem::first_period(step, step.initial_state(), dt);
}

TEST(FirstPeriod, of_a_string) {
  const TemporaryMesh mesh(chain(10, 10).file());
  const double T = 1 / 7.1002, ratio = 1 / (1 + 1e4 / 1e6);  // less mass, see length_ratio
  for (const double share : {1.0, 0.3, 0.1, 0.05}) {
    EXPECT_NEAR(period_of(string_scene(mesh.path()), share * T), T * std::sqrt(ratio), 1e-4 * T)
        << share;
  }
  for (const double share : {0.01, 0.001}) {
    const double found = period_of(string_scene(mesh.path()), share * T);
    EXPECT_LT(found, T);
    EXPECT_GT(found, 20 * share * T) << "no false alarm";
  }
}

TEST(FirstPeriod, of_a_cantilever_of_beams) {
  const TemporaryMesh mesh(chain(2, 16).file());
  const Json material = beam_material(2e8, 0.25, rectangle(0.1, 0.05), 1000);
  const Json json = cantilever_of_beams(2, mesh.path(), material, 2, "dynamic");
  const double frequency =
      std::pow(1.8751041 / 2, 2) / (2 * std::numbers::pi) * std::sqrt(2e8 * 0.1 * 0.1 / 12 / 1000);
  EXPECT_NEAR(period_of(json, 0.1 / frequency), 1 / frequency, 5e-3 / frequency);
}

std::string warnings_of(const Json& json, double dt) {
  testing::internal::CaptureStderr();
  const auto solver = fem_solver<2>(json);
  for (int n = 1; n <= 2; ++n) advance(*solver, n, dt);
  return testing::internal::GetCapturedStderr();
}

TEST(FirstPeriod, warns_once_of_long_steps_that_nothing_damps) {
  const TemporaryMesh mesh(chain(10, 10).file());
  Json json = string_scene(mesh.path());
  const std::string text = warnings_of(json, 0.02), words = "7 a period of the first vibration";
  EXPECT_NE(text.find(words), std::string::npos) << text;
  EXPECT_EQ(text.find(words), text.rfind(words));
  EXPECT_EQ(warnings_of(json, 0.01).find("a period"), std::string::npos);
  json["time_integration"] = {{"scheme", "bossak"}, {"alpha", -0.1}};
  EXPECT_EQ(warnings_of(json, 0.02).find("a period"), std::string::npos);
  Json free = {{"dimension", 2},
               {"mesh", box_2d({1, 1}, {2, 2})},
               {"material", elastic("neo_hookean", 1e6, 0.3, 1000)}};
  EXPECT_EQ(warnings_of(free, 1).find("a period"), std::string::npos) << "moves freely";
}

}  // namespace
}  // namespace gabion::test::test_first_period
