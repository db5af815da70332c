// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

namespace gabion {

using Json = nlohmann::json;

/// A condition on a number, with the words that an error message uses for it.
struct Range {
  std::function<bool(double)> holds;
  std::string allowed;
};

Range any_number();
Range positive();
Range non_negative();
Range between(double low, double high);  ///< both ends allowed
Range at_least(double low);

/// Strict reader of one JSON object. Every key is read by name; `finish()` refuses keys that nobody
/// read and names the nearest known one. Errors carry file, JSON pointer, found and allowed.
///
/// Values that were read, defaults included, are collected in `resolved()`: what a run really used.
class ConfigReader {
 public:
  /// @param file  name for error messages, such as "configs/slide/mpm.json"
  ConfigReader(const Json& value, std::string file);

  bool has(const std::string& key) const;
  /// Whether the key is there and holds a text.
  bool is_text(const std::string& key) const;
  bool is_object(const std::string& key) const;

  double number(const std::string& key, const Range& range = any_number());
  double number_or(const std::string& key, double fallback, const Range& range = any_number());
  /// A number, or null for none at all; `fallback` when the key is missing.
  std::optional<double> number_or_null(const std::string& key, double fallback,
                                       const Range& range = any_number());
  int integer(const std::string& key, const Range& range = any_number());
  int integer_or(const std::string& key, int fallback, const Range& range = any_number());
  bool boolean_or(const std::string& key, bool fallback);
  std::string text(const std::string& key);
  /// A text of 1 to 64 letters, digits, "_" and "-".
  std::string name(const std::string& key);
  std::string text_or(const std::string& key, const std::string& fallback);
  /// One of the allowed words.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed);
  std::string choice_or(const std::string& key, const std::vector<std::string>& allowed,
                        const std::string& fallback);
  /// Numbers; `count` < 0 accepts any length.
  std::vector<double> numbers(const std::string& key, int count = -1,
                              const Range& range = any_number());
  std::vector<double> numbers_or(const std::string& key, const std::vector<double>& fallback,
                                 int count = -1, const Range& range = any_number());
  std::vector<int> integers(const std::string& key, int count = -1,
                            const Range& range = any_number());
  std::vector<std::string> texts(const std::string& key);
  std::vector<std::string> texts_or(const std::string& key,
                                    const std::vector<std::string>& fallback);
  /// A list of lists of numbers, each of length `width`: points, for example.
  std::vector<std::vector<double>> rows(const std::string& key, int width);

  ConfigReader object(const std::string& key);
  std::optional<ConfigReader> optional_object(const std::string& key);
  /// A missing object reads like {}: its defaults appear in `resolved()`.
  ConfigReader object_or_empty(const std::string& key);
  std::vector<ConfigReader> objects(const std::string& key);
  std::vector<ConfigReader> objects_or_none(const std::string& key);
  /// Members of an object whose keys are free names: {"soil": {...}, "rock": {...}}.
  std::vector<std::pair<std::string, ConfigReader>> named_objects(const std::string& key);

  /// Refuse keys that nobody read. Call at the end of each read function.
  void finish() const;

  /// Throw ConfigError "<file>: at <pointer>/<key>: <message>".
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

  /// "<file>: at <pointer>/<key>"
  std::string where(const std::string& key) const;
  const std::string& file() const { return file_; }

  /// Everything read so far below the top object, defaults included.
  Json resolved() const { return *resolved_root_; }

 private:
  ConfigReader(const Json& value, std::string file, std::string pointer,
               std::shared_ptr<Json> resolved_root);

  const Json& require_key(const std::string& key) const;
  double checked_number(const Json& value, const std::string& key, const Range& range) const;
  void note(const std::string& key, const Json& value) const;
  ConfigReader child(const Json& value, const std::string& key) const;

  Json value_;
  std::string file_;
  std::string pointer_;
  mutable std::set<std::string> known_;
  std::shared_ptr<Json> resolved_root_;  // shared by the readers of one file
};

/// The candidate with the smallest edit distance to `word`; empty when there is none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace gabion
