// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/settings/keys.hpp"
#include "common/settings/nearest_word.hpp"

namespace gabion {

/// Strict reader of one JSON object. The table of the object says which keys there are, with type,
/// range and default; the reading code names a key and gets its value. `finish()` refuses keys that
/// nobody read and names the nearest known one. Errors carry file, JSON pointer, found and allowed.
///
/// Values that were read, defaults included, are collected in `resolved()`: what a run really used,
/// as a file that reads as the same.
///
/// A key that the table lacks, or has with another type or default than the function asks for, is a
/// mistake of the reading code: std::logic_error.
class ConfigReader {
 public:
  /// @param file  name for error messages, such as "configs/slide/mpm.json"
  ConfigReader(const Json& value, std::string file, const KeyTable& table);

  bool has(const std::string& key) const;
  /// Whether the key is there and holds a text.
  bool is_text(const std::string& key) const;
  bool is_object(const std::string& key) const;

  // A missing key gives the default of the table, or an error where it has none.
  double number(const std::string& key);
  int integer(const std::string& key);
  bool boolean(const std::string& key);
  std::string text(const std::string& key);
  std::string name(const std::string& key);
  std::string choice(const std::string& key);
  /// One a dimension of space.
  std::vector<double> vector(const std::string& key, int dim);
  std::vector<int> integers(const std::string& key, int count);
  std::vector<std::string> texts(const std::string& key);
  /// Each row of length `width`.
  std::vector<std::vector<double>> rows(const std::string& key, int width);

  // Like the readers of one key, but other settings narrow the range or the set of words.
  double number(const std::string& key, const Range& range);
  std::string choice(const std::string& key, const std::vector<std::string>& allowed);

  // A missing key gives `computed`, a default that follows from other settings.
  double number_or(const std::string& key, double computed);
  int integer_or(const std::string& key, int computed);
  bool boolean_or(const std::string& key, bool computed);
  std::string choice_or(const std::string& key, const std::string& computed);
  std::vector<std::string> texts_or(const std::string& key,
                                    const std::vector<std::string>& computed);

  // A missing key gives nothing.
  std::optional<double> optional_number(const std::string& key);
  /// A vector whose length follows from a dimension that is not known yet.
  std::optional<std::vector<double>> optional_vector(const std::string& key);
  std::optional<ConfigReader> optional_object(const std::string& key);
  /// null gives nothing, a missing key its default.
  std::optional<double> number_or_null(const std::string& key);

  ConfigReader object(const std::string& key);
  std::vector<ConfigReader> objects(const std::string& key);
  /// Members of an object whose keys are free names: {"soil": {...}, "rock": {...}}.
  std::vector<std::pair<std::string, ConfigReader>> named_objects(const std::string& key);

  /// Refuse keys that nobody read. Call at the end of each read function, which has to have asked
  /// for every key of the table that applies (`has` is enough).
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
               std::shared_ptr<const KeyTable> table, std::shared_ptr<Json> resolved_root);

  const Key& key_of(const std::string& name, KeyType type) const;
  const Key& key_of(const std::string& name, KeyType type, Absence absence) const;
  const Json& require_key(const std::string& key) const;
  bool falls_back(const Key& key) const;
  double given_number(const std::string& key, const Range& range);
  int given_integer(const std::string& key, const Range& range);
  bool given_boolean(const std::string& key);
  std::string given_text(const std::string& key);
  std::string given_choice(const std::string& key, const std::vector<std::string>& allowed);
  std::vector<double> given_numbers(const std::string& key, int count, const Range& range);
  std::vector<std::string> given_texts(const std::string& key);
  double checked_number(const Json& value, const std::string& key, const Range& range) const;
  void note(const std::string& key, const Json& value) const;
  ConfigReader child(const Json& value, const std::string& key, const Key& entry) const;
  [[noreturn]] void mistake(const std::string& key, const std::string& message) const;

  Json value_;
  std::string file_;
  std::string pointer_;
  std::shared_ptr<const KeyTable> table_;  // shared with the key of the table above
  mutable std::set<std::string> known_;
  std::shared_ptr<Json> resolved_root_;  // shared by the readers of one file
};

}  // namespace gabion
