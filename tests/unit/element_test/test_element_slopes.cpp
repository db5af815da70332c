// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of the sample's answer against differences.
#include <gtest/gtest.h>

#include "tests/unit/element_test/followed.hpp"

namespace gabion::testing::test_element_slopes {
namespace {

using element::Response;
using element::Trial;
using element::Vector6;

void expect_slopes(const Json& test, const element::PoreState& pores, const Trial& trial) {
  const auto settings = read(test);
  const element::ElementPoint point(settings);
  const ElementState from = follow(test).back();
  Response found, after, before;
  ASSERT_EQ(point.answer(from, pores, trial, found), "");
  const double step = 1e-7;
  for (int k = 0; k < element::num_components; ++k) {
    Trial shifted = trial;
    shifted.strain[k] += step;
    ASSERT_EQ(point.answer(from, pores, shifted, after), "");
    shifted.strain[k] -= 2 * step;
    ASSERT_EQ(point.answer(from, pores, shifted, before), "");
    const Vector6 slope = (after.state.stress() - before.state.stress()) / (2 * step);
    const double scale = found.stress_slope.leftCols<6>().norm();
    EXPECT_LT((slope - found.stress_slope.col(k)).norm(), 1e-6 * scale) << test << " " << k;
    EXPECT_NEAR((after.state.log_J - before.state.log_J) / (2 * step), found.log_J_slope[k], 1e-7);
  }
}

TEST(ElementSlopes, of_laws_with_and_without_memory_and_water) {
  Json softened = sand();
  softened["softening"] = {{"slip", 0.05}, {"residual_friction_angle", 28}};
  Json linear = elastic(), neo_hookean = elastic(), cone = sand();
  linear["law"] = "linear_elastic";
  neo_hookean["law"] = "neo_hookean";
  cone["law"] = "drucker_prager";
  for (const Json& soil :
       {elastic(), linear, neo_hookean, sand(), cone, clay(), softened, mud(0.6)}) {
    for (const char* rotation : {"none", "simple_shear"}) {
      Json test = {{"material", soil}, {"rotation", rotation}, {"band_width", 0.1}};
      const Json shear = {
          {"name", "shear"},
          {"strain", {{"xx", 0.01}, {"yy", 0.03}, {"zz", -0.01}, {"xy", 0.02}, {"xz", 0.01}}},
          {"duration", 1}};
      test["stages"] = {shear};
      const ElementState from = follow(test).back();
      Trial trial{.strain = from.strain, .pore_pressure = 3e4, .dt = 0.01};
      trial.strain += (Vector6() << -1e-3, -4e-3, 2e-3, 3e-3, -1e-3, 2e-3).finished();
      expect_slopes(test, {}, trial);
      test["water"] = {{"porosity", 0.4}, {"bulk_modulus", 1e9}};
      expect_slopes(test, {.undrained = true, .content = 0.45}, trial);
    }
  }
}

}  // namespace
}  // namespace gabion::testing::test_element_slopes
