// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/ranks/rank_advice.hpp"

#include <gtest/gtest.h>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_rank_advice {
namespace {

/// A block of 20 by 16 by `layers` cells with 8 points each.
Json block(int layers) {
  const Json material = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  return {{"dimension", 3},
          {"grid", box({0, 0, 0}, {4, 2, 2}, {40, 20, 20}, "hex8")},
          {"basis", "gimp"},
          {"bodies",
           {body("soil", box({0, 0, 0}, {2, 1.6, 0.1 * layers}, {20, 16, layers}, "hex8"), 8,
                 material)}},
          {"walls", {wall("zmin", "slip")}}};
}

mpm::RankAdvice advice(const Json& json, int cores) {
  return mpm::advise_ranks(mpm_settings<3>(json), cores);
}

void expect_one(const Json& json, const std::string& reason) {
  const mpm::RankAdvice found = advice(json, 8);
  EXPECT_EQ(found.ranks, 1);
  EXPECT_NE(found.reason.find(reason), std::string::npos) << found.reason;
}

/// The two sides of a wall across x.
Json wall_of(double thickness) {
  const Json mesh = box({2.5, 0, 0}, {2.5 + thickness, 2, 1}, {1, 20, 10}, "hex8");
  Json sides = Json::array();
  for (const char* group : {"left", "right"}) {
    sides.push_back({{"name", group},
                     {"method", "facets"},
                     {"surface", {{"mesh", mesh}, {"groups", {group}}}}});
  }
  return sides;
}

TEST(RankAdvice, a_rank_for_ten_thousand_points_and_no_more_than_cores) {
  EXPECT_EQ(advice(block(7), 8).ranks, 1);  // 17,920 points
  EXPECT_EQ(advice(block(8), 8).ranks, 2);  // 20,480
  EXPECT_EQ(advice(block(16), 8).ranks, 4);
  EXPECT_EQ(advice(block(16), 2).ranks, 2);
  EXPECT_EQ(advice(block(16), 1).ranks, 1);
  EXPECT_EQ(advice(block(16), 2).reason, "40960 points in space, 2 cores");
}

TEST(RankAdvice, points_of_all_bodies_count) {
  Json json = block(7);
  Json other = json["bodies"][0];
  other["name"] = "more";
  other["mesh"] = box({2, 0, 0}, {4, 1.6, 0.7}, {20, 16, 7}, "hex8");
  json["bodies"].push_back(other);
  EXPECT_EQ(advice(json, 8).ranks, 3);
}

TEST(RankAdvice, the_plane_keeps_one) {
  const Json material = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  const Json json = {
      {"dimension", 2},
      {"grid", box({0, 0}, {2, 2}, {200, 200}, "quad4")},
      {"bodies", {body("soil", box({0, 0}, {1, 1}, {100, 100}, "quad4"), 4, material)}},
      {"walls", {wall("bottom", "slip")}}};
  EXPECT_EQ(mpm::advise_ranks(mpm_settings<2>(json), 8).ranks, 1);
}

TEST(RankAdvice, what_is_there_on_one_rank_only_keeps_one) {
  Json wet = block(16);
  wet["bodies"][0]["water"] = {{"porosity", 0.4}, {"permeability", 1e-3}};
  expect_one(wet, "pore water that drains");
  Json direct = block(16);
  direct["linear_solver"] = {{"method", "mumps"}};
  expect_one(direct, "mumps");
}

/// Nodes are doubled at a wall with facets on both sides that is thinner than two cells.
TEST(RankAdvice, thin_walls_do_not_keep_one) {
  Json json = block(16);
  json["rigid_walls"] = wall_of(0.05);
  EXPECT_EQ(advice(json, 8).ranks, 4);
}

}  // namespace
}  // namespace gabion::test::test_rank_advice
