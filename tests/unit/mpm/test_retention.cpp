// SPDX-License-Identifier: BSD-3-Clause
// Water that gives way under suction.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mpm_solver/points/retention.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_retention {
namespace {

mpm::PoreWater water_that_gives_way(double limit) {
  mpm::PoreWater water;
  water.porosity = 0.4;
  water.bulk_modulus = 2.2e9;
  water.density = 1000;
  water.permeability = 1e-4;
  water.cavitation = limit;
  return water;
}

TEST(Retention, slopes_agree_with_differences) {
  const mpm::PoreWater water = water_that_gives_way(2e3);
  for (const double p : {3e3, -10.0, -1e3, -5e3, -2e4}) {
    const double step = 1e-4 * std::abs(p);
    const auto low = retention_at(water, p - step), high = retention_at(water, p + step);
    const auto at = retention_at(water, p);
    const auto same = [&](double slope, double before, double after) {
      EXPECT_NEAR(slope, (after - before) / (2 * step), 1e-6 * std::abs(slope) + 1e-13) << p;
    };
    same(at.saturation_slope, low.saturation, high.saturation);
    same(at.filled_slope, low.filled, high.filled);
    same(at.borne_slope, low.borne, high.borne);
    same(at.mobility_slope, low.mobility, high.mobility);
  }
}

/// At the suction p_cav 1 / sqrt(2) of the pores is full; grains never feel more than p_cav.
TEST(Retention, suction_that_the_grains_feel_is_limited) {
  const mpm::PoreWater water = water_that_gives_way(2e3);
  EXPECT_NEAR(retention_at(water, -2e3).saturation, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(retention_at(water, -2e3).borne, -2e3 * std::sqrt(0.5), 1e-12);
  for (const double p : {-1e3, -1e4, -1e6, -1e9}) {
    EXPECT_GE(retention_at(water, p).borne, -2e3) << p;
    EXPECT_LT(retention_at(water, p).borne, 0) << p;
  }
  EXPECT_EQ(retention_at(water, 5e3).borne, 5e3);
  EXPECT_EQ(retention_at(water_that_gives_way(std::numeric_limits<double>::infinity()), -5e3).borne,
            -5e3);
}

/// Content and pressure are inverse to each other, from 1e-6 to 1e5 times the limit, and where all
/// of it is lost soil that opens finds a pressure too.
TEST(Retention, content_gives_the_pressure_back) {
  for (const double limit : {10.0, 2e3, 1e6}) {
    const mpm::PoreWater water = water_that_gives_way(limit);
    for (const double J : {0.95, 1.0, 1.2}) {
      for (double x = 1e-3; x < 1e5; x *= 7) {
        const double content = water.content_at(-x * limit, J);
        // Content has round-off: what it says of the pressure is that by its slope.
        const double slope =
            retention_at(water, -x * limit).filled_slope / (content / water.pores(J));
        EXPECT_NEAR(water_pressure(water, content, J), -x * limit,
                    1e-11 * x * limit + 4e-16 / slope);
      }
      EXPECT_NEAR(water_pressure(water, water.content_at(1e5, J), J), 1e5, 1e-3);
      EXPECT_LT(water_pressure(water, 1e-6, J), -1e3 * limit);
    }
  }
}

Json with_limit(double limit) {
  Json json = saturated_box(2, "quad4", 4, saturated_elastic());
  json["basis"] = "gimp";
  json["bodies"][0]["water"]["permeability"] = 1e-4;
  json["bodies"][0]["water"]["suction_limit"] = limit;
  return json;
}

TEST(Retention, wrong_limits_are_refused) {
  const std::string key = "/bodies/0/water/suction_limit";
  expect_error<ConfigError>([&] { mpm_settings<2>(with_limit(0)); }, {key, "found 0"});
  // Cells of 0.25 m: half of one is 1226 Pa.
  expect_error<ConfigError>([&] { mpm_settings<2>(with_limit(1000)); },
                            {key, "found 1000", "1226"});
  EXPECT_NO_THROW(mpm_settings<2>(with_limit(1300)));
  Json json = with_limit(1300);
  json["bodies"][0]["water"].erase("permeability");
  expect_error<ConfigError>([&] { mpm_settings<2>(json); }, {key, "permeability"});
}

}  // namespace
}  // namespace gabion::test::test_retention
