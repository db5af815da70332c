// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/mechanics/materials/strength_reduction.hpp"
#include "mpm_solver/phases/strength_reduction.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

Json clay(double cohesion) {
  Json material = elastic_soil("tresca", 1e8, 0.3, 2000);
  material["cohesion"] = cohesion;
  return material;
}

/// A vertical cut of 4 m above a layer of 4 m, in cells of 1 m.
Json vertical_cut(const Json& material, const Json& reduction) {
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"grid", box({0, 0}, {12, 10}, {12, 10}, "quad4")},
          {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
          {"gravity", {0, -10}},
          {"bodies",
           {body("base", box({0, 0}, {12, 4}, {12, 4}, "quad4"), 4, material),
            body("bench", box({6, 4}, {12, 8}, {6, 4}, "quad4"), 4, material)}},
          {"phases", {{{"strength_reduction", reduction}}}}};
}

Json search(double from, double increment, double tolerance) {
  return {{"from", from},
          {"increment", increment},
          {"tolerance", tolerance},
          {"max_displacement", 0.08}};
}

/// The search of a scene to its end.
Json factor_of_safety(const Json& scene) {
  const auto solver = make_mpm(scene);
  Json summary;
  for (int k = 0; k < 80; ++k) {
    const StepRequest request{k + 1, 0, static_cast<double>(k), 1};
    InterfaceValues sent;
    solver->solve_step(request, {}, sent);
    solver->accept_step(request, true);
    summary = solver->summary().at("strength_reduction");
    if (summary.at("found")) break;
  }
  return summary;
}

/// The bracket does not depend on where the search begins nor on its increment: all of them have a
/// common factor, but for the tolerance.
TEST(StrengthReduction, brackets_of_a_vertical_cut_agree) {
  double low = 0, high = 1e9;
  for (const Json& settings :
       {search(0.5, 0.2, 0.02), search(0.8, 0.2, 0.02), search(0.6, 0.07, 0.01)}) {
    const Json found = factor_of_safety(vertical_cut(clay(25e3), settings));
    ASSERT_TRUE(found.at("found"));
    const double with = found.at("equilibrium_with"), without = found.at("none_with");
    EXPECT_GT(without, with);
    EXPECT_LE(without - with, settings.at("tolerance").get<double>() * (1 + 1e-9));
    low = std::max(low, with);
    high = std::min(high, without);
  }
  EXPECT_LT(low - high, 0.02);
}

/// F = N c / (gamma H) is proportional to the strength.
TEST(StrengthReduction, factor_is_proportional_to_the_strength) {
  const auto factor = [](double cohesion, double share) {
    const Json settings = search(0.6 * share, 0.2 * share, 0.02 * share);
    return factor_of_safety(vertical_cut(clay(cohesion), settings))
        .at("factor_of_safety")
        .get<double>();
  };
  const double one = factor(25e3, 1);
  EXPECT_NEAR(factor(50e3, 2), 2 * one, 0.04);
}

TEST(StrengthReduction, what_cannot_be_reduced_is_refused_by_name) {
  const auto read = [](const Json& material) {
    return [=] { mpm_settings<2>(vertical_cut(material, search(1, 0.1, 0.01))); };
  };
  read(clay(25e3))();
  expect_error<ConfigError>(read(elastic_soil("hencky_elastic", 1e8, 0.3, 2000)),
                            {"/bodies", "elastic laws alone"});
  Json mud = elastic_soil("herschel_bulkley", 1e6, 0.3, 1800);
  mud["yield_stress"] = 100;
  mud["consistency"] = 10;
  expect_error<ConfigError>(read(mud), {"/bodies/0/material/law", "herschel_bulkley"});
}

TEST(StrengthReduction, inertia_is_refused) {
  Json json = vertical_cut(clay(25e3), search(1, 0.1, 0.01));
  json["analysis"] = "dynamic";
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/phases/0/strength_reduction", "quasi_static"});
}

TEST(StrengthReduction, keeps_apex_and_associated_flow) {
  const MohrCoulomb<2> law(1e6, 1e6, 0.5, 0.5, 1e3);
  const auto weaker = with_reduced_strength<2>(MaterialLaw<2>(law), 1.4);
  ASSERT_TRUE(weaker.has_value());
  const auto& p = std::get<MohrCoulomb<2>>(*weaker).parameters();
  EXPECT_NEAR(std::tan(p.friction_angle), std::tan(0.5) / 1.4, 1e-15);
  EXPECT_EQ(p.friction_angle, p.dilation_angle);
  EXPECT_NEAR(p.cohesion / std::tan(p.friction_angle), 1e3 / std::tan(0.5), 1e-9);
  EXPECT_FALSE(with_reduced_strength<2>(MaterialLaw<2>(HenckyElastic<2>{1e6, 1e6}), 1.4));
}

/// Halving after failures ends with a bracket no wider than the tolerance.
TEST(StrengthReduction, search_halves_the_increment) {
  const mpm::StrengthReduction settings{
      .from = 1, .to = 3, .increment = 0.5, .tolerance = 0.01, .max_displacement = 1};
  mpm::StrengthSearch search;
  search.start(settings, 0);
  for (int k = 0; k < 200 && !search.found(); ++k) {
    if (search.next(settings) > 1.7) {
      ASSERT_TRUE(search.fail(settings, mpm::SlopeEnd::no_equilibrium));
    } else {
      ASSERT_TRUE(search.take(settings, 1e-3));
    }
  }
  EXPECT_LE(search.highest(), 1.7);
  EXPECT_GT(search.failed(), 1.7);
  EXPECT_LE(search.failed() - search.highest(), 0.01);
  EXPECT_EQ(search.next(settings), 1);
}

}  // namespace
}  // namespace gabion::test
