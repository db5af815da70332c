// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gabion {

Range any_number() {
  return {.allowed = "any finite number"};
}
Range positive() {
  return {.low = 0, .low_open = true, .allowed = "a number > 0"};
}
Range non_negative() {
  return {.low = 0, .allowed = "a number >= 0"};
}
Range between(double low, double high) {
  return {.low = low, .high = high, .allowed = fmt::format("a number from {} to {}", low, high)};
}
Range inside(double low, double high) {
  return {.low = low,
          .high = high,
          .low_open = true,
          .high_open = true,
          .allowed = fmt::format("a number between {} and {}, both excluded", low, high)};
}
Range at_least(double low) {
  return {.low = low, .allowed = fmt::format("a number >= {}", low)};
}
Range in_words(Range range, const std::string& allowed) {
  range.allowed = allowed;
  return range;
}

namespace {

Key made(const std::string& name, KeyType type, const std::string& unit,
         const std::string& sentence) {
  Key key;
  key.name = name;
  key.type = type;
  key.unit = unit;
  key.sentence = sentence;
  return key;
}

Key with_table(Key key, const KeyTable& table) {
  key.table = std::make_shared<const KeyTable>(table);
  return key;
}

template <class Change>
Key changed(Key key, const Change& change) {
  change(key);
  return key;
}

}  // namespace

Key Key::in(const Range& allowed) const {
  return changed(*this, [&](Key& key) { key.range = allowed; });
}
Key Key::or_else(const Json& value) const {
  return changed(*this, [&](Key& key) {
    key.absence = Absence::fallback;
    key.fallback = value;
  });
}
Key Key::or_computed(const std::string& words_for_it) const {
  return changed(*this, [&](Key& key) {
    key.absence = Absence::computed;
    key.computed = words_for_it;
  });
}
Key Key::or_none() const {
  return changed(*this, [](Key& key) { key.absence = Absence::none; });
}
Key Key::or_empty() const {
  return changed(*this, [](Key& key) { key.absence = Absence::empty; });
}
Key Key::or_null() const {
  return changed(*this, [](Key& key) { key.nullable = true; });
}
Key Key::when(const std::string& other, const std::vector<std::string>& its_words) const {
  return changed(*this, [&](Key& key) { key.conditions.push_back({other, its_words}); });
}
Key Key::with(const std::string& other) const {
  return changed(*this, [&](Key& key) { key.conditions.push_back({other}); });
}
Key Key::without(const std::string& other) const {
  return changed(*this, [&](Key& key) { key.conditions.push_back({other, {}, false}); });
}
Key Key::among(const std::vector<std::string>& allowed) const {
  return changed(*this, [&](Key& key) { key.words = allowed; });
}
Key Key::only(const std::string& in_words) const {
  return changed(*this, [&](Key& key) { key.circumstances = in_words; });
}
Key Key::not_empty(std::size_t size) const {
  return changed(*this, [&](Key& key) { key.min_size = size; });
}
Key Key::wide(std::size_t low, std::size_t high) const {
  return changed(*this, [&](Key& key) {
    key.min_width = low;
    key.max_width = high;
  });
}

namespace key {

Key number(const std::string& name, const std::string& unit, const std::string& sentence) {
  return made(name, KeyType::number, unit, sentence);
}
Key integer(const std::string& name, const std::string& sentence) {
  return made(name, KeyType::integer, "", sentence);
}
Key boolean(const std::string& name, const std::string& sentence) {
  return made(name, KeyType::boolean, "", sentence);
}
Key text(const std::string& name, const std::string& sentence) {
  return made(name, KeyType::text, "", sentence);
}
Key plain_name(const std::string& sentence) {
  return made("name", KeyType::name, "", sentence);
}
Key choice(const std::string& name, const std::vector<std::string>& words,
           const std::string& sentence) {
  return changed(made(name, KeyType::choice, "", sentence),
                 [&](Key& made_key) { made_key.words = words; });
}
Key vector(const std::string& name, const std::string& unit, const std::string& sentence) {
  return made(name, KeyType::vector, unit, sentence).wide(2, 3);
}
Key integers(const std::string& name, const std::string& sentence) {
  return made(name, KeyType::integers, "", sentence).wide(2, 3);
}
Key texts(const std::string& name, const std::string& sentence) {
  return made(name, KeyType::texts, "", sentence);
}
Key rows(const std::string& name, const std::string& unit, const std::string& sentence) {
  return made(name, KeyType::rows, unit, sentence);
}
Key object(const std::string& name, const KeyTable& table, const std::string& sentence) {
  return with_table(made(name, KeyType::object, "", sentence), table);
}
Key objects(const std::string& name, const KeyTable& table, const std::string& sentence) {
  return with_table(made(name, KeyType::objects, "", sentence), table);
}
Key named_objects(const std::string& name, const KeyTable& table, const std::string& sentence) {
  return with_table(made(name, KeyType::named_objects, "", sentence), table);
}
Key schema() {
  return text("$schema",
              "Path of this file's schema (docs/keys), for editors; the programs do not use it.")
      .or_none();
}

}  // namespace key

namespace {

/// The text that a key has in an object, or its default; empty: neither.
std::string word_of(const std::string& name, const KeyTable& table, const Json& object) {
  if (object.contains(name)) {
    return object.at(name).is_string() ? object.at(name).get<std::string>() : "";
  }
  for (const Key& key : table.keys) {
    if (key.name == name && key.fallback.is_string()) return key.fallback.get<std::string>();
  }
  return "";
}

}  // namespace

bool applies(const Key& key, const KeyTable& table, const Json& object) {
  return std::all_of(key.conditions.begin(), key.conditions.end(), [&](const Condition& c) {
    if (c.words.empty()) return object.contains(c.key) == c.given;
    const std::string word = word_of(c.key, table, object);
    return std::find(c.words.begin(), c.words.end(), word) != c.words.end();
  });
}

const char* type_name(KeyType type) {
  switch (type) {
    case KeyType::number:
      return "number";
    case KeyType::integer:
      return "whole number";
    case KeyType::boolean:
      return "true or false";
    case KeyType::text:
      return "text";
    case KeyType::name:
      return "name";
    case KeyType::choice:
      return "word";
    case KeyType::vector:
      return "list of numbers";
    case KeyType::integers:
      return "list of whole numbers";
    case KeyType::texts:
      return "list of texts";
    case KeyType::rows:
      return "list of rows";
    case KeyType::object:
      return "object";
    case KeyType::objects:
      return "list of objects";
    case KeyType::named_objects:
      return "named objects";
  }
  return "";
}

}  // namespace gabion
