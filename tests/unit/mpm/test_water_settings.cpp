// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/settings/plausible.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_water_settings {
namespace {

TEST(WaterSettings, values_that_look_like_another_unit_are_warned_of) {
  Json json = saturated_box(2, "quad4", 2, saturated_elastic());
  const auto texts = [&] {
    const TemporaryScene folder("mpm.json", json);
    const Scene scene(folder.path(), {});
    ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
    in.integer("dimension");
    mpm::read_mpm_settings<2>(scene, in, nullptr);
    return implausible_settings(in, Described::soil);
  };
  EXPECT_TRUE(texts().empty());
  json["bodies"][0]["water"]["bulk_modulus"] = 2200;
  ASSERT_EQ(texts().size(), 1U);
  expect_parts(texts()[0],
               {"/bodies/0/water/bulk_modulus", "found 2200", "in MPa it would be 2.2e+09 Pa"});
  json["bodies"][0]["water"] = {{"porosity", 0.05}};
  json["bodies"][0]["material"]["density"] = 2560;
  ASSERT_EQ(texts().size(), 1U);
  expect_parts(texts()[0], {"/bodies/0/water/porosity", "less than most soil has"});
}

/// The settings after a change of the first body are refused with these words.
void expect_refused(const Json& change, const std::vector<std::string_view>& parts) {
  Json json = saturated_box(2, "quad4", 2, saturated_elastic());
  json["bodies"][0]["initial_stress"] = at_rest(0.8);
  json["bodies"][0].merge_patch(change);
  expect_error<ConfigError>([&] { mpm_settings<2>(json); }, parts);
}

TEST(WaterSettings, settings_that_are_refused) {
  for (const double n : {0.0, 1.0, -0.2, 40.0}) {
    expect_refused({{"water", {{"porosity", n}}}}, {"/bodies/0/water/porosity", "found"});
  }
  expect_refused({{"water", {{"porosity", 0.4}, {"bulk_modulus", -1}}}},
                 {"/bodies/0/water/bulk_modulus", "found -1"});
  expect_refused({{"water", {{"cavitation_pressure", -1}}}},
                 {"/bodies/0/water/cavitation_pressure", "found -1"});
  expect_refused({{"water", {{"grain_density", 3000}}}},
                 {"/bodies/0/water/grain_density", "found 3000", "2200", "1990"});
  expect_refused({{"material", {{"density", 900}}}},
                 {"/bodies/0/water/porosity", "grains of 833", "heavier than the water"});
  expect_refused({{"initial_stress", {{"water_table", 1.5}}}},
                 {"/bodies/0/initial_stress/water_table", "found 1.5", "at most \"surface\""});
  expect_refused({{"initial_stress", {{"water_table", nullptr}}}},
                 {"/bodies/0/initial_stress/water_table", "found none", "height"});
  expect_refused({{"initial_stress", {{"saturation_above", 1}}}},
                 {"/bodies/0/initial_stress/saturation_above", "found 1"});
  expect_refused({{"water", nullptr}},
                 {"/bodies/0/initial_stress/water_table", "without pore water"});

  Json json = saturated_box(2, "quad4", 2, saturated_elastic());
  json["locking"] = {{"method", "none"}};
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/locking/method", "found \"none\"", "allowed: fbar"});
  json.erase("locking");
  EXPECT_TRUE(mpm_settings<2>(json).locking.average_volumes);
  json["bodies"][0]["initial_stress"] = at_rest(0.8);
  json["gravity"] = {0, 0};
  expect_error<ConfigError>([&] { mpm_solver<2>(json); }, {"/bodies/0/initial_stress", "gravity"});
}

/// Water would bear a jump of the stress between layers without moving, so it is found by itself.
TEST(WaterSettings, layers_whose_stresses_differ_are_refused) {
  Json json = saturated_box(2, "quad4", 4, saturated_elastic());
  json["grid"] = box({0, 0}, {1, 1}, {4, 4}, "quad4");
  json["bodies"][0]["mesh"] = box({0, 0}, {1, 0.5}, {4, 2}, "quad4");
  json["bodies"].push_back(json["bodies"][0]);
  Json& above = json["bodies"][1];
  above["name"] = "above";
  above["mesh"] = box({0, 0.5}, {1, 1}, {4, 2}, "quad4");
  above.erase("water");
  above["material"]["density"] = 1600;
  above["initial_stress"] = {{"k0", 0.5}, {"surface", 1}};
  Json& below = json["bodies"][0]["initial_stress"];
  below = {{"k0", 0.5}, {"surface", 1.5}, {"water_table", 0.5}};
  expect_error<ConfigError>([&] { mpm_solver<2>(json); },
                            {"/bodies/0/initial_stress/k0", "vertical stress jumps", "1.003"});
  below["surface"] = 0.5 + 0.5 * 1600 / 1590;
  run_steps(*mpm_solver<2>(json), 0.01, 2);
}

}  // namespace
}  // namespace gabion::test::test_water_settings
