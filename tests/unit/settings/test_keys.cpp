// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/settings/describe_keys.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_keys {
namespace {

KeyTable law_keys() {
  return {
      "law",
      "A law.",
      {key::choice("law", {"sand", "clay", "rock"}, "Which.").or_else("sand"),
       key::number("angle", "deg", "Of friction.").in(inside(0, 90)).when("law", {"sand"}),
       key::number("cohesion", "Pa", "c | c'.").in(non_negative()).or_else(0).when("law", {"sand"}),
       key::number("cohesion", "Pa", "Strength.").in(positive()).when("law", {"clay"}),
       key::number("cutoff", "Pa", "Limit.").or_none().with("angle")}};
}

KeyTable root_keys() {
  return {"root",
          "A file.",
          {key::object("law", law_keys(), "The law."),
           key::objects("laws", law_keys(), "More.").or_empty(),
           key::objects("laws", law_keys(), "Fewer.").or_none().with("file"),
           key::integer("count", "A count.").in(at_least(1)).or_else(3),
           key::number("limit", "", "A limit.").in(between(0, 1)).or_null().or_computed("half"),
           key::vector("gravity", "m/s^2", "Gravity.").or_else(0),
           key::text("file", "A file.").or_none()},
          {"law", "file"}};
}

TEST(Range, open_and_closed_ends) {
  EXPECT_FALSE(positive().holds(0));
  EXPECT_TRUE(non_negative().holds(0));
  EXPECT_TRUE(between(0, 1).holds(1));
  EXPECT_FALSE(inside(0, 1).holds(1));
  EXPECT_FALSE(inside(0, 1).holds(0));
  EXPECT_TRUE(inside(0, 1).holds(0.5));
  EXPECT_FALSE(at_least(2).holds(1.9));
  EXPECT_TRUE(any_number().holds(-1e300));
  EXPECT_FALSE(between(0, 1).holds(std::numeric_limits<double>::quiet_NaN()));
}

TEST(Keys, conditions_count_the_default_of_the_other_key) {
  const KeyTable table = law_keys();
  const Key& angle = table.keys[1];
  EXPECT_TRUE(applies(angle, table, Json::object()));
  EXPECT_TRUE(applies(angle, table, {{"law", "sand"}}));
  EXPECT_FALSE(applies(angle, table, {{"law", "clay"}}));
  EXPECT_FALSE(applies(angle, table, {{"law", 1}}));
  const Key& cutoff = table.keys[4];
  EXPECT_FALSE(applies(cutoff, table, Json::object()));
  EXPECT_TRUE(applies(cutoff, table, {{"angle", 30}}));
  EXPECT_TRUE(applies(key::text("a", "").without("b"), table, Json::object()));
  EXPECT_FALSE(applies(key::text("a", "").without("b"), table, {{"b", 1}}));
}

TEST(DescribeKeys, a_section_a_table_and_a_row_a_key) {
  const std::string text = keys_as_markdown(root_keys(), "a.json");
  test::expect_parts(text,
                     {"# a.json\n", "## `law`, `laws/#`\n\nA law.\n",
                      "| `angle` | number | deg | > 0 and < 90 | required | Of friction. Only with "
                      "`law` `sand`. |",
                      "| `cohesion` | number | Pa | >= 0 | 0 | c \\| c'. Only with `law` `sand`. |",
                      "| `cutoff` | number | Pa |  | none | Limit. Only with `angle`. |",
                      "| `count` | whole number |  | >= 1 | 3 | A count. |",
                      "| `limit` | number or null |  | 0 to 1 | half | A limit. |",
                      "| `gravity` | list of 2 or 3 numbers | m/s^2 |  | 0 | Gravity. |",
                      "| `law` | word |  | `sand`, `clay`, `rock` | `sand` | Which. |"});
  EXPECT_EQ(text.find("## `law`", text.find("## `law`") + 1), std::string::npos);
}

TEST(DescribeKeys, the_schema_has_types_ranges_and_defaults) {
  const Json schema = keys_as_schema(root_keys(), "a.json");
  EXPECT_EQ(schema["$schema"], "http://json-schema.org/draft-07/schema#");
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["required"], Json::array({"law"}));
  const Json count = {
      {"type", "integer"}, {"minimum", 1}, {"default", 3}, {"description", "A count."}};
  EXPECT_EQ(schema["properties"]["count"], count);
  EXPECT_EQ(schema["properties"]["limit"]["type"], Json::array({"number", "null"}));
  EXPECT_EQ(schema["properties"]["gravity"]["description"], "Gravity. [m/s^2]");
  const Json& law = schema["definitions"]["law"];
  EXPECT_EQ(law["properties"]["angle"]["exclusiveMaximum"], 90);
  EXPECT_EQ(law["properties"]["cohesion"]["anyOf"].size(), 2u);
  EXPECT_EQ(law["properties"]["law"]["enum"].size(), 3u);
  EXPECT_EQ(schema["oneOf"].size(), 2u);
}

TEST(DescribeKeys, another_form_is_refused) {
  test::expect_error<ConfigError>([] { describe_keys(root_keys(), "a.json", "yaml"); },
                                  {"--describe-keys: found \"yaml\", allowed: markdown, schema"});
}

}  // namespace
}  // namespace gabion::test_keys
