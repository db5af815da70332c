// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/mechanics/ranks/sum.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/gmsh_text.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_held_parts {
namespace {

Json held(const TemporaryMesh& mesh, const std::vector<std::string>& groups) {
  Json json = {{"dimension", 2},
               {"mesh", {{"file", mesh.path()}}},
               {"material", elastic("linear_elastic", 1e7, 0.3, 1000)},
               {"gravity", {0, -10}},
               {"supports", Json::array()}};
  for (const auto& group : groups) json["supports"].push_back({{"group", group}});
  return json;
}

/// Reads the settings on all ranks. @returns the warnings of the first one
std::string warnings_of(const GmshText& file, const std::vector<std::string>& groups,
                        const std::string& analysis = "dynamic") {
  const TemporaryMesh mesh(file);
  Json json = held(mesh, groups);
  json["analysis"] = analysis;
  testing::internal::CaptureStderr();
  fem_settings<2>(json, comm());
  return testing::internal::GetCapturedStderr();
}

void expect_refused(const GmshText& file, const std::vector<std::string>& groups,
                    const std::string& analysis, const std::vector<std::string_view>& parts) {
  const TemporaryMesh mesh(file);
  Json json = held(mesh, groups);
  json["analysis"] = analysis;
  expect_error<ConfigError>([&] { fem_settings<2>(json, comm()); }, parts);
}

TEST(HeldParts, what_lies_on_a_held_part_without_being_joined_is_refused) {
  for (const std::string analysis : {"dynamic", "static"}) {
    expect_refused(loose_tower(), {"foot"}, analysis,
                   {"at /mesh: found 2 parts that share no nodes", "part 2, 1 cell from (0, 1)",
                    "held by nothing", "2 of its nodes", "2 places", "(1, 1)", "join them"});
  }
}

TEST(HeldParts, a_part_far_from_the_others_may_fly) {
  GmshText file = loose_tower();
  for (const int i : {4, 5, 6, 7}) file.nodes[i][1] += 1;
  const std::string text = warnings_of(file, {"foot"});
  if (rank_of(comm()) == 0) expect_parts(text, {"part 2, 1 cell from (0, 2)", "it moves freely"});
  expect_refused(file, {"foot"}, "static", {"part 2", "held by nothing in x"});
}

TEST(HeldParts, parts_that_are_held_may_touch) {
  const std::string text = warnings_of(loose_tower(), {"foot", "top"}, "static");
  if (rank_of(comm()) == 0) expect_parts(text, {"warning", "2 places with several nodes"});
}

/// In statics each part is held in each direction.
TEST(HeldParts, a_part_on_rollers_is_refused_in_statics) {
  const TemporaryMesh mesh(loose_tower());
  Json json = held(mesh, {"foot"});
  json["analysis"] = "static";
  json["supports"].push_back({{"group", "top"}, {"components", {"x"}}});
  expect_error<ConfigError>([&] { fem_settings<2>(json, comm()); }, {"held by nothing in y"});
  json["prescribed"] = {{{"group", "top"}, {"component", "y"}, {"rate", 0.1}}};
  fem_settings<2>(json, comm());
}

TEST(HeldParts, one_piece_says_nothing) {
  for (const std::string analysis : {"dynamic", "static"}) {
    EXPECT_EQ(warnings_of(tower(), {"foot", "top"}, analysis).find("warning"), std::string::npos);
  }
}

}  // namespace
}  // namespace gabion::test::test_held_parts
