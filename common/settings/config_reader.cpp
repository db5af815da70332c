// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/config_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/base/names.hpp"
#include "common/base/require.hpp"
#include "common/settings/shown.hpp"

namespace gabion {

ConfigReader::ConfigReader(const Json& value, std::string file, const KeyTable& table)
    : ConfigReader(value, std::move(file), "", std::make_shared<const KeyTable>(table),
                   std::make_shared<Json>(Json::object())) {}

ConfigReader::ConfigReader(const Json& value, std::string file, std::string pointer,
                           std::shared_ptr<const KeyTable> table,
                           std::shared_ptr<Json> resolved_root)
    : value_(value),
      file_(std::move(file)),
      pointer_(std::move(pointer)),
      table_(std::move(table)),
      resolved_root_(std::move(resolved_root)) {
  require<ConfigError>(value_.is_object(), "{}: at {}: found {}, allowed: an object {{...}}", file_,
                       pointer_.empty() ? "/" : pointer_, shown(value_));
}

std::string ConfigReader::where(const std::string& key) const {
  return fmt::format("{}: at {}/{}", file_, pointer_, key);
}

void ConfigReader::fail(const std::string& key, const std::string& message) const {
  throw ConfigError(fmt::format("{}: {}", where(key), message));
}

void ConfigReader::mistake(const std::string& key, const std::string& message) const {
  throw std::logic_error(fmt::format("{}: table \"{}\": {}", where(key), table_->name, message));
}

const Key& ConfigReader::key_of(const std::string& name, KeyType type) const {
  for (const Key& key : table_->keys) {
    if (key.name == name && key.type == type && applies(key, *table_, value_)) return key;
  }
  mistake(name, fmt::format("no key of this name and the type {} applies", type_name(type)));
}

const Key& ConfigReader::key_of(const std::string& name, KeyType type, Absence absence) const {
  const Key& key = key_of(name, type);
  if (key.absence != absence) mistake(name, "read with another meaning of its absence");
  return key;
}

/// Whether the default of the table takes the place of a missing key.
bool ConfigReader::falls_back(const Key& key) const {
  if (has(key.name) || key.absence == Absence::refused) return false;
  if (key.absence == Absence::fallback) return true;
  mistake(key.name, "read without the default that its table does not have");
}

bool ConfigReader::has(const std::string& key) const {
  const auto same = [&](const Key& entry) { return entry.name == key; };
  if (std::none_of(table_->keys.begin(), table_->keys.end(), same)) mistake(key, "no such key");
  known_.insert(key);
  return value_.contains(key);
}

const Json& ConfigReader::require_key(const std::string& key) const {
  known_.insert(key);
  if (!value_.contains(key)) {
    std::string present;
    for (const auto& item : value_.items()) present += (present.empty() ? "" : ", ") + item.key();
    fail(key, fmt::format("missing; found only: {}", present.empty() ? "nothing" : present));
  }
  return value_.at(key);
}

void ConfigReader::note(const std::string& key, const Json& value) const {
  known_.insert(key);
  (*resolved_root_)[Json::json_pointer(pointer_)][key] = value;
}

double ConfigReader::checked_number(const Json& value, const std::string& key,
                                    const Range& range) const {
  if (!value.is_number()) {
    fail(key, fmt::format("found {}, allowed: {}", shown(value), range.allowed));
  }
  const double number = value.get<double>();
  if (!std::isfinite(number) || !range.holds(number)) {
    fail(key, fmt::format("found {}, allowed: {}", value.dump(), range.allowed));
  }
  return number;
}

bool ConfigReader::is_text(const std::string& key) const {
  return has(key) && value_.at(key).is_string();
}

bool ConfigReader::is_object(const std::string& key) const {
  return has(key) && value_.at(key).is_object();
}

double ConfigReader::given_number(const std::string& key, const Range& range) {
  const double result = checked_number(require_key(key), key, range);
  note(key, result);
  return result;
}

double ConfigReader::number(const std::string& key) {
  return number(key, key_of(key, KeyType::number).range);
}

double ConfigReader::number(const std::string& key, const Range& range) {
  const Key& entry = key_of(key, KeyType::number);
  if (!falls_back(entry)) return given_number(key, range);
  note(key, entry.fallback);
  return entry.fallback.get<double>();
}

double ConfigReader::number_or(const std::string& key, double computed) {
  const Key& entry = key_of(key, KeyType::number, Absence::computed);
  if (has(key)) return given_number(key, entry.range);
  note(key, computed);
  return computed;
}

std::optional<double> ConfigReader::optional_number(const std::string& key) {
  const Key& entry = key_of(key, KeyType::number, Absence::none);
  if (!has(key)) return std::nullopt;
  return given_number(key, entry.range);
}

std::optional<double> ConfigReader::number_or_null(const std::string& key) {
  if (!key_of(key, KeyType::number).nullable) mistake(key, "read as one that may be null");
  if (!has(key) || !value_.at(key).is_null()) return number(key);
  note(key, nullptr);
  return std::nullopt;
}

int ConfigReader::given_integer(const std::string& key, const Range& range) {
  const Json& value = require_key(key);
  if (!value.is_number_integer()) {
    fail(key, fmt::format("found {}, allowed: a whole number", shown(value)));
  }
  const double result = checked_number(value, key, range);
  if (std::abs(result) > std::numeric_limits<int>::max()) {
    fail(key, fmt::format("found {}, allowed: a whole number below 2^31", value.dump()));
  }
  note(key, static_cast<int>(result));
  return static_cast<int>(result);
}

int ConfigReader::integer(const std::string& key) {
  const Key& entry = key_of(key, KeyType::integer);
  if (!falls_back(entry)) return given_integer(key, entry.range);
  note(key, entry.fallback);
  return entry.fallback.get<int>();
}

int ConfigReader::integer_or(const std::string& key, int computed) {
  const Key& entry = key_of(key, KeyType::integer, Absence::computed);
  if (has(key)) return given_integer(key, entry.range);
  note(key, computed);
  return computed;
}

bool ConfigReader::given_boolean(const std::string& key) {
  const Json& value = require_key(key);
  if (!value.is_boolean()) {
    fail(key, fmt::format("found {}, allowed: true or false", shown(value)));
  }
  note(key, value);
  return value.get<bool>();
}

bool ConfigReader::boolean(const std::string& key) {
  const Key& entry = key_of(key, KeyType::boolean);
  if (!falls_back(entry)) return given_boolean(key);
  note(key, entry.fallback);
  return entry.fallback.get<bool>();
}

bool ConfigReader::boolean_or(const std::string& key, bool computed) {
  key_of(key, KeyType::boolean, Absence::computed);
  if (has(key)) return given_boolean(key);
  note(key, computed);
  return computed;
}

std::string ConfigReader::given_text(const std::string& key) {
  const Json& value = require_key(key);
  if (!value.is_string()) fail(key, fmt::format("found {}, allowed: a text", shown(value)));
  note(key, value);
  return value.get<std::string>();
}

std::string ConfigReader::text(const std::string& key) {
  const Key& entry = key_of(key, KeyType::text);
  if (has(key) || entry.absence != Absence::fallback) return given_text(key);
  note(key, entry.fallback);
  return entry.fallback.get<std::string>();
}

std::string ConfigReader::name(const std::string& key) {
  key_of(key, KeyType::name, Absence::refused);
  const std::string result = given_text(key);
  if (!is_plain_name(result) || result.size() > max_name_size) {
    fail(key, fmt::format("found {}, allowed: 1 to {} letters, digits, _ and -",
                          shown(value_.at(key)), max_name_size));
  }
  return result;
}

std::string ConfigReader::given_choice(const std::string& key,
                                       const std::vector<std::string>& allowed) {
  const std::string found = given_text(key);
  if (std::find(allowed.begin(), allowed.end(), found) == allowed.end()) {
    fail(key, fmt::format("found \"{}\", allowed: {}; did you mean \"{}\"?", found,
                          fmt::join(allowed, ", "), nearest_word(found, allowed)));
  }
  return found;
}

std::string ConfigReader::choice(const std::string& key) {
  return choice(key, key_of(key, KeyType::choice).words);
}

std::string ConfigReader::choice(const std::string& key, const std::vector<std::string>& allowed) {
  const Key& entry = key_of(key, KeyType::choice);
  for (const std::string& word : allowed) {
    if (std::find(entry.words.begin(), entry.words.end(), word) == entry.words.end()) {
      mistake(key, fmt::format("the word \"{}\" is missing", word));
    }
  }
  if (!falls_back(entry)) return given_choice(key, allowed);
  note(key, entry.fallback);
  return entry.fallback.get<std::string>();
}

std::string ConfigReader::choice_or(const std::string& key, const std::string& computed) {
  const Key& entry = key_of(key, KeyType::choice, Absence::computed);
  if (has(key)) return given_choice(key, entry.words);
  note(key, computed);
  return computed;
}

ConfigReader ConfigReader::child(const Json& value, const std::string& key,
                                 const Key& entry) const {
  return ConfigReader(value, file_, pointer_ + "/" + key, entry.table, resolved_root_);
}

ConfigReader ConfigReader::object(const std::string& key) {
  const Key& entry = key_of(key, KeyType::object);
  const bool missing = !has(key) && entry.absence == Absence::empty;
  const Json value = missing ? Json::object() : require_key(key);
  note(key, Json::object());
  return child(value, key, entry);
}

std::optional<ConfigReader> ConfigReader::optional_object(const std::string& key) {
  key_of(key, KeyType::object, Absence::none);
  if (!has(key)) return std::nullopt;
  return object(key);
}

std::vector<ConfigReader> ConfigReader::objects(const std::string& key) {
  const Key& entry = key_of(key, KeyType::objects);
  const bool missing = !has(key) && entry.absence == Absence::empty;
  const Json value = missing ? Json::array() : require_key(key);
  if (!value.is_array()) {
    fail(key, fmt::format("found {}, allowed: a list of objects", shown(value)));
  }
  note(key, Json(value.size(), Json::object()));
  std::vector<ConfigReader> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    result.push_back(child(value[i], fmt::format("{}/{}", key, i), entry));
  }
  return result;
}

