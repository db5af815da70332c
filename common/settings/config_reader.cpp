// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/config_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/base/names.hpp"
#include "common/base/require.hpp"

namespace gabion {

Range any_number() {
  return {[](double) { return true; }, "any finite number"};
}
Range positive() {
  return {[](double x) { return x > 0; }, "a number > 0"};
}
Range non_negative() {
  return {[](double x) { return x >= 0; }, "a number >= 0"};
}
Range between(double low, double high) {
  return {[=](double x) { return low <= x && x <= high; },
          fmt::format("a number from {} to {}", low, high)};
}
Range at_least(double low) {
  return {[=](double x) { return x >= low; }, fmt::format("a number >= {}", low)};
}

namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1] ? 1 : 0)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string shown(const Json& value) {
  std::string text = value.dump();
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return fmt::format("{} ({})", text, value.type_name());
}

}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const auto& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

ConfigReader::ConfigReader(const Json& value, std::string file)
    : ConfigReader(value, std::move(file), "", std::make_shared<Json>(Json::object())) {}

ConfigReader::ConfigReader(const Json& value, std::string file, std::string pointer,
                           std::shared_ptr<Json> resolved_root)
    : value_(value),
      file_(std::move(file)),
      pointer_(std::move(pointer)),
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

bool ConfigReader::has(const std::string& key) const {
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

double ConfigReader::number(const std::string& key, const Range& range) {
  const double result = checked_number(require_key(key), key, range);
  note(key, result);
  return result;
}

double ConfigReader::number_or(const std::string& key, double fallback, const Range& range) {
  if (has(key)) return number(key, range);
  note(key, fallback);
  return fallback;
}

std::optional<double> ConfigReader::number_or_null(const std::string& key, double fallback,
                                                   const Range& range) {
  if (!has(key) || !value_.at(key).is_null()) return number_or(key, fallback, range);
  note(key, nullptr);
  return std::nullopt;
}

int ConfigReader::integer(const std::string& key, const Range& range) {
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

int ConfigReader::integer_or(const std::string& key, int fallback, const Range& range) {
  if (has(key)) return integer(key, range);
  note(key, fallback);
  return fallback;
}

bool ConfigReader::boolean_or(const std::string& key, bool fallback) {
  if (has(key)) {
    const Json& value = require_key(key);
    if (!value.is_boolean()) {
      fail(key, fmt::format("found {}, allowed: true or false", shown(value)));
    }
    fallback = value.get<bool>();
  }
  note(key, fallback);
  return fallback;
}

std::string ConfigReader::text(const std::string& key) {
  const Json& value = require_key(key);
  if (!value.is_string()) fail(key, fmt::format("found {}, allowed: a text", shown(value)));
  note(key, value);
  return value.get<std::string>();
}

std::string ConfigReader::name(const std::string& key) {
  const std::string result = text(key);
  if (!is_plain_name(result) || result.size() > max_name_size) {
    fail(key, fmt::format("found {}, allowed: 1 to {} letters, digits, _ and -",
                          shown(value_.at(key)), max_name_size));
  }
  return result;
}

std::string ConfigReader::text_or(const std::string& key, const std::string& fallback) {
  if (has(key)) return text(key);
  note(key, fallback);
  return fallback;
}

std::string ConfigReader::choice(const std::string& key, const std::vector<std::string>& allowed) {
  const std::string found = text(key);
  if (std::find(allowed.begin(), allowed.end(), found) == allowed.end()) {
    fail(key, fmt::format("found \"{}\", allowed: {}; did you mean \"{}\"?", found,
                          fmt::join(allowed, ", "), nearest_word(found, allowed)));
  }
  return found;
}

std::string ConfigReader::choice_or(const std::string& key, const std::vector<std::string>& allowed,
                                    const std::string& fallback) {
  if (has(key)) return choice(key, allowed);
  note(key, fallback);
  return fallback;
}

std::vector<double> ConfigReader::numbers(const std::string& key, int count, const Range& range) {
  const Json& value = require_key(key);
  if (!value.is_array() || (count >= 0 && value.size() != static_cast<std::size_t>(count))) {
    fail(key, fmt::format("found {}, allowed: a list of {} numbers", shown(value),
                          count < 0 ? "any count of" : std::to_string(count)));
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    result.push_back(checked_number(value[i], fmt::format("{}/{}", key, i), range));
  }
  note(key, value);
  return result;
}

std::vector<double> ConfigReader::numbers_or(const std::string& key,
                                             const std::vector<double>& fallback, int count,
                                             const Range& range) {
  if (has(key)) return numbers(key, count, range);
  note(key, fallback);
  return fallback;
}

std::vector<int> ConfigReader::integers(const std::string& key, int count, const Range& range) {
  std::vector<int> result;
  const std::vector<double> found = numbers(key, count, range);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] != std::floor(found[i]) || std::abs(found[i]) > 2e9) {
      fail(fmt::format("{}/{}", key, i),
           fmt::format("found {}, allowed: a whole number", found[i]));
    }
    result.push_back(static_cast<int>(found[i]));
  }
  return result;
}

