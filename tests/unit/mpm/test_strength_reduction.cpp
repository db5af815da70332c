// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/mechanics/materials/strength_reduction.hpp"
#include "mpm_solver/step/strength_search.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/strength_search.hpp"

namespace gabion::test::test_strength_reduction {
namespace {

constexpr double modulus = 1e9;

Json clay(double cohesion) {
  Json material = elastic_soil("tresca", modulus, 0.3, 2000);
  material["cohesion"] = cohesion;
  return material;
}

Json loam(double cohesion) {
  Json material = elastic_soil("mohr_coulomb", modulus, 0.3, 2000);
  material["cohesion"] = cohesion;
  material["friction_angle"] = 20;
  material["dilation_angle"] = 0;
  return material;
}

/// A vertical cut of 4 m above a layer of 4 m, in cells of 1 m.
Json vertical_cut(const Json& material, const Json& reduction) {
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"basis", "linear"},
          {"grid", box({0, 0}, {12, 10}, {12, 10}, "quad4")},
          {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
          {"gravity", {0, -10}},
          {"bodies",
           {body("base", box({0, 0}, {12, 4}, {12, 4}, "quad4"), 4, material),
            body("bench", box({6, 4}, {12, 8}, {6, 4}, "quad4"), 4, material)}},
          {"phases", {{{"strength_reduction", reduction}}}}};
}

/// A search that ends at a displacement of 1 % of the height of the cut.
Json search(double from, double increment, double tolerance) {
  return {{"from", from},
          {"increment", increment},
          {"tolerance", tolerance},
          {"max_displacement", 0.04}};
}

/// The bracket does not depend on where the search begins, also where the soil yields already, on
/// its increment, the stiffness of the soil or the tolerance of Newton's method: all of them have a
/// common factor, but for the tolerance of the bracket.
/// @param late  near the failure
void expect_agreement(const Json& soil, double late) {
  double low = 0, high = 1e9;
  const auto add = [&](const Json& scene) {
    const Json found = search_of_strength(scene);
    ASSERT_EQ(found.at("verdict"), "failure") << found;
    const double with = found.at("equilibrium_with"), without = found.at("none_with");
    EXPECT_GT(without, with);
    EXPECT_LE(without - with, 0.02 * (1 + 1e-9));
    EXPECT_EQ(found.at("steps").back().at("factor"), with);
    EXPECT_EQ(found.at("steps").back().at("displacement"), found.at("displacement"));
    EXPECT_LT(found.at("growth"), 0.01);
    low = std::max(low, with);
    high = std::min(high, without);
  };
  add(vertical_cut(soil, search(0.5, 0.2, 0.02)));
  add(vertical_cut(soil, search(0.4, 0.3, 0.02)));
  add(vertical_cut(soil, search(0.6, 0.07, 0.01)));
  add(vertical_cut(soil, search(0.5, 0.2, 0.01)));
  add(vertical_cut(soil, search(late, 0.2, 0.01)));
  Json stiff = soil;
  stiff["young_modulus"] = 4 * modulus;
  add(vertical_cut(stiff, search(0.5, 0.2, 0.02)));
  Json fine = vertical_cut(soil, search(0.6, 0.2, 0.02));
  fine["newton"] = {{"residual_tolerance", 1e-8}};
  add(fine);
  EXPECT_LT(low - high, 0.02);
}

/// A block that does not yield on a rough floor, under gravity turned by 20 degrees: it slides
/// where the friction of the floor is tan 20, whatever its own strength.
TEST(StrengthReduction, friction_of_walls_is_reduced_too) {
  const double friction = 0.5, angle = 20 * std::numbers::pi / 180;
  Json floor = {{"name", "floor"},
                {"surface", {{"polyline", {{12, 1}, {0, 1}}}, {"spacing", 1}}},
                {"friction", friction}};
  const Json scene = {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"basis", "linear"},
      {"grid", box({0, 0}, {12, 6}, {12, 6}, "quad4")},
      {"gravity", {10 * std::sin(angle), -10 * std::cos(angle)}},
      {"rigid_walls", {floor}},
      {"bodies", {body("block", box({2, 1}, {8, 3}, {6, 2}, "quad4"), 4, clay(1e6))}},
      {"phases", {{{"strength_reduction", search(1, 0.1, 0.005)}}}}};
  const Json found = search_of_strength(scene);
  ASSERT_EQ(found.at("verdict"), "failure") << found;
  const double right = friction / std::tan(angle);
  EXPECT_NEAR(found.at("equilibrium_with").get<double>(), right, 0.02 * right);
  EXPECT_NEAR(found.at("none_with").get<double>(), right, 0.02 * right);
}

