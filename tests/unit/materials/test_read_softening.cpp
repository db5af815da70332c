// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/support/expect_error.hpp"
#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_read_softening {
namespace {

Json sand(const Json& softening) {
  return {{"law", "mohr_coulomb"}, {"density", 1800},       {"young_modulus", 1e7},
          {"poisson_ratio", 0.3},  {"friction_angle", 38},  {"dilation_angle", 8},
          {"cohesion", 1000},      {"softening", softening}};
}

Json clay(const Json& softening) {
  return {{"law", "tresca"},       {"density", 1700}, {"young_modulus", 1e7},
          {"poisson_ratio", 0.45}, {"cohesion", 4e4}, {"softening", softening}};
}

SofteningSoil<2> read(const Json& material) {
  return std::get<SofteningSoil<2>>(
      read_material<2>(ConfigReader(material, "mpm.json", material_keys(material_laws))).law);
}

void expect_refused(const Json& material, const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>([&] { read(material); }, parts);
}

TEST(ReadSoftening, of_sand) {
  const auto soil = read(sand({{"slip", 0.02}, {"residual_friction_angle", 32}}));
  EXPECT_TRUE(soil.parameters().by_slip);
  EXPECT_TRUE(soil.parameters().frictional);
  const StrengthCurve& curve = soil.parameters().curve;
  EXPECT_NEAR(curve.at(0).value.sin_dilation, std::sin(8 * degree), 1e-15);
  EXPECT_NEAR(curve.at(1).value.sin_friction, std::sin(32 * degree), 1e-15);
  EXPECT_EQ(curve.at(1).value.cohesion, 1000);
  EXPECT_NEAR(
      curve.at(0.02).value.sin_friction,
      std::sin(32 * degree) + (std::sin(38 * degree) - std::sin(32 * degree)) * std::exp(-1.0),
      1e-15);
  const auto by_strain = read(sand({{"strain", 0.02}, {"residual_cohesion", 0}}));
  EXPECT_FALSE(by_strain.parameters().by_slip);
}

TEST(ReadSoftening, of_clay_that_is_remoulded) {
  const auto soil = read(clay({{"slip", 0.01},
                               {"residual_cohesion", 2e4},
                               {"remoulded_cohesion", 500},
                               {"remoulding_slip", 1},
                               {"relaxation_time", 2}}));
  EXPECT_FALSE(soil.parameters().frictional);
  EXPECT_EQ(soil.parameters().relaxation_time, 2);
  EXPECT_NEAR(soil.parameters().curve.at(50).value.cohesion, 500, 1e-9);
}

TEST(ReadSoftening, of_tables) {
  const auto soil = read(sand({{"table", {{0.005, 1000, 42, 12}, {0.05, 0, 33, 0}}}}));
  EXPECT_TRUE(soil.parameters().by_slip);
  EXPECT_NEAR(soil.parameters().curve.at(0.005).value.sin_friction, std::sin(42 * degree), 1e-15);
  const auto by_strain = read(clay({{"strain", 0.02}, {"residual_cohesion", 1e4}}));
  EXPECT_FALSE(by_strain.parameters().by_slip);
  const auto strain = read(clay({{"strain_table", {{0.1, 1e4}}}}));
  EXPECT_FALSE(strain.parameters().by_slip);
}

TEST(ReadSoftening, of_clay_whose_strength_grows_with_the_rate) {
  const auto soil = read(clay({{"slip", 0.01}, {"rate_gain", 0.1}, {"reference_rate", 1e-5}}));
  EXPECT_EQ(soil.parameters().rate_gain.gain, 0.1);
  EXPECT_EQ(soil.parameters().rate_gain.reference, 1e-5);
  expect_refused(clay({{"slip", 0.01}, {"rate_gain", 0.1}}), {"/softening/reference_rate"});
  expect_refused(clay({{"slip", 0.01}, {"reference_rate", 1e-5}}), {"/softening/reference_rate"});
  expect_refused(clay({{"slip", 0.01}, {"rate_gain", -0.1}, {"reference_rate", 1e-5}}),
                 {"/softening/rate_gain", "found -0.1"});
  expect_refused(
      clay({{"slip", 0.01}, {"rate_gain", 0.1}, {"reference_rate", 1e-5}, {"relaxation_time", 1}}),
      {"/softening/rate_gain", "relaxation_time"});
  expect_refused(sand({{"slip", 0.01}, {"rate_gain", 0.1}, {"reference_rate", 1e-5}}),
                 {"/softening/rate_gain"});
}

TEST(ReadSoftening, refuses_what_has_no_meaning) {
  expect_refused(sand(Json::object()), {"/softening", "slip"});
  expect_refused(sand({{"slip", 0.1}, {"strain", 0.1}}), {"/softening"});
  expect_refused(sand({{"slip", 0}}), {"/softening/slip", "found 0"});
  expect_refused(sand({{"slip", 0.1}, {"residual_friction_angle", 95}}),
                 {"/softening/residual_friction_angle", "95"});
  expect_refused(sand({{"slip", 0.1}, {"residual_friction_angle", 40}, {"dilation", "rowe"}}),
                 {"/softening/residual_friction_angle", "rowe", "38"});
  expect_refused(sand({{"table", {{0.05, 0, 33, 0}, {0.04, 0, 33, 0}}}}),
                 {"/softening/table/1", "found 0.04", "ascend"});
  expect_refused(sand({{"table", Json::array()}}), {"/softening/table", "at least one row"});
  expect_refused(clay({{"strain_table", Json::array()}}),
                 {"/softening/strain_table", "at least one row"});
  expect_refused(sand({{"table", {{0.05, -1, 33, 0}}}}), {"/softening/table/0", "-1"});
  expect_refused(sand({{"table", {{0.05, 0, 33, 34}}}}), {"/softening/table/0", "34", "33"});
  expect_refused(sand({{"slip", 0.1}, {"relaxation_time", 1}}),
                 {"/softening/relaxation_time", "apex_volume"});
  expect_refused(clay({{"slip", 0.1}, {"residual_cohesion", 0}}),
                 {"/softening/residual_cohesion", "found 0"});
  expect_refused(clay({{"slip", 0.1}, {"remoulded_cohesion", 500}}),
                 {"/softening/remoulding_slip"});
  expect_refused(clay({{"slip", 0.1},
                       {"residual_cohesion", 1e3},
                       {"remoulded_cohesion", 2e3},
                       {"remoulding_slip", 1}}),
                 {"/softening/remoulded_cohesion", "2000", "1000"});
  Json cut = sand({{"table", {{0.005, 1000, 60, 0}}}});
  cut["tension_cutoff"] = 900;
  expect_refused(cut, {"tension_cutoff", "900", "577"});
  Json elastic = clay({{"slip", 0.1}});
  elastic["law"] = "hencky_elastic";
  elastic.erase("cohesion");
  expect_refused(elastic, {"softening"});
}

}  // namespace
}  // namespace gabion::testing::test_read_softening
