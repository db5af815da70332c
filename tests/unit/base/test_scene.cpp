// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_scene.hpp"

namespace gabion {
namespace {

/// What the reader of a scene says to the text of one of its files.
std::string error_of_text(const std::string& file, const std::string& text,
                          const std::vector<std::string>& overrides = {}) {
  const test::TemporaryScene folder(file, Json::object());
  std::ofstream(folder.path() + "/" + file) << text;
  try {
    const Scene scene(folder.path(), overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

void expect_scene_error(const std::string& found, const std::vector<std::string>& parts) {
  for (const auto& part : parts) {
    EXPECT_NE(found.find(part), std::string::npos) << "\"" << part << "\" is not in: " << found;
  }
}

TEST(SceneText, RepeatedKeysAreRefused) {
  for (const std::string file : {"coupler.json", "mpm.json", "fem.json"}) {
    expect_scene_error(error_of_text(file, R"({"time": 1, "time": 2})"),
                       {file + ": at /time:", "second time"});
    expect_scene_error(
        error_of_text(file, R"({"a": [1, {"b": {}}, {"b/c": 1, "d": [], "b/c": 1}]})"),
        {file + ": at /a/2/b~1c:", "second time"});
    EXPECT_EQ(error_of_text(file, R"({"a": {"a": 1}, "b": [{"a": 1}, {"a": 1}]} // "a": 1)"),
              "no error");
  }
}

TEST(SceneText, DeepNestingIsRefused) {
  const auto nested = [](std::size_t depth) {
    return R"({"a": )" + std::string(depth, '[') + std::string(depth, ']') + "}";
  };
  expect_scene_error(error_of_text("mpm.json", nested(200000)),
                     {"mpm.json: at /a/0/0/0", "nested", "allowed: 32 levels"});
  expect_scene_error(error_of_text("mpm.json", nested(32)), {"nested"});
  EXPECT_EQ(error_of_text("mpm.json", nested(31)), "no error");
  EXPECT_EQ(error_of_text("mpm.json", "{} // " + std::string(100, '[')), "no error");
  expect_scene_error(error_of_text("mpm.json", std::string(200000, '[')), {"mpm.json: at /0/0"});
}

TEST(SceneText, NumbersBeyondDoubleNameTheirPlace) {
  expect_scene_error(error_of_text("fem.json", R"({"time": {"dt": 1, "end": [0, 1e400]}})"),
                     {"fem.json: at /time/end/1:", "1e400", "1.8e308"});
}

TEST(SceneText, BrokenTextNamesItsLine) {
  expect_scene_error(error_of_text("mpm.json", "{\n\"a\": 1,\n}"),
                     {"mpm.json: not valid", "line 3"});
  expect_scene_error(error_of_text("mpm.json", std::string("{}\n\0 7", 6)),
                     {"mpm.json: not valid", "byte 0", "line 2"});
}

TEST(SceneText, OverridesFollowTheSameRules) {
  expect_scene_error(error_of_text("mpm.json", "{}", {R"(mpm.json:/a={"b": 1, "b": 2})"}),
                     {"--set mpm.json:/a", "at /b:", "second time"});
  const std::string deep = std::string(50000, '[') + std::string(50000, ']');
  expect_scene_error(error_of_text("mpm.json", "{}", {"mpm.json:/a=" + deep}), {"nested"});
  EXPECT_EQ(error_of_text("mpm.json", "{}", {"mpm.json:/a=some text"}), "no error");
}

}  // namespace
}  // namespace gabion
