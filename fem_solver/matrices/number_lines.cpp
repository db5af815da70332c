// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/number_lines.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"

namespace gabion::fem {

NumberLines::NumberLines(std::string path, std::string separators)
    : path_(std::move(path)),
      separators_(" \t\r,;" + separators),
      text_(read_file(path_, "file of numbers")) {}

void NumberLines::fail(const std::string& message) const {
  throw ConfigError(fmt::format("{}:{}: {}", path_, line_, message));
}

std::string_view NumberLines::raw_line() {
  first_ = false;
  return take_line();
}

std::string_view NumberLines::take_line() {
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  const std::string_view line(text_.data() + at_, end - at_);
  at_ = std::min(end + 1, text_.size());
  ++line_;
  return line;
}

/// @returns whether the line holds numbers, which are in values_ then
bool NumberLines::parse(std::string_view line) {
  values_.clear();
  std::size_t i = line.find_first_not_of(separators_);
  if (i == std::string_view::npos || line[i] == '#' || line[i] == '%') return false;
  while (i < line.size()) {
    const std::size_t end = std::min(line.find_first_of(separators_, i), line.size());
    const std::string_view word = line.substr(i, end - i);
    double value = 0;
    const char* last = word.data() + word.size();
    const auto result = std::from_chars(word.data() + (word[0] == '+'), last, value);
    if (result.ec != std::errc() || result.ptr != last || !std::isfinite(value)) {
      if (first_ && values_.empty()) return false;  // names of columns
      fail(fmt::format("found \"{}\", allowed: a finite number", word));
    }
    values_.push_back(value);
    i = std::min(line.find_first_not_of(separators_, end), line.size());
  }
  return true;
}

std::span<const double> NumberLines::next() {
  while (at_ < text_.size()) {
    const std::string_view line = take_line();
    const bool found = parse(line);
    if (!line.empty()) first_ = false;
    if (found) return values_;
  }
  return {};
}

std::span<const double> NumberLines::next(std::size_t count, const char* meaning) {
  const auto values = next();
  if (!values.empty() && values.size() != count) {
    fail(fmt::format("found {} numbers, allowed: {} ({})", values.size(), count, meaning));
  }
  return values;
}

std::int64_t NumberLines::whole(double value, std::int64_t low, std::int64_t high,
                                const char* meaning) const {
  const bool good = value == std::floor(value) && value >= static_cast<double>(low) &&
                    value <= static_cast<double>(high);
  if (!good) {
    fail(fmt::format("found {} as {}, allowed: a whole number from {} to {}", value, meaning, low,
                     high));
  }
  return static_cast<std::int64_t>(value);
}

}  // namespace gabion::fem
