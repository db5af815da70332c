// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "common/settings/config_reader.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_config_reader {
namespace {

using test::expect_error;

KeyTable point_keys() {
  return {"point",
          "A point.",
          {key::plain_name("Its own."), key::vector("place", "m", "Where it is.").or_else(0)}};
}

/// A key of each kind.
KeyTable all_keys() {
  return {"all",
          "A key of each kind.",
          {key::number("width", "m", "A width.").in(positive()),
           key::number("height", "m", "A height.").in(non_negative()).or_else(2),
           key::number("depth", "m", "A depth.").or_computed("width"),
           key::number("weight", "N", "A weight.").or_none(),
           key::number("limit", "", "A limit.").in(between(0, 1)).or_null().or_else(0.5),
           key::integer("count", "A count.").in(at_least(1)).or_else(3),
           key::integer("parts", "Parts.").or_computed("count"),
           key::boolean("closed", "Whether.").or_else(true),
           key::boolean("painted", "Whether.").or_computed("closed"),
           key::text("file", "A file.").or_else("a.msh"),
           key::choice("colour", {"red", "green"}, "A colour.").or_else("red"),
           key::choice("shade", {"dark", "light"}, "A shade.").or_computed("dark"),
           key::number("gloss", "", "Of red only.").or_else(1).when("colour", {"red"}),
           key::vector("gravity", "m/s^2", "Gravity.").or_else(0),
           key::integers("cells", "Cells.").in(at_least(1)).only("in tests"),
           key::texts("sides", "Sides.").or_computed("all"),
           key::texts("groups", "Groups.").only("in tests"),
           key::rows("table", "s, m", "Rows.").wide(2, 2).not_empty().or_none(),
           key::object("origin", point_keys(), "A point.").or_none(),
           key::object("margin", {"margin", "", {key::number("x", "m", "x").or_else(7)}}, "")
               .or_empty(),
           key::objects("points", point_keys(), "Points.").or_empty(),
           key::named_objects("corners", point_keys(), "Points.").only("in tests")}};
}

ConfigReader reader(const Json& more = Json::object()) {
  Json json = {{"width", 4}};
  json.update(more);
  return {json, "a.json", all_keys()};
}

using Reading = std::function<void(ConfigReader&)>;

/// Reading the one value is refused.
void expect_refused(const Json& json, const Reading& reading,
                    const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>(
      [&] {
        auto in = reader(json);
        reading(in);
      },
      parts);
}

TEST(ConfigReader, values_that_are_there) {
  const Json json = {
      {"height", 0},     {"depth", 1.5},      {"weight", -3},         {"limit", nullptr},
      {"count", 7},      {"parts", 2},        {"closed", false},      {"painted", true},
      {"file", "b.msh"}, {"colour", "green"}, {"shade", "light"},     {"gravity", {0, -9.81}},
      {"cells", {4, 2}}, {"sides", {"left"}}, {"groups", {"a", "b"}}, {"table", {{0, 1}, {2, 3}}}};
  auto in = reader(json);
  EXPECT_EQ(in.number("width"), 4);
  EXPECT_EQ(in.number("height"), 0);
  EXPECT_EQ(in.number_or("depth", 9), 1.5);
  EXPECT_EQ(in.optional_number("weight"), -3);
  EXPECT_FALSE(in.number_or_null("limit"));
  EXPECT_EQ(in.integer("count"), 7);
  EXPECT_EQ(in.integer_or("parts", 9), 2);
  EXPECT_FALSE(in.boolean("closed"));
  EXPECT_TRUE(in.boolean_or("painted", false));
  EXPECT_EQ(in.text("file"), "b.msh");
  EXPECT_EQ(in.choice("colour"), "green");
  EXPECT_EQ(in.choice_or("shade", "dark"), "light");
  EXPECT_EQ(in.vector("gravity", 2), (std::vector<double>{0, -9.81}));
  EXPECT_EQ(in.integers("cells", 2), (std::vector<int>{4, 2}));
  EXPECT_EQ(in.texts_or("sides", {}), std::vector<std::string>{"left"});
  EXPECT_EQ(in.texts("groups"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(in.rows("table", 2), (std::vector<std::vector<double>>{{0, 1}, {2, 3}}));
  Json all = json;
  all["width"] = 4;
  EXPECT_EQ(in.resolved(), all);
}

TEST(ConfigReader, a_vector_of_a_dimension_that_is_not_known_yet) {
  const KeyTable table = {"arm", "", {key::vector("arm", "m", "An arm.").or_none()}};
  const auto arm = [&](const Json& json) {
    return ConfigReader(json, "a.json", table).optional_vector("arm");
  };
  EXPECT_EQ(arm({{"arm", {1, 2}}}), (std::vector<double>{1, 2}));
  EXPECT_EQ(arm({{"arm", {1, 2, 3}}}), (std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(arm(Json::object()));
  for (const Json& wrong : {Json{1}, Json{1, 2, 3, 4}, Json("x")}) {
    expect_error<ConfigError>(
        [&] {
          arm({{"arm", wrong}});
        },
        {"at /arm", "allowed: a list of 2 or 3 numbers"});
  }
}

TEST(ConfigReader, missing_keys_take_the_defaults_of_the_table_and_show_them) {
  auto in = reader();
  EXPECT_EQ(in.number("height"), 2);
  EXPECT_EQ(in.number_or("depth", 9), 9);
  EXPECT_FALSE(in.optional_number("weight"));
  EXPECT_EQ(in.number_or_null("limit"), 0.5);
  EXPECT_EQ(in.integer("count"), 3);
  EXPECT_EQ(in.integer_or("parts", 9), 9);
  EXPECT_TRUE(in.boolean("closed"));
  EXPECT_FALSE(in.boolean_or("painted", false));
  EXPECT_EQ(in.text("file"), "a.msh");
  EXPECT_EQ(in.choice("colour"), "red");
  EXPECT_EQ(in.choice_or("shade", "light"), "light");
  EXPECT_EQ(in.number("gloss"), 1);
  EXPECT_EQ(in.vector("gravity", 3), (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(in.texts_or("sides", {"x"}), std::vector<std::string>{"x"});
  EXPECT_FALSE(in.optional_object("origin"));
  EXPECT_EQ(in.object("margin").number("x"), 7);
  EXPECT_TRUE(in.objects("points").empty());
  const Json expected = {{"height", 2},      {"depth", 9},           {"limit", 0.5},
                         {"count", 3},       {"parts", 9},           {"closed", true},
                         {"painted", false}, {"file", "a.msh"},      {"colour", "red"},
                         {"shade", "light"}, {"gloss", 1},           {"gravity", {0, 0, 0}},
                         {"sides", {"x"}},   {"margin", {{"x", 7}}}, {"points", Json::array()}};
  EXPECT_EQ(in.resolved(), expected);
}

TEST(ConfigReader, errors_name_file_pointer_found_and_allowed) {
  const auto number = [](const char* key) { return [key](ConfigReader& in) { in.number(key); }; };
  expect_refused({{"width", 0}}, number("width"),
                 {"a.json: at /width: found 0, allowed: a number > 0"});
  expect_refused({{"width", "4"}}, number("width"),
                 {R"(found "4" (string), allowed: a number > 0)"});
  expect_refused({{"height", -1}}, number("height"), {"/height", "allowed: a number >= 0"});
  const auto count = [](ConfigReader& in) { in.integer("count"); };
  expect_refused({{"count", 2.5}}, count, {"found 2.5 (number), allowed: a whole number"});
  expect_refused({{"count", 0}}, count, {"found 0, allowed: a number >= 1"});
  expect_refused({{"count", 3000000000}}, count, {"allowed: a whole number below 2^31"});
  expect_refused({{"closed", 1}}, [](ConfigReader& in) { in.boolean("closed"); },
                 {"found 1 (number), allowed: true or false"});
  expect_refused({{"file", 1}}, [](ConfigReader& in) { in.text("file"); },
                 {"found 1 (number), allowed: a text"});
  expect_refused({{"colour", "gren"}}, [](ConfigReader& in) { in.choice("colour"); },
                 {R"(found "gren", allowed: red, green; did you mean "green"?)"});
  expect_refused({{"colour", "green"}}, [](ConfigReader& in) { in.choice("colour", {"red"}); },
                 {R"(found "green", allowed: red)"});
  expect_refused({{"height", 5}}, [](ConfigReader& in) { in.number("height", between(0, 4)); },
                 {"found 5, allowed: a number from 0 to 4"});
}

TEST(ConfigReader, errors_in_lists_name_the_entry) {
  const auto gravity = [](ConfigReader& in) { in.vector("gravity", 2); };
  expect_refused({{"gravity", {1}}}, gravity,
                 {"/gravity: found [1] (array), allowed: a list of 2"});
  expect_refused({{"gravity", {1, "x"}}}, gravity, {"/gravity/1: found \"x\" (string)"});
  const auto cells = [](ConfigReader& in) { in.integers("cells", 2); };
  expect_refused({{"cells", {1, 0}}}, cells, {"/cells/1: found 0, allowed: a number >= 1"});
  expect_refused({{"cells", {1, 1.5}}}, cells, {"/cells/1: found 1.5, allowed: a whole number"});
  expect_refused({{"cells", {1, 3e9}}}, cells,
                 {"/cells/1: found 3000000000, allowed: a whole number of at most 2e9"});
  const auto groups = [](ConfigReader& in) { in.texts("groups"); };
  expect_refused({{"groups", "a"}}, groups, {"/groups: found \"a\" (string), allowed: a list"});
  expect_refused({{"groups", {"a", 1}}}, groups, {"/groups/1: found 1 (number), allowed: a text"});
  const auto table = [](ConfigReader& in) { in.rows("table", 2); };
  expect_refused({{"table", 1}}, table, {"/table: found 1 (number), allowed: a list of lists"});
  expect_refused({{"table", {{0, 1}, {1}}}}, table, {"/table/1: found [1]", "a list of 2 numbers"});
  expect_refused({{"table", {{0, nullptr}}}}, table, {"/table/0/1: found null"});
  expect_refused({{"table", Json::array()}}, table, {"/table: found []", "at least one row"});
}

TEST(ConfigReader, a_missing_key_is_named_with_those_that_are_there) {
  expect_error<ConfigError>(
      [] { ConfigReader(Json::object(), "a.json", all_keys()).number("width"); },
      {"a.json: at /width: missing; found only: nothing"});
  expect_refused(Json::object(), [](ConfigReader& in) { in.integers("cells", 2); },
                 {"/cells: missing; found only: width"});
}

TEST(ConfigReader, objects_have_pointers_of_their_own) {
  const Json point = {{"name", "A"}, {"place", {1, 2}}};
  auto in = reader(
      {{"origin", point}, {"points", {point, {{"name", "B"}}}}, {"corners", {{"C", point}}}});
  EXPECT_EQ(in.object("origin").name("name"), "A");
  auto points = in.objects("points");
  EXPECT_EQ(points.at(1).vector("place", 2), (std::vector<double>{0, 0}));
  EXPECT_EQ(points.at(1).where("name"), "a.json: at /points/1/name");
  auto corners = in.named_objects("corners");
  EXPECT_EQ(corners.at(0).first, "C");
  EXPECT_EQ(corners.at(0).second.vector("place", 2), (std::vector<double>{1, 2}));
  EXPECT_EQ(in.resolved()["corners"]["C"]["place"], (Json{1, 2}));
  EXPECT_EQ(in.resolved()["points"][1]["place"], (Json{0, 0}));
}

TEST(ConfigReader, what_is_no_object_is_refused) {
  expect_error<ConfigError>([] { ConfigReader(Json(1), "a.json", all_keys()); },
                            {"a.json: at /: found 1 (number), allowed: an object"});
  expect_refused({{"origin", 1}}, [](ConfigReader& in) { in.object("origin"); },
                 {"at /origin: found 1 (number), allowed: an object"});
  expect_refused({{"points", {1}}}, [](ConfigReader& in) { in.objects("points"); },
                 {"at /points/0: found 1 (number), allowed: an object"});
  expect_refused({{"points", 1}}, [](ConfigReader& in) { in.objects("points"); },
                 {"found 1 (number), allowed: a list of objects"});
  expect_refused({{"corners", 1}}, [](ConfigReader& in) { in.named_objects("corners"); },
                 {"found 1 (number), allowed: an object of named objects"});
  expect_refused({{"corners", {{"a/b", Json::object()}}}},
                 [](ConfigReader& in) { in.named_objects("corners"); },
                 {"found the name \"a/b\", allowed: names without / and ~"});
}

TEST(ConfigReader, names_hold_letters_digits_and_little_else) {
  for (const std::string& name : {std::string("a b"), std::string(), std::string(65, 'a')}) {
    expect_refused({{"origin", {{"name", name}}}},
                   [](ConfigReader& in) { in.object("origin").name("name"); },
                   {"/origin/name", "allowed: 1 to 64 letters, digits, _ and -"});
  }
}

TEST(ConfigReader, alternatives_of_one_key) {
  const KeyTable table{"t",
                       "",
                       {key::number("k0", "", "").in(positive()), key::choice("k0", {"jaky"}, ""),
                        key::object("k0", point_keys(), "")}};
  EXPECT_EQ(ConfigReader({{"k0", 2}}, "f", table).number("k0"), 2);
  ConfigReader word({{"k0", "jaky"}}, "f", table);
  EXPECT_TRUE(word.is_text("k0"));
  EXPECT_FALSE(word.is_object("k0"));
  EXPECT_EQ(word.choice("k0"), "jaky");
  EXPECT_TRUE(ConfigReader({{"k0", Json::object()}}, "f", table).is_object("k0"));
}

TEST(ConfigReader, keys_of_one_name_take_turns_by_their_conditions) {
  const KeyTable table{"t",
                       "",
                       {key::choice("law", {"a", "b", "c"}, "").or_else("a"),
                        key::number("c", "", "").in(positive()).when("law", {"a"}),
                        key::number("c", "", "").in(non_negative()).or_else(1).when("law", {"b"})}};
  EXPECT_EQ(ConfigReader({{"law", "b"}}, "f", table).number("c"), 1);
  EXPECT_EQ(ConfigReader({{"law", "b"}, {"c", 0}}, "f", table).number("c"), 0);
  expect_error<ConfigError>([&] { ConfigReader({{"c", 0}}, "f", table).number("c"); }, {"> 0"});
  expect_error<ConfigError>(
      [&] {
        ConfigReader({{"law", "a"}}, "f", table).number("c");
      },
      {"/c: missing"});
  expect_error<std::logic_error>(
      [&] {
        ConfigReader({{"law", "c"}}, "f", table).number("c");
      },
      {"no key of this name and the type number applies"});
}

TEST(ConfigReader, keys_that_nobody_read_are_refused_with_the_nearest_one) {
  const auto finish = [](const Json& json) {
    ConfigReader in(json, "a.json", point_keys());
    in.name("name");
    in.vector("place", 2);
    in.finish();
  };
  EXPECT_NO_THROW(finish({{"name", "A"}}));
  expect_error<ConfigError>(
      [&] {
        finish({{"name", "A"}, {"plaec", {1, 2}}});
      },
      {R"(a.json: at /plaec: unknown key; did you mean "place"? Allowed: name, place)"});
}

TEST(ConfigReader, keys_for_other_circumstances_are_refused_with_these) {
  auto in = reader({{"groups", {"a"}}});
  expect_error<ConfigError>(
      [&] { in.finish(); },
      {"a.json: at /groups: found where it has no meaning, allowed only in tests"});
}

TEST(ConfigReader, mistakes_of_the_reading_code_are_no_errors_of_the_file) {
  const auto mistake = [](const Reading& reading, std::string_view part) {
    expect_error<std::logic_error>(
        [&] {
          auto in = reader();
          reading(in);
        },
        {"table \"all\"", part});
  };
  mistake([](ConfigReader& in) { in.has("with"); }, "no such key");
  mistake([](ConfigReader& in) { in.number("count"); }, "the type number");
  mistake([](ConfigReader& in) { in.number("depth"); }, "without the default");
  mistake([](ConfigReader& in) { in.number("weight"); }, "without the default");
  mistake([](ConfigReader& in) { in.number_or("height", 1); }, "another meaning of its absence");
  mistake([](ConfigReader& in) { in.optional_number("width"); }, "another meaning");
  mistake([](ConfigReader& in) { in.number_or_null("width"); }, "may be null");
  mistake([](ConfigReader& in) { in.choice("colour", {"blue"}); }, "\"blue\" is missing");
  mistake(
      [](ConfigReader& in) {
        in.number("width");
        in.finish();
      },
      "nobody has read this key");
}

TEST(NearestWord, the_fewest_letters_to_change) {
  EXPECT_EQ(nearest_word("penaltyy", {"friction", "penalty", "mode"}), "penalty");
  EXPECT_EQ(nearest_word("abc", {}), "");
}

}  // namespace
}  // namespace gabion::test_config_reader