std::vector<std::string> ConfigReader::texts(const std::string& key) {
  const Json& value = require_key(key);
  if (!value.is_array()) fail(key, fmt::format("found {}, allowed: a list of texts", shown(value)));
  std::vector<std::string> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value[i].is_string()) {
      fail(fmt::format("{}/{}", key, i), fmt::format("found {}, allowed: a text", shown(value[i])));
    }
    result.push_back(value[i].get<std::string>());
  }
  note(key, value);
  return result;
}

std::vector<std::string> ConfigReader::texts_or(const std::string& key,
                                                const std::vector<std::string>& fallback) {
  if (has(key)) return texts(key);
  note(key, fallback);
  return fallback;
}

std::vector<std::vector<double>> ConfigReader::rows(const std::string& key, int width) {
  const Json& value = require_key(key);
  if (!value.is_array()) fail(key, fmt::format("found {}, allowed: a list of lists", shown(value)));
  std::vector<std::vector<double>> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const std::string row_key = fmt::format("{}/{}", key, i);
    if (!value[i].is_array() || value[i].size() != static_cast<std::size_t>(width)) {
      fail(row_key, fmt::format("found {}, allowed: a list of {} numbers", shown(value[i]), width));
    }
    std::vector<double> row;
    for (std::size_t j = 0; j < value[i].size(); ++j) {
      row.push_back(checked_number(value[i][j], fmt::format("{}/{}", row_key, j), any_number()));
    }
    result.push_back(std::move(row));
  }
  note(key, value);
  return result;
}

ConfigReader ConfigReader::child(const Json& value, const std::string& key) const {
  return ConfigReader(value, file_, pointer_ + "/" + key, resolved_root_);
}

ConfigReader ConfigReader::object(const std::string& key) {
  const Json& value = require_key(key);
  note(key, Json::object());
  return child(value, key);
}

std::optional<ConfigReader> ConfigReader::optional_object(const std::string& key) {
  if (!has(key)) return std::nullopt;
  return object(key);
}

ConfigReader ConfigReader::object_or_empty(const std::string& key) {
  if (has(key)) return object(key);
  note(key, Json::object());
  return child(Json::object(), key);
}

std::vector<ConfigReader> ConfigReader::objects(const std::string& key) {
  const Json& value = require_key(key);
  if (!value.is_array()) {
    fail(key, fmt::format("found {}, allowed: a list of objects", shown(value)));
  }
  note(key, Json::array());
  std::vector<ConfigReader> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    result.push_back(child(value[i], fmt::format("{}/{}", key, i)));
  }
  return result;
}

std::vector<ConfigReader> ConfigReader::objects_or_none(const std::string& key) {
  if (has(key)) return objects(key);
  note(key, Json::array());
  return {};
}

std::vector<std::pair<std::string, ConfigReader>> ConfigReader::named_objects(
    const std::string& key) {
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
    result.emplace_back(item.key(), child(item.value(), fmt::format("{}/{}", key, item.key())));
  }
  return result;
}

void ConfigReader::finish() const {
  for (const auto& item : value_.items()) {
    if (known_.count(item.key())) continue;
    const std::vector<std::string> known(known_.begin(), known_.end());
    fail(item.key(), fmt::format("unknown key; did you mean \"{}\"? Allowed: {}",
                                 nearest_word(item.key(), known), fmt::join(known, ", ")));
  }
}

}  // namespace gabion
