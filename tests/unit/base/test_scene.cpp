// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/expect_error.hpp"
#include "tests/support/temporary_scene.hpp"

namespace gabion::test_scene {
namespace {

/// Reads a scene whose file has this text.
void read_text(const std::string& file, const std::string& text,
               const std::vector<std::string>& overrides = {}) {
  const test::TemporaryScene folder(file, Json::object());
  std::ofstream(folder.path() + "/" + file) << text;
  const Scene scene(folder.path(), overrides);
}

void expect_refused(const std::string& file, const std::string& text,
                    const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>([&] { read_text(file, text); }, parts);
}

void expect_override_refused(const std::string& text, const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>([&] { read_text("mpm.json", "{}", {text}); }, parts);
}

TEST(SceneText, repeated_keys_are_refused) {
  for (const std::string file : {"coupler.json", "mpm.json", "fem.json"}) {
    expect_refused(file, R"({"time": 1, "time": 2})", {file + ": at /time:", "second time"});
    expect_refused(file, R"({"a": [1, {"b": {}}, {"b/c": 1, "d": [], "b/c": 1}]})",
                   {file + ": at /a/2/b~1c:", "second time"});
    EXPECT_NO_THROW(read_text(file, R"({"a": {"a": 1}, "b": [{"a": 1}, {"a": 1}]} // "a": 1)"));
  }
}

TEST(SceneText, deep_nesting_is_refused) {
  const auto nested = [](std::size_t depth) {
    return R"({"a": )" + std::string(depth, '[') + std::string(depth, ']') + "}";
  };
  expect_refused("mpm.json", nested(200000),
                 {"mpm.json: at /a/0/0/0", "nested", "allowed: 32 levels"});
  expect_refused("mpm.json", nested(32), {"nested"});
  EXPECT_NO_THROW(read_text("mpm.json", nested(31)));
  EXPECT_NO_THROW(read_text("mpm.json", "{} // " + std::string(100, '[')));
  expect_refused("mpm.json", std::string(200000, '['), {"mpm.json: at /0/0"});
}

TEST(SceneText, numbers_beyond_double_name_their_place) {
  expect_refused("fem.json", R"({"time": {"dt": 1, "end": [0, 1e400]}})",
                 {"fem.json: at /time/end/1:", "1e400", "1.8e308"});
}

TEST(SceneText, broken_text_names_its_line) {
  expect_refused("mpm.json", "{\n\"a\": 1,\n}", {"mpm.json: not valid", "line 3"});
  expect_refused("mpm.json", std::string("{}\n\0 7", 6),
                 {"mpm.json: not valid", "byte 0", "line 2"});
}

TEST(SceneText, overrides_follow_the_same_rules) {
  expect_override_refused(R"(mpm.json:/a={"b": 1, "b": 2})",
                          {"--set mpm.json:/a", "at /b:", "second time"});
  const std::string deep = std::string(50000, '[') + std::string(50000, ']');
  expect_override_refused("mpm.json:/a=" + deep, {"nested"});
  EXPECT_NO_THROW(read_text("mpm.json", "{}", {"mpm.json:/a=some text"}));
}

}  // namespace
}  // namespace gabion::test_scene
