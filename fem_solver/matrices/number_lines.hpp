// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gabion::fem {

/// Goes through a text file of numbers line by line. Numbers stand apart by blanks, commas and
/// semicolons; empty lines and those that begin with # or % are passed over, and so is a first line
/// of words.
class NumberLines {
 public:
  /// @param separators  what else stands between numbers
  /// @throws ConfigError  the file cannot be opened
  explicit NumberLines(std::string path, std::string separators = "");

  /// The next line as it is, without its end. No line of words may follow it.
  std::string_view raw_line();
  /// Numbers of the next line; empty: there is none. Valid until the next call.
  /// @throws ConfigError  something that is no finite number
  std::span<const double> next();
  /// Like next(), for a line of `count` numbers, or of none at the end.
  std::span<const double> next(std::size_t count, const char* meaning);

  /// A number of the last line as a whole one.
  /// @throws ConfigError  it is not whole, or not in [low, high]
  std::int64_t whole(double value, std::int64_t low, std::int64_t high, const char* meaning) const;

  /// Throw ConfigError "<path>:<number of the last line>: <message>".
  [[noreturn]] void fail(const std::string& message) const;
  const std::string& path() const { return path_; }

 private:
  std::string_view take_line();
  bool parse(std::string_view line);

  std::string path_;
  std::string separators_;
  std::string text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 0;
  bool first_ = true;
  std::vector<double> values_;
};

}  // namespace gabion::fem
