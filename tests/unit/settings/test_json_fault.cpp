// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "common/settings/json_text.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_json_fault {
namespace {

TEST(JsonFault, says_where_what_was_found_and_what_is_allowed) {
  const std::string comma = "after a comma, allowed: commas between entries only";
  const std::string value =
      "allowed: a text in quotes, a number, true, false, null, a list, an object";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"{\"a\": 1,\n}", "line 2, column 1: found \"}\" " + comma},
      {"{\"a\": [1, 2, ] }", "line 1, column 14: found \"]\" " + comma},
      {"{\"a\": 1, // text,\n /* , */ }", "line 2, column 10: found \"}\" " + comma},
      {"{\"a\": \"},\", \n\n]", "line 3, column 1: found \"]\" " + comma},
      {"{\"a\": \"\\\",\"]", "line 1, column 12: found \"]\", allowed: \",\" or \"}\""},
      {"[1,,2]", "line 1, column 4: found \",\", allowed: a value"},
      {"{\"a\": 1 \"b\": 2}", "found a text in quotes, allowed: \",\" or \"}\""},
      {"{\"a\": [1 2]}", "found a number, allowed: \",\" or \"]\""},
      {"{\"a\": NaN}", "line 1, column 7: found NaN, " + value},
      {"{\"a\": 'x'}", "found 'x', " + value},
      {"{\"a\": tru}", "found tru, " + value},
      {"{a: 1}", "found a, allowed: a text in quotes"},
      {"{\"a\": 1", "found the end of the file, allowed: \",\" or \"}\""},
      {"", "line 1, column 1: found the end of the file, allowed: a value"},
      {"{\"a\": \"x\ny\"}", "line 1, column 9: found a text without its closing quote"},
      {"{\"a\": 1.}", "found an invalid number; expected digit after '.'"},
      {"{} /* x", "missing closing '*/'"},
      {"{\"a\": 1e999}", "f.json: at /a: number overflow parsing '1e999'"}};
  for (const auto& [text, words] : cases) {
    const std::string said = test::error_of<ConfigError>([&] { parse_settings(text, "f.json"); });
    test::expect_parts(said, {"f.json: ", words});
    EXPECT_EQ(said.find("json.exception"), std::string::npos) << said;
    EXPECT_EQ(said.find("parse error"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace gabion::test_json_fault
