// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <string>

#include "mpm_solver/contact/group_config.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_group_config {
namespace {

Json group(const std::string& name, const std::vector<std::string>& bodies) {
  return {{"name", name}, {"bodies", bodies}};
}

/// Two blocks, the second one `above` the first by this distance, that fly towards each other.
Json two_blocks(double above) {
  const Json soil = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  return {{"dimension", 2},
          {"grid", box({0, 0}, {1, 1.5}, {10, 15}, "quad4")},
          {"time_integration", trapezoid},
          {"newton", exact_newton},
          {"bodies",
           {body("low", box({0.22, 0.2}, {0.72, 0.5}, {5, 3}, "quad4"), 4, soil, {0.3, 1}),
            body("high", box({0.35, 0.5 + above}, {0.65, 0.7 + above}, {3, 2}, "quad4"), 4, soil,
                 {0, -1})}}};
}

Json with_groups(Json scene, double friction = 0.3) {
  scene["contact_groups"] = {{"groups", {group("a", {"low"}), group("b", {"high"})}},
                             {"pairs", {{{"groups", {"a", "b"}}, {"friction", friction}}}}};
  return scene;
}

void expect_refusal(const Json& scene, const std::string& pointer, const std::string& text) {
  expect_error<ConfigError>([&] { mpm_settings<2>(scene); }, {pointer, text});
}

TEST(GroupConfig, reads_groups_and_pairs) {
  const auto settings = mpm_settings<2>(with_groups(two_blocks(0)));
  const mpm::BodyGroups& groups = settings.body_groups;
  EXPECT_EQ(groups.of_body, (std::vector<std::int32_t>{0, 1}));
  ASSERT_EQ(groups.pairs.size(), 1u);
  EXPECT_EQ(groups.pairs[0].friction, 0.3);
  EXPECT_FALSE(mpm_settings<2>(two_blocks(0)).body_groups.any());
}

TEST(GroupConfig, refuses_what_is_not_there_or_twice) {
  Json scene = with_groups(two_blocks(0));
  scene["contact_groups"]["groups"][1] = group("b", {"hihg"});
  expect_refusal(scene, "/contact_groups/groups/1/bodies", "\"hihg\"");
  scene["contact_groups"]["groups"][1] = group("b", {"low", "high"});
  expect_refusal(scene, "/contact_groups/groups/1/bodies", "a second time");
  scene["contact_groups"]["groups"][1] = group("a", {"high"});
  expect_refusal(scene, "/contact_groups/groups/1/name", "a second time");
  scene = with_groups(two_blocks(0));
  scene["contact_groups"]["groups"].erase(1);
  expect_refusal(scene, "/contact_groups/groups", "no group with the body \"high\"");
  scene = with_groups(two_blocks(0));
  scene["contact_groups"]["pairs"][0]["groups"] = {"a", "c"};
  expect_refusal(scene, "/contact_groups/pairs/0/groups", "\"c\"");
  scene["contact_groups"]["pairs"][0]["groups"] = {"a", "a"};
  expect_refusal(scene, "/contact_groups/pairs/0/groups", "two that differ");
  scene = with_groups(two_blocks(0));
  scene["contact_groups"]["pairs"].push_back({{"groups", {"b", "a"}}});
  expect_refusal(scene, "/contact_groups/pairs/1/groups", "a second time");
  scene = with_groups(two_blocks(0));
  scene["contact_groups"]["pairs"][0]["mode"] = "slip";
  expect_refusal(scene, "/contact_groups/pairs/0/friction", "mode");
  Json third = two_blocks(0);
  third["bodies"].push_back(body("third", box({0, 1.2}, {0.2, 1.4}, {2, 2}, "quad4"), 4,
                                 elastic_soil("neo_hookean", 1e6, 0.3, 1500)));
  expect_refusal(with_groups(third), "/contact_groups/groups", "\"third\"");
  scene = with_groups(third);
  scene["contact_groups"]["groups"].push_back(group("c", {"third"}));
  expect_refusal(scene, "/contact_groups/pairs", "no pair of \"a\" and \"c\"");
}

TEST(GroupConfig, refuses_what_is_not_supported) {
  Json scene = with_groups(two_blocks(0));
  scene["grid"] = box({0, 0}, {1, 1.5}, {10, 15}, "tri3");
  expect_refusal(scene, "/contact_groups", "not a \"box\" of quad4");
  scene = with_groups(two_blocks(0));
  scene["bodies"][1]["mesh"]["box"]["cells"] = {8, 3};
  expect_refusal(scene, "/bodies/1/mesh", "squares");
  scene = with_groups(two_blocks(0));
  scene["rigid_walls"] = {{{"name", "floor"},
                           {"method", "boundary_points"},
                           {"surface", {{"polyline", {{1, 0.1}, {0, 0.1}}}, {"spacing", 0.1}}}}};
  expect_refusal(scene, "/contact_groups", "boundary points of \"floor\"");
  scene = with_groups(two_blocks(0));
  scene["time_integration"] = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.8}};
  expect_refusal(scene, "/time_integration", "generalized_alpha");
}

TEST(GroupConfig, bodies_that_share_no_node_are_the_same_to_the_bit) {
  for (const char* scheme : {"newmark", "explicit"}) {
    Json apart = two_blocks(0.4);
    apart["time_integration"] = {{"scheme", scheme}};
    if (scheme == std::string("explicit")) apart.erase("newton");
    const auto as_today = mpm_solver<2>(apart), grouped = mpm_solver<2>(with_groups(apart));
    run_steps(*as_today, 1e-3, 20);
    run_steps(*grouped, 1e-3, 20);
    EXPECT_TRUE(same_bits(as_today->points(), grouped->points())) << scheme;
  }
}

TEST(GroupConfig, a_run_goes_on_from_its_state_to_the_bit) {
  for (const char* scheme : {"newmark", "explicit"}) {
    Json scene = with_groups(two_blocks(0));
    scene["time_integration"] = {{"scheme", scheme}};
    if (scheme == std::string("explicit")) scene.erase("newton");
    const auto whole = mpm_solver<2>(scene), first = mpm_solver<2>(scene),
               second = mpm_solver<2>(scene);
    run_steps(*whole, 1e-3, 20);
    run_steps(*first, 1e-3, 10);
    EXPECT_GT(probe(*first, "contact.a.b.fy"), 0) << scheme;
    second->load_state(first->save_state());
    EXPECT_EQ(probe(*second, "contact.a.b.fy"), probe(*first, "contact.a.b.fy"));
    run_steps(*second, 1e-3, 10, 11);
    EXPECT_TRUE(same_bits(whole->points(), second->points())) << scheme;
    EXPECT_EQ(probe(*whole, "contact_loss"), probe(*second, "contact_loss"));
  }
}

TEST(GroupConfig, a_state_of_other_groups_is_refused) {
  const Json scene = two_blocks(0.4);
  const auto without = make_mpm(scene), with = make_mpm(with_groups(scene));
  expect_error<Error>([&] { without->load_state(with->save_state()); }, {"with contact_groups"});
  expect_error<Error>([&] { with->load_state(without->save_state()); }, {"without contact_groups"});
  Json other = with_groups(scene);
  other["contact_groups"]["groups"] = {group("a", {"high"}), group("b", {"low"})};
  expect_error<Error>([&] { make_mpm(other)->load_state(with->save_state()); },
                      {"found the contact groups", "allowed"});
  EXPECT_NO_THROW(make_mpm(with_groups(scene, 0.1))->load_state(with->save_state()));
}

}  // namespace
}  // namespace gabion::test::test_group_config
