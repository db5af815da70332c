// SPDX-License-Identifier: BSD-3-Clause
// The part of ConfigReader that reads lists of numbers and texts.
#include <fmt/format.h>

#include <cmath>

#include "common/settings/config_reader.hpp"
#include "common/settings/shown.hpp"

namespace gabion {

std::vector<double> ConfigReader::given_numbers(const std::string& key, int count,
                                                const Range& range) {
  const Json& value = require_key(key);
  if (!value.is_array() || value.size() != static_cast<std::size_t>(count)) {
    fail(key, fmt::format("found {}, allowed: a list of {} numbers", shown(value), count));
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    result.push_back(checked_number(value[i], fmt::format("{}/{}", key, i), range));
  }
  note(key, value);
  return result;
}

std::vector<double> ConfigReader::vector(const std::string& key, int dim) {
  const Key& entry = key_of(key, KeyType::vector);
  if (!falls_back(entry)) return given_numbers(key, dim, entry.range);
  std::vector<double> result(static_cast<std::size_t>(dim), entry.fallback.get<double>());
  note(key, result);
  return result;
}

std::optional<std::vector<double>> ConfigReader::optional_vector(const std::string& key) {
  const Key& entry = key_of(key, KeyType::vector, Absence::none);
  if (!has(key)) return std::nullopt;
  const Json& value = require_key(key);
  const std::size_t size = value.is_array() ? value.size() : 0;
  if (size < entry.min_width || size > entry.max_width) {
    fail(key,
         fmt::format("found {}, allowed: a list of {} {} {} numbers", shown(value), entry.min_width,
                     entry.max_width - entry.min_width > 1 ? "to" : "or", entry.max_width));
  }
  return given_numbers(key, static_cast<int>(size), entry.range);
}

std::vector<int> ConfigReader::integers(const std::string& key, int count) {
  const Key& entry = key_of(key, KeyType::integers, Absence::refused);
  std::vector<int> result;
  const std::vector<double> found = given_numbers(key, count, entry.range);
  for (std::size_t i = 0; i < found.size(); ++i) {
    constexpr double largest = 2e9;
    if (found[i] != std::floor(found[i]) || std::abs(found[i]) > largest) {
      fail(fmt::format("{}/{}", key, i),
           fmt::format("found {}, allowed: a whole number{}", found[i],
                       std::abs(found[i]) > largest ? " of at most 2e9" : ""));
    }
    result.push_back(static_cast<int>(found[i]));
  }
  return result;
}

std::vector<std::string> ConfigReader::given_texts(const std::string& key) {
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

std::vector<std::string> ConfigReader::texts(const std::string& key) {
  key_of(key, KeyType::texts);
  return given_texts(key);
}

std::vector<std::string> ConfigReader::texts_or(const std::string& key,
                                                const std::vector<std::string>& computed) {
  key_of(key, KeyType::texts, Absence::computed);
  if (has(key)) return given_texts(key);
  note(key, computed);
  return computed;
}

std::vector<std::vector<double>> ConfigReader::rows(const std::string& key, int width) {
  const Key& entry = key_of(key, KeyType::rows);
  const Json& value = require_key(key);
  if (!value.is_array()) fail(key, fmt::format("found {}, allowed: a list of lists", shown(value)));
  if (value.empty() && entry.min_size > 0) {
    const bool one = entry.min_size == 1;
    fail(key, fmt::format("found [], allowed: at least {}",
                          one ? "one row" : fmt::format("{} rows", entry.min_size)));
  }
  std::vector<std::vector<double>> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const std::string row_key = fmt::format("{}/{}", key, i);
    if (!value[i].is_array() || value[i].size() != static_cast<std::size_t>(width)) {
      fail(row_key, fmt::format("found {}, allowed: a list of {} numbers", shown(value[i]), width));
    }
    std::vector<double> row;
    for (std::size_t j = 0; j < value[i].size(); ++j) {
      row.push_back(checked_number(value[i][j], fmt::format("{}/{}", row_key, j), entry.range));
    }
    result.push_back(std::move(row));
  }
  note(key, value);
  return result;
}

}  // namespace gabion