TEST(StrengthReduction, brackets_of_a_cut_in_clay_agree) {
  expect_agreement(clay(25e3), 1.1);
}

TEST(StrengthReduction, brackets_of_a_cut_with_friction_agree) {
  expect_agreement(loam(15e3), 1.1);
}

/// A rigid wall that props the cut makes it safer.
TEST(StrengthReduction, a_rigid_wall_props_a_vertical_cut) {
  Json scene = vertical_cut(clay(25e3), search(0.6, 0.2, 0.02));
  const double alone = search_of_strength(scene).at("none_with");
  const Json surface = {{"polyline", {{6, 4.25}, {6, 8}}}, {"spacing", 0.5}};
  scene["rigid_walls"] = {{{"name", "prop"}, {"surface", surface}, {"mode", "slip"}}};
  EXPECT_GT(search_of_strength(scene).at("equilibrium_with"), alone + 0.1);
}

/// F = N c / (gamma H) is proportional to the strength.
TEST(StrengthReduction, factor_is_proportional_to_the_strength) {
  const auto factor = [](double cohesion, double share) {
    const Json settings = search(0.6 * share, 0.2 * share, 0.02 * share);
    return search_of_strength(vertical_cut(clay(cohesion), settings))
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

TEST(StrengthReduction, wide_bases_are_refused) {
  for (const char* basis : {"gimp", "bspline"}) {
    Json json = vertical_cut(clay(25e3), search(1, 0.1, 0.01));
    json["basis"] = basis;
    expect_error<ConfigError>([&] { mpm_settings<2>(json); }, {"/basis", basis, "linear"});
  }
}

TEST(StrengthReduction, water_that_drains_is_refused) {
  for (const char* basis : {"linear", "gimp"}) {
    Json json = vertical_cut(clay(25e3), search(1, 0.1, 0.01));
    json["basis"] = basis;
    json["bodies"][0]["water"] = {{"porosity", 0.4}, {"permeability", 1e-5}};
    expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                              {"/bodies/0/water/permeability", "strength_reduction"});
  }
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

/// A search up to 1.7 from 1, with the displacement of a step from one F to another.
template <class Displacement>
mpm::StrengthSearch searched(const Displacement& displacement) {
  const mpm::StrengthReduction settings{
      .from = 1, .to = 3, .increment = 0.5, .tolerance = 0.01, .max_displacement = 1};
  mpm::StrengthSearch search;
  search.start(settings, 0);
  for (int k = 0; k < 200 && !search.bracketed(); ++k) {
    const double next = search.next(settings);
    if (next > 1.7) {
      EXPECT_TRUE(search.can_fail(settings));
      search.fail(settings, mpm::SlopeEnd::no_equilibrium, "iteration limit");
    } else {
      EXPECT_TRUE(search.take(settings, displacement(search.highest(), next)));
    }
  }
  EXPECT_EQ(search.next(settings), 1);
  return search;
}

/// Halving after failures ends with a bracket no wider than the tolerance.
TEST(StrengthReduction, search_halves_the_increment) {
  const auto search = searched([](double from, double to) { return 1e-3 * (to - from); });
  EXPECT_LE(search.highest(), 1.7);
  EXPECT_GT(search.failed(), 1.7);
  EXPECT_LE(search.failed() - search.highest(), 0.01);
}

/// Where soil does not slide more and more, Newton's method gave up: no factor of safety is given.
TEST(StrengthReduction, failure_is_told_from_what_was_not_solved) {
  const Json even = searched([](double from, double to) { return 1e-3 * (to - from); }).summary();
  EXPECT_EQ(even.at("verdict"), "not_solved");
  EXPECT_EQ(even.at("reason"), "iteration limit");
  EXPECT_FALSE(even.contains("factor_of_safety"));
  const auto sliding = [](double F) { return 1e-3 / (1.71 - F); };
  const Json slid =
      searched([&](double from, double to) { return sliding(to) - sliding(from); }).summary();
  EXPECT_EQ(slid.at("verdict"), "failure");
  EXPECT_NEAR(slid.at("factor_of_safety").get<double>(), 1.7, 0.01);
}

/// A failure is an error before a search begins and after its end.
TEST(StrengthReduction, failures_outside_of_a_search_are_refused) {
  const mpm::StrengthReduction settings{.max_displacement = 1};
  mpm::StrengthSearch search;
  search.start(settings, 0);
  EXPECT_FALSE(search.can_fail(settings));
  expect_error<Error>([&] { search.fail(settings, mpm::SlopeEnd::no_equilibrium, "no"); },
                      {"outside of the search"});
}

}  // namespace
}  // namespace gabion::test::test_strength_reduction
