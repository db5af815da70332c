// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>

#include "common/base/names.hpp"
#include "common/settings/describe_keys.hpp"

namespace gabion {

namespace {

Json list_of(const Json& items, std::size_t low, std::size_t high) {
  Json result = {{"type", "array"}, {"items", items}};
  if (low > 0) result["minItems"] = low;
  if (high > 0) result["maxItems"] = high;
  return result;
}

Json number_schema(const char* type, const Range& range) {
  Json result = {{"type", type}};
  if (std::isfinite(range.low)) result[range.low_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) {
    result[range.high_open ? "exclusiveMaximum" : "maximum"] = range.high;
  }
  return result;
}

Json words_schema(const std::vector<std::string>& words) {
  Json result = {{"type", "string"}};
  if (!words.empty()) result["enum"] = words;
  return result;
}

Json reference(const KeyTable& table) {
  return {{"$ref", "#/definitions/" + table.name}};
}

/// Schema of a value, without words.
Json shape(const Key& key) {
  switch (key.type) {
    case KeyType::number:
      return number_schema("number", key.range);
    case KeyType::integer:
      return number_schema("integer", key.range);
    case KeyType::boolean:
      return {{"type", "boolean"}};
    case KeyType::text:
      return {{"type", "string"}};
    case KeyType::name:
      return {{"type", "string"},
              {"pattern", fmt::format("^[A-Za-z0-9_-]{{1,{}}}$", max_name_size)}};
    case KeyType::choice:
      return words_schema(key.words);
    case KeyType::vector:
      return list_of(number_schema("number", key.range), key.min_width, key.max_width);
    case KeyType::integers:
      return list_of(number_schema("integer", key.range), key.min_width, key.max_width);
    case KeyType::texts:
      return list_of(words_schema(key.words), key.min_size, 0);
    case KeyType::rows:
      return list_of(list_of(number_schema("number", key.range), key.min_width, key.max_width),
                     key.min_size, 0);
    case KeyType::object:
      return reference(*key.table);
    case KeyType::objects:
      return list_of(reference(*key.table), key.min_size, 0);
    case KeyType::named_objects:
      return {{"type", "object"}, {"additionalProperties", reference(*key.table)}};
  }
  return {};
}

Json described(const Key& key) {
  Json value = shape(key);
  if (key.nullable) value["type"] = {value["type"], "null"};
  // Draft 7 does not look at anything that stands beside a $ref.
  if (value.contains("$ref")) value = {{"allOf", {value}}};
  value["description"] = key.sentence + (key.unit.empty() ? "" : " [" + key.unit + "]");
  if (key.absence == Absence::fallback && key.type != KeyType::vector) {
    value["default"] = key.fallback;
  }
  return value;
}

/// The value of a key that has several meanings.
Json any_of(const std::vector<Key>& keys) {
  if (keys.size() == 1) return described(keys.front());
  Json values = Json::array();
  for (const Key& key : keys) values.push_back(described(key));
  return {{"anyOf", values}};
}

std::vector<Key> keys_of(const KeyTable& table, const std::string& name) {
  std::vector<Key> result;
  for (const Key& key : table.keys) {
    if (key.name == name) result.push_back(key);
  }
  return result;
}

Json condition_schema(const Condition& condition, const KeyTable& table) {
  if (condition.words.empty()) {
    const Json given = {{"required", {condition.key}}};
    return condition.given ? given : Json{{"not", given}};
  }
  Json result = {{"properties", {{condition.key, {{"enum", condition.words}}}}}};
  bool has_default = false;
  for (const Key& key : keys_of(table, condition.key)) {
    for (const std::string& word : condition.words) has_default |= key.fallback == word;
  }
  if (!has_default) result["required"] = {condition.key};
  return result;
}

Json conditions_schema(const Key& key, const KeyTable& table) {
  Json all = Json::array();
  for (const Condition& condition : key.conditions) {
    all.push_back(condition_schema(condition, table));
  }
  return {{"allOf", all}};
}

bool same_conditions(const Key& a, const Key& b, const KeyTable& table) {
  return conditions_schema(a, table) == conditions_schema(b, table);
}

/// Rules that let a key stand where its conditions hold, and nowhere else.
void add_rules(const std::vector<Key>& keys, const KeyTable& table, Json& rules) {
  Json somewhere = Json::array();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Key& key = keys[i];
    if (key.conditions.empty()) return;
    somewhere.push_back(conditions_schema(key, table));
    if (i > 0 && same_conditions(keys[i - 1], key, table)) continue;
    std::vector<Key> alternatives;
    for (const Key& other : keys) {
      if (same_conditions(other, key, table)) alternatives.push_back(other);
    }
    Json then = Json::object();
    if (alternatives.size() < keys.size()) then["properties"][key.name] = any_of(alternatives);
    if (key.absence == Absence::refused && key.circumstances.empty()) then["required"] = {key.name};
    if (!then.empty()) rules.push_back({{"if", somewhere.back()}, {"then", then}});
  }
  const Json nowhere = {{"properties", {{keys.front().name, false}}}};
  rules.push_back({{"if", {{"anyOf", somewhere}}}, {"then", true}, {"else", nowhere}});
}

Json table_schema(const KeyTable& table) {
  Json result = {{"type", "object"},
                 {"description", table.sentence},
                 {"additionalProperties", false},
                 {"properties", Json::object()}};
  Json required = Json::array(), rules = Json::array();
  for (const Key& key : table.keys) {
    if (result["properties"].contains(key.name)) continue;
    const std::vector<Key> same = keys_of(table, key.name);
    result["properties"][key.name] = any_of(same);
    add_rules(same, table, rules);
    const bool always = key.conditions.empty() && key.circumstances.empty();
    if (always && key.absence == Absence::refused) required.push_back(key.name);
  }
  if (!required.empty()) result["required"] = required;
  if (!rules.empty()) result["allOf"] = rules;
  for (const std::string& name : table.one_of) result["oneOf"].push_back({{"required", {name}}});
  return result;
}

void define(const KeyTable& table, Json& definitions) {
  for (const Key& key : table.keys) {
    if (!key.table || definitions.contains(key.table->name)) continue;
    definitions[key.table->name] = table_schema(*key.table);
    define(*key.table, definitions);
  }
}

}  // namespace

Json keys_as_schema(const KeyTable& root, const std::string& file) {
  Json result = table_schema(root);
  result["$schema"] = "http://json-schema.org/draft-07/schema#";
  result["title"] = file;
  result["definitions"] = Json::object();
  define(root, result["definitions"]);
  return result;
}

}  // namespace gabion
