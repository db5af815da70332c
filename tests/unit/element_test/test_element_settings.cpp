// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "element_test/run_element_test.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/unit/element_test/followed.hpp"

namespace gabion::testing::test_element_settings {
namespace {

void expect_refused(const Json& test, const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>([&] { read(test); }, parts);
}

Json with_stage(const Json& material, const Json& change) {
  Json stage = consolidation(1e5);
  if (change.is_object()) stage.update(change);
  return {{"material", material}, {"stages", {stage}}};
}

TEST(ElementSettings, wrong_input_is_refused_with_its_place) {
  Json soft = sand();
  soft["poisson_ratio"] = 0.5;
  expect_refused(with_stage(soft, nullptr), {"element.json: at /material/poisson_ratio", "0.5"});
  expect_refused({{"stages", {consolidation(1e5)}}}, {"/material", "found none", "--scene"});
  expect_refused({{"material", sand()}, {"stages", Json::array()}}, {"/stages", "empty list"});
  expect_refused(with_stage(sand(), {{"strain", {{"yy", 0.1}}}}),
                 {"/stages/0/stress/yy", "\"yy\" prescribed twice"});
  expect_refused(with_stage(sand(), {{"mean_stress", 1e5}, {"moved_by", {"xx"}}}),
                 {"/stages/0/moved_by", "prescribed twice"});
  expect_refused(
      with_stage(sand(), {{"stress", Json::object()}, {"mean_stress", 1e5}, {"moved_by", {"xy"}}}),
      {"/stages/0/moved_by", "xy", "xx, yy, zz"});
  expect_refused(with_stage(sand(), {{"stress", Json::object()}, {"strain", {{"yy", 1}}}}),
                 {"/stages/0/strain/yy", "below 1"});
  expect_refused(with_stage(sand(), {{"stress", Json::object()}, {"drainage", "undrained"}}),
                 {"/stages/0/drainage", "without a stress"});
  expect_refused(with_stage(sand(), {{"strian", Json::object()}}), {"strian", "strain"});
  expect_refused(with_stage(mud(), nullptr),
                 {"/stages/0/duration", "herschel_bulkley", "may depend on time"});
  expect_refused(with_stage(oil(), nullptr),
                 {"/stages/0/duration", "newtonian", "may depend on time"});
  const Json remembers = {{"law", "cam_clay"},        {"density", 1800},
                          {"poisson_ratio", 0.3},     {"compression_index", 0.1},
                          {"swelling_index", 0.02},   {"critical_state_ratio", 1},
                          {"reference_pressure", 1e5}};
  EXPECT_EQ(read(with_stage(remembers, nullptr)).stages.size(), 1);  // without a duration
  EXPECT_EQ(read(with_stage(remembers, {{"ocr", 4}})).stages[0].ocr, 4);
  expect_refused(with_stage(remembers, {{"ocr", 0.5}}), {"/stages/0/ocr", "0.5"});
  expect_refused(with_stage(sand(), {{"ocr", 2}}), {"/stages/0/ocr", "mohr_coulomb", "allowed: 1"});
  Json sensitive = clay();
  sensitive["softening"] = {{"slip", 0.05}, {"residual_cohesion", 1e4}};
  expect_refused(with_stage(sensitive, nullptr), {"/band_width", "slip"});
}

class ElementProgram : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const Json& content) const {
    std::filesystem::create_directories(folder_ / "scene");
    std::ofstream(folder_ / name) << content.dump();
    return folder_ / name;
  }

  test::TempFolder folder_;
};

TEST_F(ElementProgram, takes_the_material_of_a_scene_with_its_place_in_errors) {
  const Json soil = {{"name", "soil"}, {"material", sand()}};
  const Json rock = {{"name", "rock"}, {"material", elastic()}};
  write("scene/mpm.json", {{"bodies", {soil, rock}}});
  const std::string test = write("test.json", {{"stages", {consolidation(1e5)}}});
  element::ElementOptions options;
  options.test = test;
  options.output = folder_ / "out.csv";
  options.scene = folder_ / "scene";
  const auto run = [&] { run_element_test(options); };
  test::expect_error<ConfigError>(run, {"mpm.json: at /bodies", "soil, rock", "--body NAME"});
  options.body = "rock";
  run();
  std::ifstream table(options.output);
  const std::string text((std::istreambuf_iterator<char>(table)), {});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7);
  options.overrides = {"mpm.json:/bodies/1/material/young_modulus=-1"};
  test::expect_error<ConfigError>(run, {"mpm.json: at /bodies/1/material/young_modulus", "-1"});
}

}  // namespace
}  // namespace gabion::testing::test_element_settings
