// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>

#include "coupler/checks/run_check.hpp"
#include "coupler/checks/scene_check.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/temporary_scene.hpp"
#include "tests/unit/coupler/good_coupler.hpp"

namespace gabion::test_scene_check {
namespace {

/// The keys of a scene's files that matter from file to file; the rest is left out.
class SceneCheck : public ::testing::Test {
 protected:
  /// @returns warnings
  std::vector<std::string> check(const std::vector<std::string>& launched = {"mpm_solver",
                                                                             "fem_solver"}) const {
    const test::TemporaryScene folder("coupler.json", coupler);
    if (!mpm.is_null()) std::ofstream(folder.path() + "/mpm.json") << mpm.dump();
    if (!fem.is_null()) std::ofstream(folder.path() + "/fem.json") << fem.dump();
    const Scene scene(folder.path(), {});
    const CouplerSettings settings =
        read_coupler_settings(scene.reader("coupler.json", coupler_keys()));
    const auto files = files_read(scene, settings, [&](const std::string& name) {
      return std::find(launched.begin(), launched.end(), name) != launched.end();
    });
    std::vector<std::string> warnings = check_files(scene, settings, files);
    for (auto& text : check_attendance(scene, settings, files)) warnings.push_back(text);
    return warnings;
  }

  void expect_refused(const std::vector<std::string_view>& parts) const {
    test::expect_error<ConfigError>([this] { check(); }, parts);
  }

  Json coupler = test::good_coupler();
  Json mpm = {{"dimension", 2}, {"gravity", {0, -9.81}}, {"interfaces", {{{"name", "wall"}}}}};
  Json fem = mpm;
};

TEST_F(SceneCheck, a_good_scene_has_nothing_to_say) {
  EXPECT_EQ(check(), std::vector<std::string>());
}

TEST_F(SceneCheck, an_interface_that_a_side_does_not_have_is_named_with_the_nearest_one) {
  fem["interfaces"] = {{{"name", "fence"}}, {{"name", "walls"}}};
  expect_refused({"/coupler.json: at /interfaces/0/name: found \"wall\"", "of fem.json",
                  "\"structure\"", "fence, walls; did you mean \"walls\"?"});
  fem.erase("interfaces");
  expect_refused({"/coupler.json: at /interfaces/0/name: found \"wall\"", "\"structure\"): none"});
}

TEST_F(SceneCheck, an_interface_that_nobody_couples_is_an_error) {
  mpm["interfaces"].push_back({{"name", "dam"}});
  expect_refused({"/mpm.json: at /interfaces/1/name: found \"dam\"", "\"soil\"",
                  "allowed: wall; did you mean \"wall\"?"});
}

TEST_F(SceneCheck, an_interface_of_another_participant_is_not_coupled) {
  coupler["participants"]["net"] = {{"sends", "displacement"}, {"command", {"net"}}};
  coupler["interfaces"].push_back({{"name", "mesh"}, {"soil", "soil"}, {"structure", "net"}});
  mpm["interfaces"].push_back({{"name", "mesh"}});
  EXPECT_EQ(check().size(), 0u);
  fem["interfaces"].push_back({{"name", "mesh"}});
  expect_refused({"/fem.json: at /interfaces/1/name: found \"mesh\"", "for \"structure\""});
}

TEST_F(SceneCheck, unequal_dimensions_are_an_error) {
  fem["dimension"] = 3;
  expect_refused({"/fem.json: at /dimension: found 3 for \"structure\"", "allowed: 2", "mpm.json"});
}

TEST_F(SceneCheck, what_a_file_does_wrong_by_itself_is_left_to_its_solver) {
  for (const Json& wrong : {Json(7), Json("wall"), Json::array({1}), Json::array({{{"nam", 1}}})}) {
    fem["interfaces"] = wrong;
    EXPECT_EQ(check(), std::vector<std::string>()) << wrong;
  }
  fem = mpm;
  fem["dimension"] = "two";
  EXPECT_EQ(check(), std::vector<std::string>());
  fem = mpm;
  fem["gravity"] = "down";
  EXPECT_TRUE(check().empty());
  fem = {1, 2};
  EXPECT_EQ(check().size(), 1u);  // its gravity is the default
}

TEST_F(SceneCheck, unequal_gravity_is_a_warning) {
  fem["gravity"] = {0, 9.81};
  ASSERT_EQ(check().size(), 1u);
  EXPECT_NE(check()[0].find("/fem.json: at /gravity: found [0, 9.81] for \"structure\", "
                            "but [0, -9.81] for \"soil\" (mpm.json)"),
            std::string::npos)
      << check()[0];
  fem.erase("gravity");
  ASSERT_EQ(check().size(), 1u);
  EXPECT_NE(check()[0].find("[0, 0] (the default)"), std::string::npos);
  fem["matrices"] = Json::object();  // weight is part of their load
  EXPECT_TRUE(check().empty());
  fem.erase("matrices");
  mpm.erase("gravity");
  EXPECT_TRUE(check().empty());
}

TEST_F(SceneCheck, a_file_that_nobody_reads_is_a_warning_that_says_why) {
  coupler["participants"] = {{"sand", {{"sends", "force"}}},
                             {"structure", {{"sends", "displacement"}}}};
  coupler["interfaces"][0]["soil"] = "sand";
  std::vector<std::string> found = check();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NE(found[0].find("/mpm.json: no participant reads this file; coupler.json: at "
                          "/participants: found no \"soil\", it has: sand, structure"),
            std::string::npos)
      << found[0];
  EXPECT_NE(found[1].find("/coupler.json: at /participants/sand: has neither"), std::string::npos)
      << found[1];

  coupler = test::good_coupler();
  coupler["participants"]["structure"]["command"] = {"beam"};
  fem["interfaces"][0]["name"] = "fence";  // of nobody's business
  found = check();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("/fem.json: no participant reads this file; coupler.json: at "
                          "/participants/structure/command"),
            std::string::npos);

  coupler = test::good_coupler();
  found = check({"mpm_solver"});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NE(found[0].find("fem_solver is not part of this launch"), std::string::npos);
  EXPECT_NE(found[1].find("/participants/structure: has neither"), std::string::npos);
}

TEST(RunSize, counts_steps_and_frames_as_a_run_makes_them) {
  const auto size = [](double end, double dt, double interval) {
    const RunSize found = run_size({end, dt, dt, dt}, interval);
    return std::pair(found.steps, found.frames);
  };
  EXPECT_EQ(size(0.5, 2e-4, 0.02), std::pair(2500l, 26l));
  EXPECT_EQ(size(0.3, 0.1, 0.1), std::pair(3l, 4l));  // 0.3 / 0.1 is 2.9999999999999996
  EXPECT_EQ(size(0.0125, 5e-4, 0.0025), std::pair(25l, 6l));
  EXPECT_EQ(size(0.5, 0.3, 0.2), std::pair(2l, 3l));          // no more frames than states
  EXPECT_EQ(size(0.005, 0.001, 0.002), std::pair(5l, 4l));    // 0, 0.002, 0.004 and the end
  EXPECT_EQ(size(0.5, 0.001, 1e-25), std::pair(500l, 501l));  // 5e24 intervals
}

}  // namespace
}  // namespace gabion::test_scene_check