std::vector<std::pair<std::string, ConfigReader>> ConfigReader::named_objects(
    const std::string& key) {
  const Key& entry = key_of(key, KeyType::named_objects);
  const Json& value = require_key(key);
  if (!value.is_object()) {
    fail(key, fmt::format("found {}, allowed: an object of named objects", shown(value)));
  }
  note(key, Json::object());
  std::vector<std::pair<std::string, ConfigReader>> result;
  for (const auto& item : value.items()) {
    if (item.key().find_first_of("/~") != std::string::npos) {
      fail(key, fmt::format("found the name \"{}\", allowed: names without / and ~", item.key()));
    }
    result.emplace_back(item.key(),
                        child(item.value(), fmt::format("{}/{}", key, item.key()), entry));
  }
  return result;
}

void ConfigReader::finish() const {
  for (const auto& item : value_.items()) {
    if (known_.count(item.key())) continue;
    for (const Key& key : table_->keys) {
      if (key.name != item.key() || key.circumstances.empty()) continue;
      fail(key.name,
           fmt::format("found where it has no meaning, allowed only {}", key.circumstances));
    }
    const std::vector<std::string> known(known_.begin(), known_.end());
    fail(item.key(), fmt::format("unknown key; did you mean \"{}\"? Allowed: {}",
                                 nearest_word(item.key(), known), fmt::join(known, ", ")));
  }
  for (const Key& key : table_->keys) {
    const bool expected = key.circumstances.empty() && applies(key, *table_, value_);
    if (expected && !known_.contains(key.name)) mistake(key.name, "nobody has read this key");
  }
}

}  // namespace gabion
